"""Poses and a model to a calibration with its uncertainty.

    model ─ correction ─ residuals ─ initial_estimate ─ solver ─┬─ gauss_newton, variable_projection
                                                                └─ angrisano (the published solver)
    identifiability ─ result (theta, cov) ─ leave_one_out, frame_alignment
                         └─ calibration (alpha, b, k; budget)
"""
