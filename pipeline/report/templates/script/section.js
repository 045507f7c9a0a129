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
    this.asFitted = refitWithout(triad, this.order, new Set());
    this.before = shownResiduals(triad, this.asFitted.residual);
    this.limit = residualLimit(this.before.value, this.before.sd);
    this.charts = [...this.root.querySelectorAll("svg.residuals")].map((svg) => new ResidualChart(svg, triad));
    this.out = new Set();    // poses that are left out
    this.listeners = [];     // called after every refit
    for (const effect of this.effects) {
      this.boxes.get(effect.name).addEventListener("change", () => this.toggle(effect));
    }
    this.root.querySelector("[data-reset]").addEventListener("click", () => this.reset());
    this.update();
  }

  toggle(effect) {
    this.order = this.order.filter((other) => other !== effect);
    if (this.boxes.get(effect.name).checked) this.order.push(effect);
    this.update();
  }

  tick(name) {
    const box = this.boxes.get(name);
    if (!box || box.disabled || box.checked) return;
    box.checked = true;
    this.toggle(this.effects.find((effect) => effect.name === name));
  }

  reset() {
    this.order = this.effects.filter((effect) => effect.in_model);
    for (const effect of this.effects) this.boxes.get(effect.name).checked = effect.in_model;
    this.update();
  }

  output(name) { return this.root.querySelector(`[data-out="${name}"]`); }

  update() {
    const refitted = refitWithout(this.triad, this.order, this.out), was = this.asFitted;
    this.refitted = refitted;
    const exact = this.triad.loo / was.loo;  // refits without each pose, over one step's estimate
    const changed = this.effects.filter(
      (effect) => effect.in_model !== this.boxes.get(effect.name).checked);
    const other = changed.length > 0 || this.out.size > 0;
    showTile(this.root, "rms", refitted.rms, was.rms, other);
    showTile(this.root, "loo", refitted.loo * exact, this.triad.loo, other);
    showTile(this.root, "chi2", refitted.chi2 / refitted.dof, was.chi2 / was.dof, other);
    this.root.classList.toggle("ticked", other);
    this.root.querySelector("[data-result]").hidden = changed.length === 0;
    this.judge(changed);
    this.say(refitted);
    this.tie(refitted);
    this.draw(refitted);
    drawFall(this.output("fall"), this.triad, this.order, this.out);
    this.listeners.forEach((listener) => listener());
  }

  // What each change is worth, and the commands of those that are worth it. Taking an effect out
  // again is always possible.
  judge(changed) {
    const judged = changed.map((effect) => [effect, judge(this.triad, this.order, effect, this.out)]);
    this.output("judgement").replaceChildren(...judged.filter(([, result]) => result).map(([effect, result]) => {
      const line = document.createElement("p");
      line.textContent = judgementText(result);
      line.className = effect.in_model !== (result.isThere && result.change < 0) ? "helps" : "harms";
      return line;
    }));
    const commands = judged.map(([effect, result]) => {
      const target = `${this.config} ${shellWord(`${this.triad.triad}.${effect.name}`)}`;
      if (effect.in_model) return `pipeline remove ${target}`;
      if (!result || !result.helps) return "";
      const isGuess = effect.aliases.length && !effect.is_named;
      return `pipeline add ${target}${isGuess ? " --although-aliased" : ""}`;
    }).filter(Boolean);
    this.output("commands").textContent = commands.join("\n");
    this.output("commanded").hidden = commands.length === 0;
  }

  say(refitted) {
    this.output("words").textContent = refitted.dof < FEWEST_DOF
      ? `Only ${Math.max(refitted.dof, 0)} degrees of freedom remain: a model with so many `
        + "parameters fits nearly any data, and this page's figures are rough. `pipeline add` gives "
        + "exact ones; more poses decide."
      : refitted.p < MISFIT_P_VALUE
        ? "The noise of the poses does not explain the residuals yet."
        : "The noise of the poses explains the residuals.";
    this.output("words").dataset.p = String(refitted.p);
    this.output("sizes").replaceChildren(...refitted.sizes.map((size) => {
      const row = document.createElement("tr");
      [`${size.effect} ${size.name}`, withSd(size.value * size.factor, size.sd * size.factor), size.unit].forEach((text) => {
        const cell = document.createElement("td");
        cell.textContent = text;
        row.append(cell);
      });
      row.dataset.size = `${size.effect} ${size.name} ${size.value} ${size.sd}`;
      return row;
    }));
  }

  // Of effects that these poses cannot separate only one can be ticked.
  tie(refitted) {
    for (const effect of this.effects) {
      const box = this.boxes.get(effect.name);
      const rival = this.order.find((other) => other !== effect
        && (other.aliases.includes(effect.name) || effect.aliases.includes(other.name)));
      box.disabled = !box.checked && rival !== undefined;
      const note = this.root.querySelector(`[data-note="${CSS.escape(effect.name)}"]`);
      if (refitted.unseen.includes(effect.name)) {
        note.textContent = "Together with the other ticked effects these poses cannot determine it.";
      } else if (rival) {
        note.textContent = `These poses cannot separate it from ${rival.name}. `
          + `This separates them: ${effect.separates}.`;
      } else if (effect.aliases.length) {
        note.textContent = `These poses cannot separate it from ${effect.aliases.join(" or ")}.`;
      } else {
        note.textContent = "";
      }
    }
  }

  draw(refitted) {
    const { labels } = this.triad, { value, sd } = shownResiduals(this.triad, refitted.residual);
    const inSd = value.map((v, k) => Math.abs(v) / sd[k]);
    const within = inSd.filter((times) => times <= 1).length;
    const largest = inSd.indexOf(Math.max(...inSd));
    this.output("says").textContent = `With the ticked effects ${within} of ${labels.length} residuals `
      + `are smaller than one sd. The largest is ${inSd[largest].toFixed(1)} sds (pose ${labels[largest]}).`;
    const limit = Math.max(this.limit, residualLimit(value, sd));
    this.charts.forEach((chart) => chart.draw(limit, value, sd, this.before.value));
  }
}
