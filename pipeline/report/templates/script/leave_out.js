// The refit with the loss of the fit and without some poses: of one step, as all refits of the page.
const FAINT = 1e-6;  // weight of a row that is to be predicted and not fitted
const ROBUST_ROUNDS = 30, STEADY_WEIGHT = 1e-4;

function refitWithout(triad, ticked, out) {
  const [less, effects] = settledWithout(triad, ticked, out);
  if (out.size === 0) return refit(less, effects);
  // With the poses as faint rows the same fit predicts them.
  let kept = 0;
  const factors = triad.root.map((root, i) => (isOut(triad, i, out) ? FAINT : less.root[kept++] / root));
  const predicted = refit(...withColumns(triad, ticked, (column) => scaled(column, factors)));
  return { ...refit(less, effects), residual: predicted.residual };
}

// The fit itself has its weights; the same other model is asked for several times at every tick: its weights are found once.
const settledModels = new Map();
function settledWithout(triad, ticked, out) {
  const asFitted = out.size === 0 && triad.effects.every(
    (effect) => Boolean(effect.in_model) === ticked.includes(effect));
  if (!triad.huber_sd || asFitted) return withoutPoses(triad, ticked, out);
  const key = JSON.stringify([triad.triad, ticked.map((effect) => effect.name), [...out]]);
  if (!settledModels.has(key)) settledModels.set(key, settled(...withoutPoses(triad, ticked, out)));
  return settledModels.get(key);
}

// The triad and effects with the weights at which Huber's loss settles, as the solver's rounds do.
function settled(triad, ticked) {
  const { columns } = solution(triad, ticked), d = triad.row_pose.length, { y, root } = triad;
  let weight = root.map((value) => value ** 2);
  for (let round = 0; round < ROBUST_ROUNDS; round++) {
    const relative = weight.map((value, i) => value / root[i] ** 2);
    const beta = weightedSolution(columns, y, relative);
    const next = weight.map((old, i) => {
      if (i >= d) return old;
      let rest = y[i];
      columns.forEach((column, j) => { rest -= beta[j] * column[i]; });
      return Math.min(1, triad.huber_sd * root[i] / Math.max(Math.abs(rest), 1e-300));
    });
    const change = Math.max(...next.map((value, i) => Math.abs(value - weight[i])));
    weight = next;
    if (change < STEADY_WEIGHT) break;
  }
  const factors = weight.map((value, i) => Math.sqrt(value) / root[i]);
  return withColumns(triad, ticked, (column) => scaled(column, factors));
}

const scaled = (column, factors) => column.map((value, i) => value * factors[i]);
const isOut = (triad, row, out) => row < triad.row_pose.length && out.has(triad.row_pose[row]);

// Whether the poses that are not in ``out`` determine bias, scale and misalignment.
function determined(triad, out) {
  const [less] = withoutPoses(triad, [], out);
  const columns = less.base.slice(0, triad.base_fitted).map(
    (column) => column.slice(0, less.row_pose.length));
  return columns[0].length > columns.length && qr(columns).q.every((u) => dot(u, u) > 0.5);
}

function withoutPoses(triad, ticked, out) {
  if (out.size === 0) return [triad, ticked];
  const only = (column) => column.filter((_, i) => !isOut(triad, i, out));
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
