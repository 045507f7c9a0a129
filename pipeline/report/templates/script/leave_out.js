// The refit without some poses: of one step, as all refits of the page.
const FAINT = 1e-6;  // weight of a row that is to be predicted and not fitted

function refitWithout(triad, ticked, out) {
  if (out.size === 0) return refit(triad, ticked);
  const [less, effects] = withoutPoses(triad, ticked, out);
  // With the poses as faint rows the same fit predicts them.
  const d = triad.row_pose.length;
  const faint = (column) => column.map(
    (value, i) => (i < d && out.has(triad.row_pose[i]) ? FAINT * value : value));
  const predicted = refit(...withColumns(triad, ticked, faint));
  return { ...refit(less, effects), residual: predicted.residual };
}

// Whether the poses that are not in ``out`` determine bias, scale and misalignment.
function determined(triad, out) {
  const [less] = withoutPoses(triad, [], out);
  const columns = less.base.slice(0, triad.base_fitted).map(
    (column) => column.slice(0, less.row_pose.length));
  return columns[0].length > columns.length && qr(columns).q.every((u) => dot(u, u) > 0.5);
}

function withoutPoses(triad, ticked, out) {
  const isOut = triad.row_pose.map((pose) => out.has(pose));
  const only = (column) => column.filter((_, i) => !isOut[i]);
  const [less, effects] = withColumns(triad, ticked, only);
  const share = 1 - out.size / triad.labels.length;
  return [{ ...less, row_pose: only(triad.row_pose), row_unit: only(triad.row_unit),
    noise_dof: triad.noise_dof * share }, effects];
}

// A triad and effects with ``change`` applied to every column.
function withColumns(triad, ticked, change) {
  return [
    { ...triad, y: change(triad.y), root: change(triad.root), base: triad.base.map(change) },
    ticked.map((effect) => ({ ...effect, columns: effect.columns.map(change),
      judged: effect.judged && effect.judged.map(change) })),
  ];
}
