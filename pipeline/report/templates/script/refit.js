// The refit: one step of calib/fit/least_squares/solver.py on the rows and columns that the page carries.
// pipeline/report/refit_data.py defines the columns.
// The combinations of an effect's parameters that the rows determine beside the known columns, as in
// the solver: all, or those with more than VISIBLE_SHARE of their signal remaining.
function visible(columns, known, norm) {
  const remainder = columns.map((column) => {
    const v = Float64Array.from(column);
    known.forEach((u) => subtract(v, dot(u, v), u));
    return v;
  });
  const { values, vectors } = eigen(remainder.map((a) => remainder.map((b) => dot(a, b))));
  const lost = vectors.filter((_, k) => Math.sqrt(Math.max(values[k], 0)) <= VISIBLE_SHARE);
  const each = columns.map((_, k) => columns.map((_unused, j) => (j === k ? 1 : 0)));
  if (lost.length === 0) return each;
  if (lost.length === columns.length) return [];
  // Perpendicular to what is lost in the parameters' own unit, not in that of unit columns.
  const across = lost.map((v) => Float64Array.from(v, (x, j) => x / norm[j] ** 2));
  return qr([...across, ...each]).q.slice(lost.length).filter((u) => dot(u, u) > 0.5);
}

// The columns that are fitted, factored, and what they leave of the rows: of every row ``residual``
// with its full weight, also of one that a robust loss has weighted down, as in the results.
function solution(triad, ticked) {
  const d = triad.row_pose.length, rows = triad.y.length;
  const columns = triad.base.slice(), parts = [], unseen = [];
  let held = 0;                  // shape parameters that count although their column is not seen
  let known = qr(triad.base.slice(0, triad.base_fitted).map((c) => c.slice(0, d))).q;
  for (const effect of ticked) {
    const linear = effect.has_shape ? effect.columns.slice(0, -1) : effect.columns;
    const judged = effect.has_shape ? effect.judged : linear;
    const seen = visible(judged, known, effect.judged_norm || effect.norm);
    if (seen.length === 0) { unseen.push(effect.name); continue; }
    known = qr([...known, ...seen.map((w) => combine(judged, w))]).q;
    // Judged and fitted columns are scaled each to their own length: the parameters count.
    const whole = seen.length === linear.length;
    const weights = whole || !effect.has_shape ? seen
      : seen.map((w) => w.map((v, k) => v * effect.norm[k] / effect.judged_norm[k]));
    const added = weights.map((w) => combine(linear, w));
    if (effect.has_shape) {
      const fitted = qr(columns.map((c) => c.slice(0, d)).concat(added)).q;
      const shape = visible(effect.columns.slice(-1), fitted, [1]);
      if (shape.length) added.push(effect.columns[effect.columns.length - 1]);
      else held += 1;
    }
    parts.push({ effect, weights, first: columns.length, count: added.length });
    added.forEach((c) => { const full = new Float64Array(rows); full.set(c); columns.push(full); });
  }
  const { q, r } = qr(columns), n = columns.length;
  const remainder = Float64Array.from(triad.y), z = new Float64Array(n);
  q.forEach((u, j) => { z[j] = dot(u, remainder); subtract(remainder, z[j], u); });
  const residual = remainder.map((value, i) => value / Math.max(triad.root[i], 1e-12));
  return { columns, q, r, n, z, remainder, residual, parts, unseen, held };
}

function refit(triad, ticked) {
  const { q, r, n, z, remainder, residual, parts, unseen, held } = solution(triad, ticked);
  const d = triad.row_pose.length;
  const solve = (rhs) => {        // R x = rhs
    const x = Float64Array.from(rhs);
    for (let j = n - 1; j >= 0; j--) {
      x[j] /= r[j][j];
      for (let i = 0; i < j; i++) x[i] -= r[j][i] * x[j];
    }
    return x;
  };
  const beta = solve(z), inverse = [];
  for (let j = 0; j < n; j++) inverse.push(solve(z.map((_, i) => (i === j ? 1 : 0))));
  const chi2 = dot(residual, residual);
  const dof = d - (n - (triad.base.length - triad.base_fitted)) - held;
  const p = dof > 0 ? fTail(chi2 / dof, dof, triad.noise_dof) : NaN;
  const widening = p < MISFIT_P_VALUE ? Math.sqrt(chi2 / dof) : 1;
  let squares = 0;
  for (let i = 0; i < d; i++) squares += (residual[i] * triad.row_unit[i]) ** 2;
  const out = leaveOneOut(triad, q, remainder);
  let outSquares = 0;
  for (let i = 0; i < d; i++) {
    outSquares += (out[i] / Math.max(triad.root[i], 1e-12) * triad.row_unit[i]) ** 2;
  }
  return {
    chi2, dof, p, residual, unseen, rms: Math.sqrt(squares / d), loo: Math.sqrt(outSquares / d),
    sizes: parts.flatMap((part) => sizes(part, beta, inverse, widening, q, d)),
  };
}

function sizes({ effect, weights, first, count }, beta, inverse, widening, q, d) {
  return effect.parameters.map((parameter, k) => {
    const isShape = effect.has_shape && k === effect.parameters.length - 1;
    if (isShape && count === weights.length) {
      return { effect: effect.name, ...parameter, value: effect.start[k], sd: NaN };
    }
    const along = isShape ? [[first + count - 1, 1]] : weights.map((w, j) => [first + j, w[k]]);
    let value = 0, common = 0;
    along.forEach(([j, w]) => { value += w * beta[j]; });
    const response = inverse.map((column) => {
      let s = 0;
      along.forEach(([j, w]) => { s += w * column[j]; });
      return s;
    });
    // The prior rows, last, are the errors that the references have in common: no misfit widens them.
    for (let i = d; i < q[0].length; i++) {
      let p = 0;
      q.forEach((u, j) => { p += response[j] * u[i]; });
      common += p * p;
    }
    const variance = common + widening ** 2 * Math.max(dot(response, response) - common, 0);
    return {
      effect: effect.name, ...parameter,
      value: value / effect.norm[k] + effect.start[k],
      sd: Math.sqrt(variance) / effect.norm[k],
    };
  });
}

// (I - H_bb)^-1 r_b for the rows b of every pose.
function leaveOneOut(triad, q, remainder) {
  const out = new Float64Array(triad.row_pose.length), blocks = new Map();
  triad.row_pose.forEach((pose, i) => {
    if (!blocks.has(pose)) blocks.set(pose, []);
    blocks.get(pose).push(i);
  });
  for (const rows of blocks.values()) {
    const matrix = rows.map((i) => rows.map((j) => {
      let h = 0;
      for (const u of q) h += u[i] * u[j];
      return (i === j ? 1 : 0) - h;
    }));
    const { values, vectors } = eigen(matrix);
    vectors.forEach((vector, k) => {
      let along = 0;
      rows.forEach((i, a) => { along += vector[a] * remainder[i]; });
      along /= Math.max(values[k], SMALLEST_BLOCK);
      rows.forEach((i, a) => { out[i] += vector[a] * along; });
    });
  }
  return out;
}
