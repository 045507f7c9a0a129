// One pose at a time: marked in every chart and table, with its raw log, and left out on demand.
const REACH_SD = 4;  // the colours reach at least so many sds
const STRIP = 46, GAP = 8, LEFT = 62, WIDTH = 400;

const FINGER = 22;  // pixels from its middle to the edge of what a finger touches

// The mark of a pose next to where a chart was touched; none farther than a finger reaches.
function nearest({ target, clientX, clientY }) {
  const away = (mark) => {
    const { left, top, width, height } = mark.getBoundingClientRect();
    return Math.hypot(left + width / 2 - clientX, top + height / 2 - clientY);
  };
  const marks = [...(target.closest("svg")?.querySelectorAll("[data-i]") ?? [])];
  const first = marks.reduce((best, mark) => (best && away(best) <= away(mark) ? best : mark), null);
  return first && away(first) < FINGER ? first : null;
}

class Poses {
  constructor(section) {
    this.section = section;
    this.triad = section.triad;
    this.root = section.root.querySelector("[data-poses]");
    if (!this.root) return;
    this.panel = this.root.querySelector("[data-pose-panel]");
    this.home = this.panel.parentElement;
    this.picked = -1;
    this.sphere = new Sphere(this.root, this.triad.poses, (k) => this.open(null, k));
    this.root.classList.add("live");
    section.root.addEventListener("click", (event) => {
      const mark = event.target.closest("[data-i]") ?? nearest(event);
      if (mark && !mark.closest("[data-stage]")) this.open(mark, Number(mark.dataset.i));
    });
    this.root.querySelector("[data-run]")?.addEventListener(
      "change", (event) => this.sphere.show(event.target.value));
    for (const button of this.root.querySelectorAll("[data-do]")) {
      button.addEventListener("click", () => this[button.dataset.do]());
    }
    section.listeners.push(() => this.update());
    this.update();
  }

  // What a mark is opens where it was touched, and comes into view.
  open(mark, k) {
    const beside = mark?.closest("figure.of-poses") ? this.section.root.querySelector(".outcome > :first-child")
      : mark?.closest(".panels, .bench-grid > figure");
    if (beside) beside.after(this.panel);
    else this.home.append(this.panel);
    unfold(this.panel);
    this.pick(k);
    this.panel.scrollIntoView({ block: "nearest" });
  }

  next() { this.pick((this.picked + 1) % this.triad.labels.length); }

  previous() {
    const n = this.triad.labels.length;
    this.pick((Math.max(this.picked, 0) + n - 1) % n);
  }

  pick(k) {
    this.picked = k;
    for (const old of this.section.root.querySelectorAll(".picked")) old.classList.remove("picked");
    for (const mark of this.section.root.querySelectorAll(`[data-i="${k}"]`)) mark.classList.add("picked");
    this.sphere.marks[k].classList.add("picked");
    this.sphere.face(k);
    this.describe();
  }

  leaveOut() {
    const { out } = this.section;
    if (!out.delete(this.picked)) out.add(this.picked);
    this.section.update();
  }

  takeBack() {
    this.section.out.clear();
    this.section.update();
  }

  // Residual and sd of every pose in the shown unit, and the residual in sds.
  values() {
    const { labels, sd } = this.triad, { residual } = this.section.refitted;
    return labels.map((_, k) => ({ value: residual[k], sd: sd[k], inSd: residual[k] / sd[k] }));
  }

  update() {
    const { shown, several_rows: several } = this.triad, { out } = this.section;
    this.now = this.values();
    const inSd = this.now.map((each) => each.inSd);
    const limit = nice(Math.max(REACH_SD, ...inSd.map((value) => Math.abs(value) || 0)));
    const kind = inSd.map((value, k) => (several[k] ? "rest"
      : Math.abs(value) <= 1 ? "noise" : value > 0 ? "above" : "below"));
    const text = shown.map((name, k) => `${name}: ${this.words(k)}${out.has(k) ? " (left out)" : ""}`);
    this.sphere.colour(inSd, text, kind, limit, out);
    this.root.querySelectorAll("[data-limit]").forEach((each) => {
      each.textContent = short(Number(each.dataset.limit) * limit);
    });
    this.root.style.setProperty("--noise", `${(100 / limit).toFixed(2)}%`);
    for (const row of this.root.querySelectorAll("tr[data-i]")) {
      const k = Number(row.dataset.i);
      row.classList.toggle("left-out", out.has(k));
      row.querySelector("[data-residual]").textContent = withSd(this.now[k].value, this.now[k].sd);
      row.querySelector("[data-in-sd]").textContent = short(inSd[k]);
    }
    for (const mark of this.section.root.querySelectorAll("svg [data-i]")) {
      mark.classList.toggle("left-out", out.has(Number(mark.dataset.i)));
    }
    const names = [...out].map((k) => shown[k]);
    this.panel.querySelector("[data-out-note]").hidden = out.size === 0;
    this.panel.querySelector("[data-out-names]").textContent = names.join(", ");
    const [command, ...poses] = this.triad.poses.exclude, inOrder = [...out].sort((a, b) => a - b);
    this.panel.querySelector("[data-out-command]").textContent = [command, ...inOrder.map((k) => poses[k])].join(" ");
    if (this.picked >= 0) this.describe();
  }

  words(k) {
    const { value, sd, inSd } = this.now[k];
    const at = this.triad.several_rows[k] ? ", over its rows " : ", ";
    return `${withSd(value, sd)} ${this.triad.unit}${at}${short(inSd)} sd`;
  }

  describe() {
    const k = this.picked, { shown, poses } = this.triad, { out } = this.section;
    const set = (name, text) => { this.panel.querySelector(`[data-pose="${name}"]`).textContent = text; };
    this.panel.classList.add("chosen");
    set("label", shown[k]);
    const facts = [["residual", this.words(k)], ["run", poses.runs[k]], ...poses.facts[k]];
    this.panel.querySelector("[data-pose=facts]").replaceChildren(...facts.flatMap(([name, value]) => {
      const title = document.createElement("dt"), text = document.createElement("dd");
      title.textContent = name;
      text.textContent = value;
      return [title, text];
    }));
    this.panel.querySelector("[data-pose=trace]").replaceChildren(
      ...(poses.traces[k] ? trace(poses.traces[k], this.triad.unit, this.now[k].value) : []));
    this.showFrame(poses.frames[k]);
    set("without", this.without(k));
    const button = this.panel.querySelector("[data-do=leaveOut]");
    button.textContent = out.has(k) ? "Take this pose back in" : "Leave this pose out";
    button.setAttribute("aria-pressed", String(out.has(k)));
  }

  // The clip of the pose, or a frame of that of its run, which the section of the rates has.
  showFrame(frame) {
    const figure = this.panel.querySelector("[data-pose=frame]");
    const src = frame && (frame.src
      ?? document.querySelector(`[data-rate="${CSS.escape(frame.rate)}"] figure img`)?.src);
    figure.hidden = !src;
    if (!src) return;
    figure.querySelector("img").src = src;
    figure.querySelector("figcaption").textContent = frame.src
      ? `${frame.clip}, filmed with this pose` : `One frame of the clip of ${frame.rate}, which was filmed for the whole run`;
  }

  // What the fit without the pose says of it, before anybody leaves it out.
  without(k) {
    const { left_out: leftOut, sd, unit } = this.triad, now = this.section.refitted.left_out ?? leftOut;
    return this.section.root.classList.contains("ticked") && !this.section.refitted.left_out ? ""
      : `A fit without this pose predicts it with an error of ${short(now[k])} ${unit}, ${short(now[k] / sd[k])} sd.`;
  }
}

// The raw log of a pose about its mean: for each axis the range of the samples against time, and over
// it where the model puts the mean, by the residual that it leaves, with three sds of a sample.
function trace({ seconds, low, high, axes, values, along, sd }, unit, residual) {
  const bytes = Uint8Array.from(atob(values), (letter) => letter.charCodeAt(0));
  const n = bytes.length / (2 * axes.length), height = axes.length * (STRIP + GAP) + 6;
  const svg = element("svg", { viewBox: `0 0 ${WIDTH} ${height}`, role: "img", class: "trace",
    "aria-label": `Raw log of the pose: lowest and highest sample of ${n} stretches, axis by axis, over what the model predicts with three sds.` });
  const x = (i) => (LEFT + i / n * (WIDTH - LEFT - 4)).toFixed(1);
  axes.forEach((axis, a) => {
    const top = a * (STRIP + GAP) + 6;
    const y = (level) => (top + STRIP * (1 - level / 255)).toFixed(1);
    const part = (side) => [...bytes.slice((2 * a + side) * n, (2 * a + side + 1) * n)];
    const lowest = part(0), highest = part(1);
    const steps = (levels) => levels.flatMap((v, i) => [`${x(i)} ${y(v)}`, `${x(i + 1)} ${y(v)}`]);
    const zero = low[a] < high[a] ? 255 * -low[a] / (high[a] - low[a]) : 0;
    const place = (value) => Math.min(Math.max(255 * (value - low[a]) / (high[a] - low[a] || 1), 0), 255);
    const predicted = -residual * along[a], band = [predicted - 3 * sd[a], predicted + 3 * sd[a]].map(place);
    svg.append(
      element("rect", { class: "predicted", x: LEFT, width: WIDTH - LEFT - 4, y: y(band[1]),
        height: Math.max(y(band[0]) - y(band[1]), 0.5) }),
      element("path", { class: `range run${a}`, d: `M${[...steps(highest), ...steps(lowest).reverse()].join("L")}z` }),
      element("path", { class: "zero", d: `M${LEFT} ${y(zero)}H${WIDTH - 4}` }),
      element("path", { class: "model", d: `M${LEFT} ${y(place(predicted))}H${WIDTH - 4}` }),
      element("text", { class: "title", x: 4, y: top + STRIP / 2, dy: 4 }, axis),
      element("text", { class: "tick", x: LEFT - 5, y: top, dy: 9, "text-anchor": "end" }, short(high[a])),
      element("text", { class: "tick", x: LEFT - 5, y: top + STRIP, "text-anchor": "end" }, short(low[a])),
    );
  });
  const caption = document.createElement("p");
  caption.className = "quiet";
  caption.textContent = `${short(seconds)} s of the raw log, less its mean [${unit}]; line and band: the model ± 3 sd`;
  return [svg, caption];
}
