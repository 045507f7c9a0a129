// The charts of one triad: its residuals on chosen axes and in order, which poses gained, those that
// are held out, and what an expression explains.
const BenchCharts = (() => {
"use strict";
const { node, span, plot, course, HEIGHT, FOOT } = drawing;
const PHASE = "phase of the plate [°]", OF_FIT = ["residual [sd]", "residual left out [sd]"];

const titled = (mark, text) => { mark.append(node("title", {}, text)); return mark; };

return class {
  constructor(bench) {
    this.bench = bench;
    this.section = bench.section;
    for (const name of ["x", "y", "colour", "from", "to"]) {
      bench.part(name).addEventListener("change", () => this.draw());
    }
  }

  // The quantities of the axes, which come after the page.
  arrive({ columns, phase, quantiles }) {
    Object.assign(this, { columns, phase, quantiles });
    const names = Object.keys(columns);
    if (phase.beside.some((parts) => parts.length)) names.push(PHASE);
    const fill = (part, all) => this.bench.part(part).replaceChildren(...all.map((each) => new Option(each, each)));
    fill("x", [...names, ...OF_FIT]);
    fill("y", [...OF_FIT, ...names]);
    fill("colour", ["none", ...OF_FIT, ...names]);
  }

  draw() {
    if (!this.columns) return;  // on their way
    this.scatter();
    this.normal();
    this.gain();
    this.held();
  }

  values(name) {
    const { refitted, triad } = this.section;
    if (!OF_FIT.includes(name)) return this.columns[name];
    const residual = name === OF_FIT[0] ? refitted.residual : refitted.left_out ?? triad.left_out;
    return residual.map((value, k) => value / triad.sd[k]);
  }

  dot(k, x, y, text) {
    const mark = node("circle", { "data-i": k, cx: x.toFixed(1), cy: y.toFixed(1), r: 4 });
    if (this.section.out.has(k)) mark.classList.add("left-out");
    return titled(mark, `${this.section.triad.shown[k]}: ${text}`);
  }

  // A dot for every pose; with the phase of the plate one for every part of its turns.
  scatter() {
    const names = ["x", "y", "colour"].map((name) => this.bench.part(name).value), [across, upward, colour] = names;
    const { triad } = this.section, byPhase = names.includes(PHASE);
    const columns = names.map((name) => (name === PHASE || name === "none" ? null : this.values(name)));
    const value = (a, k, j) => (names[a] === PHASE ? this.phase.angle_deg[j]
      : columns[a][k] + (byPhase && OF_FIT.includes(names[a]) ? this.phase.beside[k][j] / triad.sd[k] : 0));
    const dots = triad.labels.flatMap((_, k) => (byPhase ? this.phase.beside[k].map((__, j) => [k, j]) : [[k, 0]]));
    const [xs, ys] = [0, 1].map((a) => dots.map(([k, j]) => value(a, k, j)));
    const { svg, x, y } = plot(span(xs), span(ys), across, upward, `${upward} against ${across}, a dot for every ${byPhase ? "twelfth of a turn of every pose on the plate" : "pose"}.`);
    const shades = colour === "none" ? null : dots.map(([k, j]) => value(2, k, j)), range = shades && span(shades);
    dots.forEach(([k], i) => {
      const mark = this.dot(k, x(xs[i]), y(ys[i]), `${drawing.short(xs[i])}, ${drawing.short(ys[i])}`);
      if (byPhase) mark.setAttribute("r", 2.5);
      if (shades) mark.style.fill = `hsl(${(240 - 240 * (shades[i] - range[0]) / (range[1] - range[0])).toFixed(0)} 75% 48%)`;
      svg.append(mark);
    });
    this.bench.part("scatter").replaceChildren(svg);
    this.bench.part("scatter-words").textContent = [
      byPhase ? "The phase counts from the beginning of each pose; what the model leaves comes back once or twice per turn where the plate or the sensor leans." : "",
      shades ? `Blue is ${drawing.short(Math.min(...shades))}, red ${drawing.short(Math.max(...shades))}.` : ""].join(" ");
  }

  normal() {
    const { several_rows: several } = this.section.triad, all = this.values(OF_FIT[0]);
    const places = all.map((_, k) => k).filter((k) => !several[k]).sort((a, b) => all[a] - all[b]);
    const { z, low, high } = this.quantiles;
    this.bench.part("normal").closest("figure").hidden = places.length === 0;
    if (places.length === 0 || places.length !== z.length) return;
    const chart = plot(span(z), span([...low, ...high, ...places.map((k) => all[k])]),
      "normal quantile", "residual [sd]", "Ordered residuals against normal quantiles with their band.");
    const band = course(chart, [...z, ...[...z].reverse()], [...low, ...[...high].reverse()]);
    chart.svg.append(node("path", { class: "band-of-normal", d: `${band}z` }),
      ...places.map((k, i) => this.dot(k, chart.x(z[i]), chart.y(all[k]), `${drawing.short(all[k])} sd`)));
    this.bench.part("normal").replaceChildren(chart.svg);
  }

  // The poses that were fitted, then those that no fit has seen; outlines are before the ticks.
  held() {
    const { held_out: after, residual } = this.section.refitted, before = this.bench.heldAsRun, { unit } = this.section.triad;
    if (!before || !after) return;
    const words = this.bench.part("held-words"), by = ({ rms }) => `${drawing.short(rms ?? NaN)} ${unit}`;
    words.textContent = after.problem ?? `On the ${after.labels.length} poses of ${after.name}, which no fit has seen, `
      + `this model errs by ${by(after)}; the model of the file by ${by(before)}; its own model, fitted to them, by `
      + `${by({ rms: after.own_rms })}. Where these lie far apart it is another sensor, or the sensor changed.`;
    this.bench.part("held-chart").replaceChildren();
    if (after.problem) return;
    const was = [...this.section.asFitted.residual, ...(before.residual ?? [])], now = [...residual, ...after.residual];
    const { svg, x, y } = plot([0, now.length], span([0, ...was, ...now]), "fitted poses | held out",
      `residual [${unit}]`, words.textContent);
    svg.append(node("path", { class: "zero", d: `M${x(residual.length)} 10V${HEIGHT - FOOT}` }));
    was.forEach((value, k) => svg.append(node("circle", { class: "ghost", cx: x(k + 0.5), cy: y(value), r: 3 })));
    residual.forEach((value, k) => {
      const mark = this.dot(k, x(k + 0.5), y(value), drawing.short(value));
      mark.classList.add("fitted");
      svg.append(mark);
    });
    after.residual.forEach((value, i) => svg.append(titled(
      node("circle", { class: "held", cx: x(residual.length + i + 0.5), cy: y(value), r: 4 }),
      `${after.labels[i]}: ${drawing.short(value)} ${unit}, ${drawing.short(value / after.sd[i])} sd`)));
    this.bench.part("held-chart").append(svg);
  }

  // By how much the squared prediction of every pose that takes no part falls, in sds.
  gain() {
    const [from, to] = ["from", "to"].map((name) => this.bench.tried[Number(this.bench.part(name).value)]);
    const names = [from, to].map(this.bench.named);
    const words = this.bench.part("gain-words");
    this.bench.part("gain").hidden = from === to;
    if (from === to) {
      words.textContent = "Tick an effect or leave a pose out: the poses that gain stand here.";
      return;
    }
    const both = from.left_out.map((value, k) => value !== null && to.left_out[k] !== null);
    const gains = from.left_out.map((value, k) => (both[k] ? value ** 2 - to.left_out[k] ** 2 : 0));
    const { svg, x, y } = plot([0, gains.length], span([0, ...gains]), "pose", "fall of chi² by pose",
      `Which poses ${names[1]} predicts better than ${names[0]}.`);
    const wide = Math.max((x(1) - x(0)) * 0.75, 1);
    gains.forEach((value, k) => svg.append(titled(node("rect", {
      class: value < 0 ? "gain loss" : "gain", "data-i": k, x: x(k + 0.12), width: wide,
      y: Math.min(y(0), y(value)), height: Math.max(Math.abs(y(value) - y(0)), 0.5) }),
    `${this.section.triad.labels[k]}: ${drawing.short(value)}`)));
    this.bench.part("gain").replaceChildren(svg);
    const better = gains.filter((value) => value > 0).length;
    words.textContent = `${better} of ${both.filter(Boolean).length} poses are predicted better by ${names[1]} than by ${names[0]}.`;
  }

  // The residuals before an expression is added, and what it explains of them.
  fingerprint(text, before, after) {
    const { unit } = this.section.triad, pattern = before.map((value, k) => value - after[k]);
    const { svg, x, y } = plot([0, pattern.length], span([0, ...before, ...pattern]), "pose",
      `residual (dots) and what the expression explains (line) [${unit}]`, `Fingerprint of ${text} over the residuals.`);
    svg.append(node("path", { class: "effect", d: pattern.map((value, k) =>
      `${k ? "V" : `M${x(0)} `}${y(value).toFixed(1)}H${x(k + 1).toFixed(1)}`).join("") }),
    ...before.map((value, k) => this.dot(k, x(k + 0.5), y(value), drawing.short(value))));
    this.bench.part("fingerprint").replaceChildren(svg);
  }
};
})();
