"""Poses and a model to a calibration with its uncertainty.

    model ─ residuals (the rows) ─┬─ gauss_newton ─ solver (default) ─┬─ result (theta, cov)
    initial_estimate ─────────────┘  angrisano (as published) ────────┘    │
    column_scaling, identifiability: what the poses determine              │
                     leave_one_out, frame_alignment ───────────────────────┤
                     calibration (alpha, b, k; budget) ─ prediction ───────┘
"""
