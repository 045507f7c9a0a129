// The boxes of one plate setting: the angle residual of its clip by term.
class RateSection {
  constructor(rate, config) {
    this.rate = rate;
    this.target = (term) => `${config} ${shellWord(`rate.${rate.setting}.${term}`)}`;
    this.root = document.querySelector(`[data-rate="${CSS.escape(rate.setting)}"]`);
    this.boxes = rate.terms.map((term) => this.root.querySelector(`input[data-term="${term.name}"]`));
    this.boxes.forEach((box) => box.addEventListener("change", () => this.update()));
    this.charts = [...this.root.querySelectorAll("svg.phases")];
    for (const svg of this.charts) {
      const dots = svg.querySelector("path.phase"), ghost = dots.cloneNode();
      ghost.setAttribute("class", "dots ghost ticked-only");
      dots.before(ghost);
    }
    this.asFitted = this.rms(rate.terms.map((term) => term.in_model)).rms;
    this.update();
  }

  tick(name) {
    const box = this.boxes[this.rate.terms.findIndex((term) => term.name === name)];
    if (box) { box.checked = true; this.update(); }
  }

  // The fit of the set of ticked terms, from the table of all sets.
  rms(ticked) { return this.rate.sets[ticked.reduce((sum, on, i) => sum + (on ? 2 ** i : 0), 0)]; }

  update() {
    const { terms, smallest_share: smallest } = this.rate;
    const ticked = this.boxes.map((box) => box.checked);
    const changed = terms.map((_, i) => i).filter((i) => ticked[i] !== terms[i].in_model);
    const { rms, beta } = this.rms(ticked);
    showTile(this.root, "phase", rms, this.asFitted, changed.length);
    this.root.classList.toggle("ticked", changed.length > 0);
    const words = [], commands = [];
    for (const i of changed) {
      const other = this.rms(ticked.map((on, k) => (k === i ? !on : on))).rms;
      const [without, withIt] = ticked[i] ? [other, rms] : [rms, other];
      const share = 1 - (withIt / without) ** 2, there = share > smallest, { name } = terms[i];
      words.push(`${name} explains ${(100 * share).toPrecision(2)} % of the variance: `
        + (there ? "it is there." : "not there."));
      if (terms[i].in_model) commands.push(`pipeline remove ${this.target(name)}`);
      else if (there) commands.push(`pipeline add ${this.target(name)}`);
    }
    const judgement = this.root.querySelector('[data-out="judgement"]');
    judgement.textContent = words.join(" ");
    judgement.className = `judgement ${commands.length ? "helps" : "harms"}`;
    const shown = this.root.querySelector('[data-out="commands"]');
    shown.textContent = commands.join("\n");
    shown.hidden = commands.length === 0;
    this.draw(beta);
  }

  draw(beta) {
    const { y, x, mean_y: meanY, mean_x: meanX, limit } = this.rate;
    const rest = (values, columns) => values.map((value, i) =>
      columns.reduce((sum, column, k) => sum - beta[k] * column[i], value));
    for (const svg of this.charts) {
      const top = Number(svg.dataset.top), bottom = Number(svg.dataset.bottom);
      const at = (value) => ((top + bottom) / 2
        - Math.max(-1, Math.min(1, value / limit)) * (bottom - top) / 2).toFixed(1);
      const moved = (path, values) => {
        const across = path.getAttribute("d").match(/[ML][-\d.]+ /g);
        path.setAttribute("d", across.map((start, i) => `${start}${at(values[i])}`
          + (path.classList.contains("dots") ? "h0" : "")).join(""));
      };
      moved(svg.querySelector("path.phase"), rest(y, x));
      const mean = svg.querySelector("path.mean");
      if (mean) moved(mean, rest(meanY, meanX));
    }
  }
}
