"""Rows to the estimate with its covariance: a fitted model, for S sets side by side.

    identifiability, visible_basis: what the poses determine, judged before a number is given
    gauss_newton (the one minimiser) ─ shape_starts, square_start (where it begins)
    fitted_sets (covariances, checks) ─ stack_fits (who is refused) ─ solver: fit, extend, fit_sets
    angrisano: the iteration as published                      result: Fit, one set of them
    unknown_sd: sds of pose means from repeated poses, by a fit of them
"""
