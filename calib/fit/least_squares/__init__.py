"""From rows to the estimate with its covariance: a fitted model, for S sets side by side.

    identifiability, visible_basis: what the poses determine, judged before any number is reported
    gauss_newton (the one minimiser) ─ square_start (its starts)
    finish (covariances, checks) ─ stack_fits (refusals) ─ solver: fit, extend, fit_sets
    angrisano: the iteration as published                      result: Fit, of one set or of S
    unknown_sd: sds of pose means from repeated poses, by a fit of them
"""
