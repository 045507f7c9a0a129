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
    this.asFitted = refit(triad, this.order);
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
    const numbers = { rms: refitted.rms, loo: refitted.loo * exact, chi2: refitted.chi2 / refitted.dof };
    const before = { rms: was.rms, loo: this.triad.loo, chi2: was.chi2 / was.dof };
    const changed = this.effects.filter(
      (effect) => effect.in_model !== this.boxes.get(effect.name).checked);
    for (const [name, value] of Object.entries(numbers)) {
      const output = this.output(name);
      output.textContent = short(value);
      output.dataset.value = String(value);
      this.root.querySelector(`[data-was="${name}"]`).textContent =
        changed.length ? `before: ${short(before[name])}` : "as fitted";
      this.root.querySelector(`[data-meter="${name}"]`).style.width =
        `${100 * Math.min(1, Math.max(value / before[name], 0.01) || 0)}%`;
    }
    this.root.classList.toggle("ticked", changed.length > 0);
    this.root.querySelector("[data-result]").hidden = changed.length === 0;
    this.say(refitted, changed);
    this.tie(refitted);
    this.draw(refitted);
    this.listeners.forEach((listener) => listener());
  }

  say(refitted, changed) {
    this.output("words").textContent = refitted.dof < FEWEST_DOF
      ? `Only ${Math.max(refitted.dof, 0)} degrees of freedom remain: a model with so many `
        + "parameters fits any data. Record more poses before you add it."
      : refitted.p < MISFIT_P_VALUE
        ? "The noise of the poses does not explain the residuals yet."
        : "The noise of the poses explains the residuals.";
    this.output("words").dataset.p = String(refitted.p);
    const body = this.output("sizes");
    body.replaceChildren(...refitted.sizes.map((size) => {
      const row = document.createElement("tr");
      [`${size.effect} ${size.name}`, withSd(size.value, size.sd), size.unit].forEach((text) => {
        const cell = document.createElement("td");
        cell.textContent = text;
        row.append(cell);
      });
      row.dataset.size = `${size.effect} ${size.name} ${size.value} ${size.sd}`;
      return row;
    }));
    this.output("commands").textContent = changed.map((effect) => {
      const target = `${this.config} ${this.triad.triad}.${effect.name}`;
      if (effect.in_model) return `pipeline remove ${target}`;
      return `pipeline add ${target}${effect.aliases.length ? " --although-aliased" : ""}`;
    }).join("\n");
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
    const { labels, row_pose: pose, row_unit: unit, is_null: isNull } = this.triad;
    const value = new Float64Array(labels.length), squares = new Float64Array(labels.length);
    const variance = new Float64Array(labels.length);
    pose.forEach((k, i) => {
      value[k] = refitted.residual[i] * unit[i];
      squares[k] += value[k] ** 2;
      variance[k] += unit[i] ** 2;
    });
    isNull.forEach((at_rest, k) => { if (at_rest) value[k] = Math.sqrt(squares[k]); });
    const sd = variance.map(Math.sqrt);
    const typical = Float64Array.from(sd).sort()[Math.floor(sd.length / 2)];
    let limit = SHOWN_SD * typical;
    value.forEach((v, k) => { limit = Math.max(limit, Math.abs(v) + sd[k]); });
    limit = nice(limit);
    const inSd = value.map((v, k) => Math.abs(v) / sd[k]);
    const within = inSd.filter((times) => times <= 1).length;
    const largest = inSd.indexOf(Math.max(...inSd));
    this.output("says").textContent = `With the ticked effects ${within} of ${labels.length} residuals `
      + `are smaller than one sd. The largest is ${inSd[largest].toFixed(1)} sds (pose ${labels[largest]}).`;
    for (const chart of this.root.querySelectorAll("svg.residuals")) {
      const top = Number(chart.dataset.top), bottom = Number(chart.dataset.bottom);
      const y = (v) => ((top + bottom) / 2 - v / limit * (bottom - top) / 2).toFixed(1);
      chart.querySelectorAll("[data-fraction]").forEach((text) => {
        text.textContent = short(Number(text.dataset.fraction) * limit);
      });
      chart.querySelectorAll("g.mark").forEach((mark) => {
        const k = Number(mark.dataset.i);
        mark.setAttribute("transform", `translate(${mark.dataset.x} ${y(value[k])})`);
        if (mark.dataset.titled) {
          mark.querySelector("title").textContent = `${labels[k]}: `
            + `${withSd(value[k], sd[k])} ${this.triad.unit}, ${short(value[k] / sd[k])} sd`;
        }
      });
      chart.querySelectorAll("path.band").forEach((band) => {
        const k = Number(band.dataset.i);
        band.setAttribute("d", `M${band.dataset.x} ${y(isNull[k] ? 0 : -sd[k])}V${y(sd[k])}`);
      });
    }
  }
}
