"""Poses and a model to a calibration with its uncertainty.

    model ─ sensitive_axes ─ whitening ─ residuals (the rows) ─ shape_derivatives ─ problem
                                                                                       │
    initial_estimate, square_start (where to begin) ─ gauss_newton (the one minimiser) ┤
                                                                                       │
    solver: fit, from the ellipsoid; extend, from a fit at hand ───────────────────────┼─ result
    angrisano: as published ───────────────────────────────────────────────────────────┘ (theta,
    column_scaling, identifiability: what the poses determine                             cov)
                                                                                           │
    leave_one_out, frame_alignment, parameters (alpha, b, k) ─ calibration ─ prediction ───┘
    correction: a model applied to readings
    batch: the same fit for many sensors at once, as stacked arrays
"""
