// The fall of chi² by effect: one bar for each effect of the model, in the order of the ticks.
function drawFall(body, order, steps) {
  const whole = Math.max(...steps.map((step) => step.chi2)), last = steps[steps.length - 1];
  const share = (chi2) => `${(100 * chi2 / whole).toFixed(2)}%`;
  const rows = [["base model", 0, steps[0].chi2, order.length ? "" : "rest", short(steps[0].chi2)]];
  order.forEach((effect, i) => {
    const from = steps[i].chi2, to = Math.min(steps[i + 1].chi2, from);
    rows.push([effect.name, to, from, "drop", `−${short(from - to)}`]);
  });
  if (order.length) rows.push(["remains", 0, last.chi2, "rest", short(last.chi2)]);
  while (body.children.length > rows.length) body.lastChild.remove();
  rows.forEach(([name, from, to, kind, text], i) => {
    const row = body.children[i] ?? newFallRow(body), [label, track, number] = row.children;
    row.classList.toggle("total", name === "remains");
    label.textContent = label.title = name;
    number.textContent = text;
    Object.assign(track.firstChild.style, { left: share(from), width: share(to - from) });
    track.firstChild.className = kind;
    track.lastChild.style.left = share(Math.min(last.dof, whole));
  });
  body.setAttribute("role", "img");
  body.setAttribute("aria-label", `chi² by effect: ${rows.map((row) => `${row[0]} ${row[4]}`).join("; ")}. `
    + `Noise alone gives about ${last.dof}.`);
}

function newFallRow(body) {
  const row = document.createElement("div"), track = document.createElement("span");
  row.className = "fall-row";
  track.className = "fall-track";
  track.append(document.createElement("i"), document.createElement("b"));
  row.append(document.createElement("span"), track, document.createElement("span"));
  body.append(row);
  return row;
}
