// The tools beside one triad: every model that was tried, a session that is held out, poses that come
// back, and an effect of the user's own.
const Bench = (() => {
"use strict";
const { answered, asked, sent } = drawing;
const MOST_KEPT = 40;  // models that outlive a new page; chosen
const modelOf = ({ ticked }) => ticked.join(" + ") || "base";
const posesOf = ({ without }) => without.map((label) => label.split("/").slice(-2).join("/")).join(", ");

return class {
  // ``all`` are the benches of the page, of which this becomes one; ``say`` shows a sentence, and
  // ``write`` writes the screen with an effect.
  constructor(section, all, say, write) {
    Object.assign(this, { section, all, write });
    all.push(this);
    this.excluded = section.triad.poses.excluded.map((pose) => pose.label);
    this.tried = this.before();
    this.root = document.getElementById("bench").content.firstElementChild.cloneNode(true);
    section.root.querySelector(".refit").after(this.root);
    this.charts = new BenchCharts(this);
    section.listeners.push(() => this.note());
    dropped.onto(this.part("drop"), this.part("held"), (file) => this.hold(file));
    for (const name of ["expression", "per"]) this.part(name).addEventListener("input", () => this.typed());
    this.part("own").addEventListener("submit", (event) => {
      event.preventDefault();
      write({ triad: section.triad.triad, name: this.part("own-name").value,
        expression: this.part("expression").value, per: this.part("per").value });
    });
    this.comesBack([]);
    this.note();
    answered(fetch(`columns/${section.triad.triad}`)).then((answer) => {
      this.charts.arrive(answer);
      this.note();
    }).catch((error) => say(error.message));
    this.holdOut().catch((error) => say(error.message));
  }

  part(name) { return this.root.querySelector(`[data-bench-${name}]`); }

  named(each) { return `${modelOf(each)}${each.without.length ? ` without ${posesOf(each)}` : ""}`; }

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
      this.all.forEach((each) => each.heldAnew(error.message));
      return;
    }
    this.all.forEach((each) => { each.heldAnew(""); each.holdOut(); });
  }

  // What was tried before this page was loaded; the configuration may exclude other poses since.
  before() {
    const { labels, rows } = steps.kept(`tried ${this.section.triad.triad}`) ?? { rows: [] };
    const place = new Map(labels?.map((label, k) => [label, k]));
    return rows.map((row) => ({ ...row,
      left_out: this.section.triad.labels.map((label) => row.left_out[place.get(label)] ?? null) }));
  }

  keepTried() {
    const { triad, labels } = this.section.triad;
    steps.keep(`tried ${triad}`, { labels, rows: this.tried.slice(-MOST_KEPT) });
  }

  // The poses without which the screen shows the fit, by their labels.
  without(back = this.back) {
    const { triad, out } = this.section;
    return [...this.excluded.filter((label) => !back.has(label)), ...triad.labels.filter((_, k) => out.has(k))].sort();
  }

  // Buttons for the poses that the configuration excludes, and those that come back with a write.
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
        steps.remember();
      });
      return button;
    }));
  }

  // A fit is on the screen: one more row, unless it was tried before.
  note() {
    const { triad, order, refitted } = this.section, ticked = order.map((effect) => effect.name);
    const without = this.without(new Set());  // what comes back is not fitted yet
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
      select.replaceChildren(...this.tried.map((each, i) => new Option(this.named(each), i)));
      select.selectedIndex = chosen;
    }
    this.charts.draw();
  }

  // A model that was tried, with the way back to it; from a pose that is excluded there is none.
  row(each) {
    const row = document.createElement("tr"), back = document.createElement("button"), { short } = drawing;
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
    back.setAttribute("aria-label", `show ${this.named(each)}`);
    back.addEventListener("click", () =>
      steps.show(this.section.triad.triad, { ticked: each.ticked, without: each.without }));
    return row;
  }

  // Once nothing more is typed the expression is tried as one more effect.
  typed() {
    clearTimeout(this.waiting);
    this.waiting = setTimeout(() => this.tryExpression(this.part("expression").value), 250);
  }

  async tryExpression(text) {
    const words = this.part("expression-words"), { short } = drawing;
    if (!text.trim()) return;
    let answer;
    try {
      answer = await asked("expression", { state: steps.state(), triad: this.section.triad.triad,
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
    const { with: after, without: before } = answer, fall = (name) => `${short(before[name])} → ${short(after[name])}`;
    words.textContent = `chi² ${fall("chi2")}; leave-one-out ${fall("loo")} ${this.section.triad.unit}. ${answer.words}`;
    this.part("expression-lines").textContent = answer.lines;
    this.charts.fingerprint(text, before.residual, after.residual);
  }
};
})();
