"""Poses and a model to a calibration with its uncertainty.

    model ─ rows ─ least_squares ─ Fit ─┬─ triad ─ TriadCalibration ─┐
      │                  │              └────────────────────────────┴─ validation
      parameters         └─ batch

``model``           a sum of effects, fitted jointly
``parameters``      alpha, b, k of the paper and the linear form that is fitted
``column_scaling``  columns of one length, before they are decomposed
``rows``            the equations: magnitude, null and prior rows with their derivatives
``least_squares``   the estimate with its covariance, from the ellipsoid or as published
``triad``           the calibrated triad: its sds, its correction, its frame
``validation``      errors where no pose was fitted: leave-one-out, excluded poses, next log
``batch``           the same fit for many sensors at once, as stacked arrays
"""
