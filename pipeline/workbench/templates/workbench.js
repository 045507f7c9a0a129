// The tools of a page that `pipeline open` serves: it asks Python for every fit, remembers what was
// tried, and writes what the screen shows into the configuration.
(() => {
"use strict";
const { node, span, plot, answered, asked, sent, droppable, WIDTH, HEIGHT, FOOT } = drawing;
const bar = document.querySelector(".bench-bar");
const status = bar.querySelector("[data-bench-status]"), lines = bar.querySelector("[data-bench-lines]");
const button = (name) => bar.querySelector(`[data-bench-do="${name}"]`);
const MOST_STEPS = 100;  // of the history; chosen
const benches = [], PHASE = "phase of the plate [°]";
let page = null, undone = [], done = [], now = "", restoring = false, writing = false;

const state = () => ({
  triads: Object.fromEntries(page.sections.map(({ triad, order, out }) => [triad.triad,
    { ticked: order.map((effect) => effect.name), out: triad.labels.filter((_, k) => out.has(k)),
      back: [...benches.find((each) => each.section.triad === triad)?.back ?? []] }])),
  terms: Object.fromEntries(page.rateSections.flatMap(({ rate, boxes }) => {
    const ticked = rate.terms.filter((_, i) => boxes[i].checked);
    const changed = rate.terms.some((term, i) => term.in_model !== boxes[i].checked);
    return changed ? [[rate.setting, ticked.map((term) => term.name)]] : [];
  })),
});

// The whole screen, also what the file has: a step of the history holds whatever is written since.
const screen = () => JSON.stringify({
  triads: Object.fromEntries(benches.map((each) => [each.section.triad.triad, {
    ticked: each.section.order.map((effect) => effect.name), without: each.without() }])),
  terms: Object.fromEntries(page.rateSections.map(({ rate, boxes }) =>
    [rate.setting, rate.terms.filter((_, i) => boxes[i].checked).map((term) => term.name)])),
});

function say(text, changed = []) {
  status.textContent = text;
  lines.hidden = changed.length === 0;
  lines.textContent = changed.map(({ line, before, after }) => [
    ...(before ? before.split("\n").map((one) => `− ${one}`) : []),
    ...(after ? after.split("\n").map((one, i) => `+ ${line + i}: ${one}`) : [])].join("\n")).join("\n");
}

// --- undo, redo, write ---------------------------------------------------------------------------

function remember() {
  const next = screen();
  if (restoring || next === now) return;
  done.push(now);
  undone = [];
  now = next;
  say("");
  heard();
  offer();
  further.update();
}

// Words after a step back or forth: on the screen alone, until it is written.
function stepped(what) {
  say(now === page.asRun ? `${what}: the screen is as the file.`
    : `${what} on the screen; the file has its model until "Write to config".`);
}

function offer() {
  button("undo").disabled = done.length === 0;
  button("redo").disabled = undone.length === 0;
  button("write").disabled = now === page.asRun && further.written === null;
  keep("history", { done: done.slice(-MOST_STEPS), undone, now: now === page.asRun ? null : now });
}

function restore(text) {
  const { triads, terms } = JSON.parse(text);
  restoring = true;
  for (const section of page.sections) {
    const bench = benches.find((each) => each.section === section);
    const { ticked, without } = triads[section.triad.triad] ?? { ticked: [], without: bench.excluded };
    bench.comesBack(bench.excluded.filter((label) => !without.includes(label)));
    section.order = ticked.map((name) => section.effects.find((effect) => effect.name === name))
      .filter(Boolean);
    section.out = new Set(without.map((label) => section.triad.labels.indexOf(label)).filter((k) => k >= 0));
    for (const effect of section.effects) {
      section.boxes.get(effect.name).checked = section.order.includes(effect);
    }
  }
  for (const { rate, boxes } of page.rateSections) {
    const ticked = terms[rate.setting];
    boxes.forEach((box, i) => {
      box.checked = ticked ? ticked.includes(rate.terms[i].name) : rate.terms[i].in_model;
    });
  }
  now = screen();
  page.sections.forEach((section) => section.update());
  page.rateSections.forEach((section) => section.update());
  restoring = false;
  offer();
  further.update();
}

const actions = {
  undo() { undone.push(now); restore(done.pop()); stepped("Undone"); },
  redo() { done.push(now); restore(undone.pop()); stepped("Done again"); },
  write() { write(state()); },
  further: further.open,
  async run() {
    button("run").disabled = writing = true;
    say("The session is run …");
    try {
      await asked("run");
      keep("history", null);  // the file is what was edited last
      location.reload();
    } catch (error) {
      button("run").disabled = writing = false;
      say(error.message);
    }
  },
};

async function write(shows, own = null) {
  button("write").disabled = writing = true;  // its own news are none
  say("The session is run with it …");
  try {
    const answer = await asked("write", { state: shows, own, further: further.written });
    shown.data = answer.data;  // an effect more is other data, and what was tried holds for it
    keep("written", answer);
    keep("history", { done, undone, now: null });
    benches.forEach((each) => each.keepTried());
    location.reload();
  } catch (error) {
    writing = false;
    heard();
    say(`Nothing was written. ${error.message}`);
    offer();
  }
}

// --- what outlives a new page --------------------------------------------------------------------

const shown = document.documentElement.dataset;  // the stamps of the files that the page shows
let stamp = shown;  // and of those that are there
const mine = (name) => `${shown.data} ${name}`;  // other data, other sitting
const keep = (name, value) => {
  try { sessionStorage.setItem(mine(name), JSON.stringify(value)); } catch { /* more than it holds */ }
};
const drop = (name) => sessionStorage.removeItem(mine(name));
const kept = (name) => JSON.parse(sessionStorage.getItem(mine(name)) ?? "null");

function listen() {
  const events = new EventSource("events");
  events.addEventListener("files", (event) => {
    stamp = JSON.parse(event.data);
    if (!writing) heard();
  });
  events.addEventListener("error", () => say("The server has ended: type `pipeline open` again."));
}

function heard() {
  if (stamp.report && stamp.report !== shown.report) location.reload();
  const changed = stamp.config !== shown.config || stamp.data !== shown.data;
  button("run").hidden = Boolean(stamp.report) && !changed;
  if (!stamp.report) say("The report is gone: \"Run\" writes it again.");
  else if (changed) say("The configuration or a log was changed; \"Run\" brings the results here.");
}

// --- one triad -----------------------------------------------------------------------------------

const modelOf = ({ ticked }) => ticked.join(" + ") || "base";
const posesOf = ({ without }) => without.map((label) => label.split("/").slice(-2).join("/")).join(", ");
const named = (each) => `${modelOf(each)}${each.without.length ? ` without ${posesOf(each)}` : ""}`;

class Bench {
  constructor(section) {
    this.section = section;
    this.excluded = section.triad.poses.excluded.map((pose) => pose.label);
    this.tried = this.before();
    this.root = document.getElementById("bench").content.firstElementChild.cloneNode(true);
    section.root.querySelector(".refit").after(this.root);
    for (const name of ["x", "y", "colour", "from", "to"]) {
      this.part(name).addEventListener("change", () => this.draw());
    }
    section.listeners.push(() => this.note());
    droppable(this.part("drop"), this.part("held"), (file) => this.hold(file));
    for (const name of ["expression", "per"]) this.part(name).addEventListener("input", () => this.typed());
    this.part("own").addEventListener("submit", (event) => {
      event.preventDefault();
      write(state(), { triad: section.triad.triad, name: this.part("own-name").value,
        expression: this.part("expression").value, per: this.part("per").value });
    });
    this.comesBack([]);
    this.note();
    answered(fetch(`columns/${section.triad.triad}`)).then((answer) => {
      this.columns = answer.columns;
      this.phase = answer.phase;
      this.quantiles = answer.quantiles;
      this.choices();
      this.note();
    }).catch((error) => say(error.message));
    this.holdOut().catch((error) => say(error.message));
  }

  // The session that is held out, by the model of the file: what every tick is compared with.
  async holdOut() {
    const answer = await answered(fetch(`held-out/${this.section.triad.triad}`));
    this.heldAsRun = answer.held_out ?? null;
    if (this.heldAsRun) this.section.update();
  }

  // What was said of the session before, or of one that is refused, holds no longer.
  heldAnew(words) {
    for (const each of this.tried) each.held = null;
    this.heldAsRun = null;
    delete this.section.refitted.held_out;
    this.part("held-chart").replaceChildren();
    this.part("held-words").textContent = words;
    this.note();
  }

  async hold(file) {
    try {
      await sent("held-out", file);
    } catch (error) {
      benches.forEach((each) => each.heldAnew(error.message));
      return;
    }
    benches.forEach((each) => { each.heldAnew(""); each.holdOut(); });
  }

  part(name) { return this.root.querySelector(`[data-bench-${name}]`); }

  choices() {
    const own = ["residual [sd]", "residual left out [sd]"], names = Object.keys(this.columns);
    if (this.phase.beside.some((parts) => parts.length)) names.push(PHASE);
    const fill = (select, all) => select.replaceChildren(...all.map((each) => new Option(each, each)));
    fill(this.part("x"), [...names, ...own]);
    fill(this.part("y"), [...own, ...names]);
    fill(this.part("colour"), ["none", ...own, ...names]);
  }

  values(name) {
    const { refitted, triad } = this.section;
    if (name === "residual [sd]") return refitted.residual.map((value, k) => value / triad.sd[k]);
    if (name === "residual left out [sd]") {
      return (refitted.left_out ?? triad.left_out).map((value, k) => value / triad.sd[k]);
    }
    return this.columns[name];
  }

  // What was tried before this page was loaded; the configuration may exclude other poses since.
  before() {
    const { labels, rows } = kept(`tried ${this.section.triad.triad}`) ?? { rows: [] };
    const place = new Map(labels?.map((label, k) => [label, k]));
    return rows.map((row) => ({ ...row,
      left_out: this.section.triad.labels.map((label) => row.left_out[place.get(label)] ?? null) }));
  }

  keepTried() {
    const { triad, labels } = this.section.triad;
    keep(`tried ${triad}`, { labels, rows: this.tried.slice(-40) });
  }

  // Buttons for the poses that the configuration excludes, and those that come back with a write.
  without() {
    const { triad, out } = this.section;
    return [...this.excluded.filter((label) => !this.back.has(label)), ...triad.labels.filter((_, k) => out.has(k))].sort();
  }

  comesBack(labels) {
    this.back = new Set(labels);
    this.part("excluded").hidden = this.excluded.length === 0;
    this.part("excluded-poses").replaceChildren(...this.excluded.map((label) => {
      const button = document.createElement("button"), comes = this.back.has(label);
      button.type = "button";
      button.textContent = comes ? `${label} comes back` : `take ${label} back in`;
      button.setAttribute("aria-pressed", String(comes));
      button.addEventListener("click", () => {
        this.comesBack(this.excluded.filter((each) => this.back.has(each) !== (each === label)));
        remember();
      });
      return button;
    }));
  }

  // A fit is on the screen: one more row, unless it was tried before.
  note() {
    const { triad, order, out, refitted } = this.section, ticked = order.map((effect) => effect.name);
    const without = [...this.excluded, ...triad.labels.filter((_, k) => out.has(k))].sort();  // what comes back is not fitted yet
    const key = this.key = JSON.stringify([ticked, without]);
    const held = refitted.held_out?.rms ?? null, known = this.tried.find((each) => each.key === key);
    if (known && held !== null) known.held = held;
    if (!known && !refitted.failed && this.section.settled) {
      this.tried.push({ key, ticked, without, rms: refitted.rms, loo: refitted.loo, held,
        chi2: refitted.chi2 / refitted.dof, explained: refitted.explained,
        left_out: (refitted.left_out ?? triad.left_out).map((v, k) => Number((v / triad.sd[k]).toPrecision(4))) });
      this.keepTried();
    }
    this.part("tried").replaceChildren(...this.tried.map((each) => this.row(each)));
    for (const [part, at] of [["from", 0], ["to", this.tried.length - 1]]) {
      const select = this.part(part), before = select.selectedIndex;
      const chosen = part === "from" && before >= 0 ? before : at;
      select.replaceChildren(...this.tried.map((each, i) => new Option(named(each), i)));
      select.selectedIndex = chosen;
    }
    this.draw();
  }

  // A model that was tried, with the way back to it; from a pose that is excluded there is none.
  row(each) {
    const row = document.createElement("tr"), back = document.createElement("button"), { short } = page;
    row.className = each.key === this.key ? "now" : "";
    row.insertCell().append(back);
    [posesOf(each), short(each.rms), short(each.loo), each.held == null ? "–" : short(each.held),
      short(each.chi2), each.explained ? "yes" : "no"].forEach((text) => { row.insertCell().textContent = text; });
    const lost = this.excluded.filter((label) => !each.without.includes(label));
    back.type = "button";
    back.className = "link";
    back.textContent = modelOf(each);
    back.disabled = lost.length > 0;
    back.title = lost.length ? `The configuration excludes ${lost.join(", ")} by now.` : "";
    back.setAttribute("aria-label", `show ${named(each)}`);
    back.addEventListener("click", () => {
      const whole = JSON.parse(screen());
      whole.triads[this.section.triad.triad] = { ticked: each.ticked, without: each.without };
      done.push(now);
      undone = [];
      restore(JSON.stringify(whole));
    });
    return row;
  }

  draw() {
    if (!this.columns) return;  // on their way
    this.scatter();
    this.normal();
    this.gain();
    this.held();
  }

  // Once nothing more is typed the expression is tried as one more effect.
  typed() {
    clearTimeout(this.waiting);
    this.waiting = setTimeout(() => this.tryExpression(this.part("expression").value), 250);
  }

  async tryExpression(text) {
    const words = this.part("expression-words");
    if (!text.trim()) return;
    let answer;
    try {
      answer = await asked("expression", { state: state(), triad: this.section.triad.triad,
        expression: text, per: this.part("per").value });
    } catch (error) {
      answer = { problem: error.message, at: -1 };
    }
    if (text !== this.part("expression").value) return;  // typed on meanwhile
    this.part("fingerprint").replaceChildren();
    this.part("own").hidden = Boolean(answer.problem);
    if (answer.problem) {
      const { at } = answer, shortened = [text.slice(Math.max(at - 30, 0), at), text.slice(at, at + 30)];
      const pointer = at >= 0 ? ` At character ${at + 1}: ${shortened.join("▸")}` : "";
      words.textContent = answer.problem + pointer;
      return;
    }
    const { with: after, without: before } = answer, fall = (name) => `${page.short(before[name])} → ${page.short(after[name])}`;
    words.textContent = `chi² ${fall("chi2")}; leave-one-out ${fall("loo")} ${this.section.triad.unit}. ${answer.words}`;
    this.part("expression-lines").textContent = answer.lines;
    const pattern = before.residual.map((value, k) => value - after.residual[k]);
    const { svg, x, y } = plot([0, pattern.length], span([0, ...before.residual, ...pattern]), "pose",
      `residual (dots) and what the expression explains (line) [${this.section.triad.unit}]`, `Fingerprint of ${text} over the residuals.`);
    svg.append(node("path", { class: "effect", d: pattern.map((value, k) =>
      `${k ? "V" : `M${x(0)} `}${y(value).toFixed(1)}H${x(k + 1).toFixed(1)}`).join("") }));
    before.residual.forEach((value, k) => svg.append(this.dot(k, x(k + 0.5), y(value), page.short(value))));
    this.part("fingerprint").replaceChildren(svg);
  }

  dot(k, x, y, text) {
    const mark = node("circle", { "data-i": k, cx: x.toFixed(1), cy: y.toFixed(1), r: 4 });
    mark.append(node("title", {}, `${this.section.triad.shown[k]}: ${text}`));
    if (this.section.out.has(k)) mark.classList.add("left-out");
    return mark;
  }

  // A dot for every pose; with the phase of the plate one for every part of its turns.
  scatter() {
    const names = ["x", "y", "colour"].map((name) => this.part(name).value), [across, upward, colour] = names;
    const { triad } = this.section, byPhase = names.includes(PHASE);
    const columns = names.map((name) => (name === PHASE || name === "none" ? null : this.values(name)));
    const value = (a, k, j) => (names[a] === PHASE ? this.phase.angle_deg[j]
      : columns[a][k] + (byPhase && names[a].startsWith("residual") ? this.phase.beside[k][j] / triad.sd[k] : 0));
    const dots = triad.labels.flatMap((_, k) => (byPhase ? this.phase.beside[k].map((__, j) => [k, j]) : [[k, 0]]));
    const [xs, ys] = [0, 1].map((a) => dots.map(([k, j]) => value(a, k, j)));
    const { svg, x, y } = plot(span(xs), span(ys), across, upward, `${upward} against ${across}, a dot for every ${byPhase ? "twelfth of a turn of every pose on the plate" : "pose"}.`);
    const shades = colour === "none" ? null : dots.map(([k, j]) => value(2, k, j)), range = shades && span(shades);
    dots.forEach(([k], i) => {
      const mark = this.dot(k, x(xs[i]), y(ys[i]), `${page.short(xs[i])}, ${page.short(ys[i])}`);
      if (byPhase) mark.setAttribute("r", 2.5);
      if (shades) mark.style.fill = `hsl(${(240 - 240 * (shades[i] - range[0]) / (range[1] - range[0])).toFixed(0)} 75% 48%)`;
      svg.append(mark);
    });
    this.part("scatter").replaceChildren(svg);
    this.part("scatter-words").textContent = [
      byPhase ? "The phase counts from the beginning of each pose; what the model leaves comes back once or twice per turn where the plate or the sensor leans." : "",
      shades ? `Blue is ${page.short(Math.min(...shades))}, red ${page.short(Math.max(...shades))}.` : ""].join(" ");
  }

  normal() {
    const { several_rows: several } = this.section.triad, all = this.values("residual [sd]");
    const places = all.map((_, k) => k).filter((k) => !several[k]).sort((a, b) => all[a] - all[b]);
    const { z, low, high } = this.quantiles;
    this.part("normal").closest("figure").hidden = places.length === 0;
    if (places.length === 0 || places.length !== z.length) return;
    const { svg, x, y } = plot(span(z), span([...low, ...high, ...places.map((k) => all[k])]),
      "normal quantile", "residual [sd]", "Ordered residuals against normal quantiles with their band.");
    const edge = (values) => z.map((value, i) => `${x(value).toFixed(1)} ${y(values[i]).toFixed(1)}`);
    svg.append(node("path", { class: "band-of-normal", d: `M${[...edge(low), ...edge(high).reverse()].join("L")}z` }));
    places.forEach((k, i) => svg.append(this.dot(k, x(z[i]), y(all[k]), `${page.short(all[k])} sd`)));
    this.part("normal").replaceChildren(svg);
  }

  // The poses that were fitted, then those that no fit has seen; outlines are before the ticks.
  held() {
    const { held_out: after, residual } = this.section.refitted, before = this.heldAsRun, { unit } = this.section.triad;
    if (!before || !after) return;
    const words = this.part("held-words"), by = ({ rms }) => `${page.short(rms ?? NaN)} ${unit}`;
    words.textContent = after.problem ?? `On the ${after.labels.length} poses of ${after.name}, which no fit has seen, `
      + `this model errs by ${by(after)}; the model of the file by ${by(before)}; its own model, fitted to them, by `
      + `${by({ rms: after.own_rms })}. Where these lie far apart it is another sensor, or the sensor changed.`;
    this.part("held-chart").replaceChildren();
    if (after.problem) return;
    const was = [...this.section.asFitted.residual, ...(before.residual ?? [])], now = [...residual, ...after.residual];
    const { svg, x, y } = plot([0, now.length], span([0, ...was, ...now]), "fitted poses | held out",
      `residual [${unit}]`, words.textContent);
    svg.append(node("path", { class: "zero", d: `M${x(residual.length)} 10V${HEIGHT - FOOT}` }));
    was.forEach((value, k) => svg.append(node("circle", { class: "ghost", cx: x(k + 0.5), cy: y(value), r: 3 })));
    residual.forEach((value, k) => {
      const mark = this.dot(k, x(k + 0.5), y(value), page.short(value));
      mark.classList.add("fitted");
      svg.append(mark);
    });
    after.residual.forEach((value, i) => {
      const mark = node("circle", { class: "held", cx: x(residual.length + i + 0.5), cy: y(value), r: 4 });
      mark.append(node("title", {}, `${after.labels[i]}: ${page.short(value)} ${unit}, ${page.short(value / after.sd[i])} sd`));
      svg.append(mark);
    });
    this.part("held-chart").append(svg);
  }

  // By how much the squared prediction of every pose that takes no part falls, in sds.
  gain() {
    const [from, to] = ["from", "to"].map((name) => this.tried[Number(this.part(name).value)]);
    this.part("gain").hidden = from === to;
    if (from === to) {
      this.part("gain-words").textContent = "Tick an effect or leave a pose out: the poses that gain stand here.";
      return;
    }
    const both = from.left_out.map((value, k) => value !== null && to.left_out[k] !== null);
    const gains = from.left_out.map((value, k) => (both[k] ? value ** 2 - to.left_out[k] ** 2 : 0));
    const { svg, x, y } = plot([0, gains.length], span([0, ...gains]), "pose", "fall of chi² by pose",
      `Which poses ${named(to)} predicts better than ${named(from)}.`);
    const wide = Math.max((x(1) - x(0)) * 0.75, 1);
    gains.forEach((value, k) => {
      const bar = node("rect", { class: value < 0 ? "gain loss" : "gain", "data-i": k, x: x(k + 0.12), width: wide,
        y: Math.min(y(0), y(value)), height: Math.max(Math.abs(y(value) - y(0)), 0.5) });
      bar.append(node("title", {}, `${this.section.triad.labels[k]}: ${page.short(value)}`));
      svg.append(bar);
    });
    this.part("gain").replaceChildren(svg);
    const better = gains.filter((value) => value > 0).length;
    this.part("gain-words").textContent = `${better} of ${both.filter(Boolean).length} poses are predicted better by `
      + `${named(to)} than by ${named(from)}.`;
  }
}

// One question of a triad at a time: of those that wait meanwhile the newest alone is asked.
const running = {}, newest = {};
async function ask(where, question) {
  const { triad } = question, mine = newest[triad] = {};
  await running[triad];
  if (newest[triad] !== mine) return new Promise(() => {});
  const answer = asked(where, { ...question, state: state() });
  running[triad] = answer.catch(() => {});
  const refitted = await answer;
  for (const name of ["residual", "left_out"]) refitted[name] = refitted[name].map((value) => value ?? NaN);
  return refitted;
}

window.workbench = {
  ask,
  begin(parts) {
    page = parts;
    drawing.short = page.short;
    for (const section of page.sections) {
      const update = section.update.bind(section), show = section.show.bind(section);
      section.update = () => { section.root.setAttribute("aria-busy", "true"); section.settled = false; remember(); update(); };
      section.show = (refitted) => { section.root.removeAttribute("aria-busy"); section.settled = true; show(refitted); };
      section.settled = true;
      benches.push(new Bench(section));
      section.root.querySelector("details.sound")?.setAttribute("open", "");
    }
    showClips((setting) => {
      const charts = document.querySelector(`[data-rate="${CSS.escape(setting)}"]`);
      const place = charts?.insertBefore(document.createElement("figure"), charts.children[1] ?? null);
      place?.classList.add("card");
      return place;
    });
    for (const section of page.rateSections) {
      section.boxes.forEach((box) => box.addEventListener("change", remember));
    }
    // The specific force in the poses of the gyroscope is the accelerometer's.
    const [first, second] = ["accelerometer", "gyroscope"].map((name) =>
      page.sections.find((section) => section.triad.triad === name));
    if (first && second) first.listeners.push(() => second.update());
    for (const name of Object.keys(actions)) button(name).addEventListener("click", actions[name]);
    document.addEventListener("keydown", (event) => {
      if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z") return;
      const name = event.shiftKey ? "redo" : "undo";
      if (!button(name).disabled) { event.preventDefault(); actions[name](); }
    });
    for (const line of document.querySelectorAll(".answer pre")) {
      const [, target] = /^pipeline add .* (\S+\.\S+)$/.exec(line.textContent) ?? [];
      if (!target) continue;
      const here = document.createElement("button");
      here.type = "button";
      here.textContent = "Tick it here";
      here.addEventListener("click", () => {
        page.tick(target);
        say(`${target} is ticked; "Write to config" saves it.`);
      });
      line.after(here);
    }
    for (const line of document.querySelectorAll(".answer pre")) {
      if (!/^pipeline import .* --into /.test(line.textContent)) continue;
      const here = Object.assign(document.createElement("button"), { type: "button", textContent: "Bring them here" });
      here.addEventListener("click", further.open);
      line.after(here);
    }
    further.begin(state, offer);
    bar.querySelector("[data-bench-folder]").hidden = !location.pathname.startsWith("/session/");
    page.asRun = now = screen();
    const written = kept("written"), before = kept("history");
    if (before) {
      ({ done, undone } = before);
      if (before.now) restore(before.now);
    }
    if (written) {
      const steps = done.length ? ' Undo shows what was before; "Write to config" writes that.' : "";
      say(written.lines.length ? `${written.path} was changed.${steps}` : "Nothing to write.", written.lines);
    }
    drop("written");
    offer();
    listen();
  },
};
})();
