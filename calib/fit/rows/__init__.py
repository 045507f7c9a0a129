"""From poses and a model to whitened rows with their exact derivatives.

    initial_estimate (the ellipsoid) ─ whitening (order, sds): what the poses decide ─┐
    surroundings (what effects are evaluated on) ─ model_terms: what the model decides ┤
    sensitive_axes ─ vector_derivatives ─ wave_rows ─ reference_errors ─ residuals (Equations) ─┤
                                     whitened_rows (at one estimate) ─ shape_derivatives ─ problem

To add a kind of row, define a residual and the directions in which it depends on the vectors: it is
joined to the others in ``Equations.rows`` and ``Whitening.directions``, and counted in
``RowOrder``.
"""
