// A number with what it was before: the bar reaches the notch where nothing has changed.
const NOTCH = 62.5, SAME = 5e-4;
function showTile(root, name, value, before, changed) {
  const output = root.querySelector(`[data-out="${name}"]`);
  const share = value / before, tile = root.querySelector(`[data-tile="${name}"]`);
  output.textContent = short(value);
  output.dataset.value = String(value);
  const better = changed && share < 1 - SAME, worse = changed && share > 1 + SAME;
  tile.classList.toggle("better", better);
  tile.classList.toggle("worse", worse);
  root.querySelector(`[data-was="${name}"]`).textContent = !changed ? "as fitted"
    : `${better ? "▼" : worse ? "▲ worse:" : "="} before ${short(before)}`;
  root.querySelector(`[data-meter="${name}"]`).style.width =
    `${Math.min(100, Math.max(NOTCH * share || 0, 1))}%`;
}
