// The tick boxes: least squares on the rows and columns that the page carries, then the page itself.
// pipeline/report/refit_data.py defines the columns; the steps are those of calib/fit/solver.py.
(() => {
  "use strict";
  const data = JSON.parse(document.getElementById("refit-data").textContent);
  const {
    visible_share: VISIBLE_SHARE,    // of a signature, below which it cannot be determined
    smallest_block: SMALLEST_BLOCK,  // 1 - largest leverage of a pose
    misfit_p_value: MISFIT_P_VALUE,  // below it the Birge ratio multiplies the sds
    fewest_dof: FEWEST_DOF,          // a model that leaves fewer explains anything
    shown_sd: SHOWN_SD,              // residual charts show at least this many typical sds
    nice: NICE,                      // limits of an axis, in any decade
  } = data.constants;

  // --- linear algebra on arrays of columns ------------------------------------------------------
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

  // --- the F distribution, by the continued fraction of the incomplete beta function -------------
  function logGamma(x) {
    const c = [76.18009172947146, -86.50532032941677, 24.01409824083091, -1.231739572450155,
      0.1208650973866179e-2, -0.5395239384953e-5];
    let sum = 1.000000000190015;
    c.forEach((value, i) => { sum += value / (x + i + 1); });
    return (x + 0.5) * Math.log(x + 5.5) - x - 5.5 + Math.log(2.5066282746310005 * sum / x);
  }
  function incompleteBeta(a, b, x) {
    if (x <= 0) return 0;
    if (x >= 1) return 1;
    if (x > (a + 1) / (a + b + 2)) return 1 - incompleteBeta(b, a, 1 - x);
    const front = Math.exp(logGamma(a + b) - logGamma(a) - logGamma(b)
      + a * Math.log(x) + b * Math.log1p(-x)) / a;
    let c = 1, d = 1 / (1 - (a + b) * x / (a + 1)), h = d;
    for (let m = 1; m < 300; m++) {
      const even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
      d = 1 / (1 + even * d); c = 1 + even / c; h *= d * c;
      const odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
      d = 1 / (1 + odd * d); c = 1 + odd / c;
      h *= d * c;
      if (Math.abs(d * c - 1) < 1e-12) break;
    }
    return front * h;
  }
  const fTail = (f, d1, d2) => incompleteBeta(d2 / 2, d1 / 2, d2 / (d2 + d1 * f));

  // --- the refit ---------------------------------------------------------------------------------
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

  function refit(triad, ticked) {
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
    // Rows that a robust loss has weighted down have their full weight again, as in the results.
    const residual = remainder.map((value, i) => value / Math.max(triad.root[i], 1e-12));
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

  // --- the page ----------------------------------------------------------------------------------
  const short = (value) => {
    if (!Number.isFinite(value)) return "–";
    const text = Number(value.toPrecision(3));
    return (Math.abs(text) >= 1e5 || (text !== 0 && Math.abs(text) < 1e-4)
      ? text.toExponential() : String(text)).replace(/-/g, "−");
  };
  const withSd = (value, sd) => {
    if (!(sd > 0)) return short(value);
    const power = Math.max(Math.abs(value), sd) < 1e-4
      ? Math.floor(Math.log10(Math.max(Math.abs(value), sd))) : 0;
    const v = value / 10 ** power, s = sd / 10 ** power;
    const decimals = Math.min(Math.max(0, 1 - Math.floor(Math.log10(s))), 12);
    const text = `${v.toFixed(decimals)} ± ${s.toFixed(decimals)}`.replace(/-/g, "−");
    return power ? `(${text})e−${Math.abs(power)}` : text;
  };
  const nice = (value) => {
    const decade = 10 ** Math.floor(Math.log10(value));
    return decade * NICE.find((m) => decade * m >= value * (1 - 1e-9));
  };

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

    out(name) { return this.root.querySelector(`[data-out="${name}"]`); }

    update() {
      const refitted = refit(this.triad, this.order), was = this.asFitted;
      const exact = this.triad.loo / was.loo;  // refits without each pose, over one step's estimate
      const numbers = { rms: refitted.rms, loo: refitted.loo * exact, chi2: refitted.chi2 / refitted.dof };
      const before = { rms: was.rms, loo: this.triad.loo, chi2: was.chi2 / was.dof };
      const changed = this.effects.filter(
        (effect) => effect.in_model !== this.boxes.get(effect.name).checked);
      for (const [name, value] of Object.entries(numbers)) {
        const output = this.out(name);
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
    }

    say(refitted, changed) {
      this.out("words").textContent = refitted.dof < FEWEST_DOF
        ? `Only ${Math.max(refitted.dof, 0)} degrees of freedom remain: a model with so many `
          + "parameters fits any data. Record more poses before you add it."
        : refitted.p < MISFIT_P_VALUE
          ? "The noise of the poses does not explain the residuals yet."
          : "The noise of the poses explains the residuals.";
      this.out("words").dataset.p = String(refitted.p);
      const body = this.out("sizes");
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
      this.out("commands").textContent = changed.map((effect) => {
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
      this.out("says").textContent = `With the ticked effects ${within} of ${labels.length} residuals `
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

  const sections = data.triads.map((triad) => new Section(triad, data.config));

  // report.html#tick=gyroscope.g_sensitivity,gyroscope.bias_drift opens with these boxes ticked.
  const ticks = /^#tick=(.*)$/.exec(decodeURIComponent(location.hash));
  for (const target of ticks ? ticks[1].split(",") : []) {
    const [triad, ...name] = target.split(".");
    sections.filter((section) => section.triad.triad === triad)
      .forEach((section) => section.tick(name.join(".")));
  }

  // --- the glossary --------------------------------------------------------------------------------
  // A term shows its entry where it stands: under the mouse, with the keyboard's focus, at a touch.
  const tip = document.getElementById("tip");
  const hide = () => {
    tip.hidden = true;
    document.querySelector("[aria-describedby=tip]")?.removeAttribute("aria-describedby");
  };
  const show = (term) => {
    hide();
    const entry = document.getElementById(term.hash.slice(1));
    tip.textContent = entry.querySelector("dd").textContent;
    tip.hidden = false;
    tip.style.left = tip.style.top = "0";  // where its width is free, to measure it
    term.setAttribute("aria-describedby", "tip");
    const at = term.getBoundingClientRect(), size = tip.getBoundingClientRect();
    const room = document.documentElement.clientWidth - size.width - 8;
    const above = at.bottom + size.height + 8 > window.innerHeight;
    tip.style.left = `${Math.max(8, Math.min(at.left, room)) + window.scrollX}px`;
    tip.style.top = `${(above ? at.top - size.height - 4 : at.bottom + 4) + window.scrollY}px`;
  };
  for (const term of document.querySelectorAll("a.term")) {
    term.addEventListener("mouseenter", () => show(term));
    term.addEventListener("mouseleave", hide);
    term.addEventListener("focus", () => show(term));
    term.addEventListener("blur", hide);
    term.addEventListener("click", (event) => { event.preventDefault(); show(term); });
  }
  document.addEventListener("keydown", (event) => { if (event.key === "Escape") hide(); });
})();
