"""Rows to the estimate with its covariance: a fitted model.

    identifiability: what the poses determine, judged before a number is given
    square_start ─ gauss_newton (the one minimiser) ─ solver: fit, extend ─┬─ result (theta, cov)
                                    angrisano: the iteration as published ─┘
    unknown_sd: sds of pose means from repeated poses, by a fit of them
"""
