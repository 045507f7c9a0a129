"""Poses and a model to a calibration with its uncertainty.

model ─ residuals (rows, start) ─┬─ solver (default) ─────────────┬─ result (theta, cov)
column_scaling, identifiability ─┘  angrisano (as published) ─────┘    │
                                        ┌──────────────────────────────┤
                leave_one_out, frame_alignment            calibration (alpha, b, k; budget)
"""
