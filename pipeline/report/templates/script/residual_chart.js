// A chart of the residuals: its marks move with a tick, pale outlines stay where they were.
// The axis stays as drawn, and grows only for residuals that it could not show.
class ResidualChart {
  constructor(svg, triad) {
    this.svg = svg;
    this.triad = triad;
    this.top = Number(svg.dataset.top);
    this.bottom = Number(svg.dataset.bottom);
    this.marks = [...svg.querySelectorAll("g.mark")];
    const layer = document.createElementNS(svg.namespaceURI, "g");
    layer.setAttribute("class", "ghosts");
    layer.setAttribute("aria-hidden", "true");
    this.ghosts = this.marks.map((mark) => {
      const ghost = mark.cloneNode(true);
      ghost.setAttribute("class", "ghost");
      ghost.querySelector("title")?.remove();
      layer.append(ghost);
      return ghost;
    });
    this.marks[0]?.before(layer);
  }

  draw(limit, value, sd, before) {
    const { shown, several_rows: several, unit } = this.triad;
    const y = (v) => ((this.top + this.bottom) / 2 - v / limit * (this.bottom - this.top) / 2).toFixed(1);
    const place = (node, v) => {
      node.style.transform = `translate(${node.dataset.x}px, ${y(v)}px)`;
      node.style.visibility = Number.isFinite(v) ? "" : "hidden";  // a pose without a prediction
    };
    this.svg.querySelectorAll("[data-fraction]").forEach((text) => {
      text.textContent = short(Number(text.dataset.fraction) * limit);
    });
    this.marks.forEach((mark) => {
      const k = Number(mark.dataset.i);
      place(mark, value[k]);
      mark.querySelector("title").textContent = `${shown[k]}: ${withSd(value[k], sd[k])} ${unit}, `
        + `${short(value[k] / sd[k])} sd`;
    });
    this.svg.querySelectorAll("g.excluded").forEach((mark) => {
      place(mark, Math.max(-limit, Math.min(limit, Number(mark.dataset.value))));
    });
    this.ghosts.forEach((ghost) => place(ghost, before[Number(ghost.dataset.i)]));
    this.svg.querySelectorAll("path.band").forEach((band) => {
      const k = Number(band.dataset.i);
      band.setAttribute("d", `M${band.dataset.x} ${y(several[k] ? 0 : -sd[k])}V${y(sd[k])}`);
    });
  }
}

function residualLimit(value, sd) {
  const typical = Float64Array.from(sd).sort()[Math.floor(sd.length / 2)];
  let limit = SHOWN_SD * typical;
  value.forEach((v, k) => { limit = Math.max(limit, Math.abs(v) + sd[k] || 0); });
  return nice(limit);
}
