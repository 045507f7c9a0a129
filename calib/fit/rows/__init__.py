"""Poses and a model to whitened rows with their exact derivatives.

    initial_estimate (the ellipsoid) ─ whitening (order, sds) ─┐
    sensitive_axes ─ vector_derivatives ───────────────────────┴─ residuals (the rows)
                                                                    │
                                        shape_derivatives ──────────┴─ problem (what is minimised)
"""
