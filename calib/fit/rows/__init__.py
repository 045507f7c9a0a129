"""From poses and a model to whitened rows with their exact derivatives.

    initial_estimate (the ellipsoid) ─ whitening (sds): what the poses decide ──────────┐
    surroundings (what effects are evaluated on) ─ model_terms: what the model decides ─┤
    sensitive_axes ─ readings ─ axis_rows, wave_rows ─ residuals (Equations) ───────────┤
                                           whitened_rows (at one estimate) ─ problem ───┘

To add a kind of row, define a residual and the directions in which it depends on the vectors: it is
joined to the others in ``Equations.rows`` and ``Equations.directions``.
"""
