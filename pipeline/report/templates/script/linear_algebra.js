// Linear algebra on arrays of columns.
const dot = (a, b) => { let s = 0; for (let i = 0; i < a.length; i++) s += a[i] * b[i]; return s; };
const norm = (a) => Math.sqrt(dot(a, a));
const subtract = (a, s, b) => { for (let i = 0; i < a.length; i++) a[i] -= s * b[i]; };
const combine = (columns, weights) => {
  const out = new Float64Array(columns[0].length);
  columns.forEach((column, j) => subtract(out, -weights[j], column));
  return out;
};

// Modified Gram-Schmidt, each column twice: A = Q R. A dependent column gets a zero column in Q.
function qr(columns) {
  const q = [], r = [];
  for (const column of columns) {
    const v = Float64Array.from(column), row = new Float64Array(columns.length), whole = norm(v);
    for (let pass = 0; pass < 2; pass++) {
      q.forEach((u, i) => { const s = dot(u, v); row[i] += s; subtract(v, s, u); });
    }
    const rest = norm(v), independent = rest > 1e-9 * whole;
    row[q.length] = independent ? rest : 1;
    q.push(independent ? v.map((value) => value / rest) : new Float64Array(v.length));
    r.push(row);                 // r[j][i] is R_ij
  }
  return { q, r };
}

// Least squares of y on columns with these weights of the rows, by Cholesky's factors of the normal
// equations; a column that depends on others stays near zero.
function weightedSolution(columns, y, weight) {
  const n = columns.length, RIDGE = 1e-12;
  const heavy = columns.map((column) => column.map((value, i) => value * weight[i]));
  const lower = columns.map(() => new Float64Array(n)), x = new Float64Array(n);
  for (let i = 0; i < n; i++) {
    for (let j = 0; j <= i; j++) {
      let s = dot(heavy[i], columns[j]);
      if (i === j) s += RIDGE * Math.max(s, 1);
      for (let k = 0; k < j; k++) s -= lower[i][k] * lower[j][k];
      lower[i][j] = i === j ? Math.sqrt(Math.max(s, RIDGE)) : s / lower[j][j];
    }
  }
  for (let i = 0; i < n; i++) {
    let s = dot(heavy[i], y);
    for (let k = 0; k < i; k++) s -= lower[i][k] * x[k];
    x[i] = s / lower[i][i];
  }
  for (let i = n - 1; i >= 0; i--) {
    for (let k = i + 1; k < n; k++) x[i] -= lower[k][i] * x[k];
    x[i] /= lower[i][i];
  }
  return x;
}

// Values and vectors of a small symmetric matrix by Jacobi rotations; vectors[k] is the k-th.
function eigen(matrix) {
  const n = matrix.length, a = matrix.map((row) => Float64Array.from(row));
  const v = a.map((_, i) => Float64Array.from({ length: n }, (_unused, j) => (i === j ? 1 : 0)));
  for (let sweep = 0; sweep < 60; sweep++) {
    let off = 0;
    for (let p = 0; p < n; p++) for (let q = p + 1; q < n; q++) off += a[p][q] ** 2;
    if (off < 1e-26) break;
    for (let p = 0; p < n; p++) for (let q = p + 1; q < n; q++) {
      if (a[p][q] === 0) continue;
      const theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
      const t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.hypot(theta, 1));
      const c = 1 / Math.hypot(t, 1), s = t * c;
      for (let k = 0; k < n; k++) {
        const x = a[k][p], y = a[k][q];
        a[k][p] = c * x - s * y; a[k][q] = s * x + c * y;
      }
      for (let k = 0; k < n; k++) {
        const x = a[p][k], y = a[q][k];
        a[p][k] = c * x - s * y; a[q][k] = s * x + c * y;
      }
      for (let k = 0; k < n; k++) {
        const x = v[p][k], y = v[q][k];
        v[p][k] = c * x - s * y; v[q][k] = s * x + c * y;
      }
    }
  }
  return { values: a.map((row, i) => row[i]), vectors: v };
}
