// The tick boxes of one triad and everything that follows them.
class Section {
  constructor(triad, config) {
    this.triad = triad;
    this.config = config;
    this.root = document.querySelector(`section[data-triad="${triad.triad}"]`);
    this.effects = triad.effects.filter((effect) => effect.reason === null);
    this.boxes = new Map(this.effects.map((effect) => [
      effect.name, this.root.querySelector(`input[data-effect="${CSS.escape(effect.name)}"]`)]));
    this.order = this.effects.filter((effect) => effect.in_model);
    this.refits = new Refits(triad);
    this.asFitted = this.refits.of(this.order);
    this.refitted = this.asFitted;
    this.limit = residualLimit(this.asFitted.residual, triad.sd);
    this.charts = [...this.root.querySelectorAll("svg.residuals")].map((svg) => new ResidualChart(svg, triad));
    this.out = new Set();    // poses that are left out
    this.listeners = [];     // called after every refit
    for (const effect of this.effects) {
      this.boxes.get(effect.name).addEventListener("change", () => this.toggle(effect));
    }
    this.root.querySelector("[data-reset]").addEventListener("click", () => this.reset());
    this.show(this.refits.inTable(this.order));
  }

  toggle(effect) {
    this.order = this.order.filter((other) => other !== effect);
    if (this.boxes.get(effect.name).checked) this.order.push(effect);
    this.update();
  }

  tick(name) {
    const box = this.boxes.get(name);
    if (!box || box.disabled || box.checked) return;
    unfold(box);
    box.checked = true;
    this.toggle(this.effects.find((effect) => effect.name === name));
    this.root.querySelector(".refit").scrollIntoView({ block: "nearest" });
  }

  reset() {
    this.order = this.effects.filter((effect) => effect.in_model);
    for (const effect of this.effects) this.boxes.get(effect.name).checked = effect.in_model;
    this.update();
  }

  output(name) { return this.root.querySelector(`[data-out="${name}"]`); }

  update() {
    const asked = this.asked = (this.asked ?? 0) + 1;
    this.refits.find(this.order, this.out, (refitted) => {
      if (asked === this.asked) this.show(refitted);  // not one that was overtaken
    });
  }

  show(refitted) {
    const was = this.asFitted, { triad } = this;
    const changed = this.effects.filter(
      (effect) => effect.in_model !== this.boxes.get(effect.name).checked);
    const other = changed.length > 0 || (asks !== null && this.out.size > 0);
    const failed = refitted.failed ?? "";
    if (!failed) this.refitted = refitted;
    for (const name of ["rms", "loo"]) {
      showTile(this.root, name, failed ? NaN : refitted[name], was[name], other);
    }
    showTile(this.root, "chi2", failed ? NaN : refitted.chi2 / refitted.dof, was.chi2 / was.dof, other);
    this.root.classList.toggle("ticked", other);
    this.root.querySelector("[data-result]").hidden = !other;
    this.judge(failed ? { judgements: [], commands: [] } : refitted);
    this.say(refitted, failed);
    this.tie(refitted);
    if (!failed) {
      this.draw(refitted);
      drawFall(this.output("fall"), this.order, refitted.steps);
    }
    this.listeners.forEach((listener) => listener());
  }

  // What each change is worth, and the commands of those that are worth it.
  judge({ judgements, commands }) {
    this.output("judgement").replaceChildren(...judgements.map(({ text, good }) => {
      const line = document.createElement("p");
      line.textContent = text;
      if (good !== null) line.className = good ? "helps" : "harms";
      return line;
    }));
    this.output("commands").textContent = commands.join("\n");
    this.output("commanded").hidden = commands.length === 0;
  }

  say(refitted, failed) {
    this.output("words").textContent = failed
      ? (failed === true ? "These poses do not determine all of them together." : failed)
      : refitted.explained ? "The noise of the poses explains the residuals."
        : "The noise of the poses does not explain the residuals yet.";
    this.output("sizes").replaceChildren(...(failed ? [] : refitted.sizes).map((size) => {
      const row = document.createElement("tr");
      size.forEach((text) => { row.insertCell().textContent = text; });
      return row;
    }));
  }

  // Of effects that these poses cannot separate only one can be ticked.
  tie(refitted) {
    for (const effect of this.effects) {
      const box = this.boxes.get(effect.name);
      const rival = this.order.find((other) => other !== effect
        && (other.aliases.includes(effect.name) || effect.aliases.includes(other.name)));
      const next = box.checked ? this.order.filter((other) => other !== effect) : [...this.order, effect];
      const known = this.refits.knows(next);
      box.disabled = (!box.checked && rival !== undefined) || !known;
      const note = this.root.querySelector(`[data-note="${CSS.escape(effect.name)}"]`);
      if (refitted.unseen?.includes(effect.name)) {
        note.textContent = "Together with the other ticked effects these poses cannot determine it.";
      } else if (rival) {
        note.textContent = `These poses cannot separate it from ${rival.name}. `
          + `This separates them: ${effect.separates}.`;
      } else if (!known) {
        note.textContent = `This file holds the most probable pairs; pipeline open ${this.config} refits any set of effects.`;
      } else if (effect.aliases.length) {
        note.textContent = `These poses cannot separate it from ${effect.aliases.join(" or ")}.`;
      } else {
        note.textContent = "";
      }
    }
  }

  draw({ residual }) {
    const { labels, named, sd } = this.triad;
    const inSd = residual.map((v, k) => Math.abs(v) / sd[k] || 0);
    const within = inSd.filter((times) => times <= 1).length;
    const largest = inSd.indexOf(Math.max(...inSd));
    this.output("says").textContent = `Now ${within} of ${labels.length} residuals `
      + `are smaller than one sd. The largest is ${inSd[largest].toFixed(1)} sds: ${named[largest]}.`;
    const limit = Math.max(this.limit, residualLimit(residual, sd));
    this.charts.forEach((chart) => chart.draw(limit, residual, sd, this.asFitted.residual));
  }
}
