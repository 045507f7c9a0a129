"""From poses and a model to a calibration with its uncertainty.

    model ─ rows ─ least_squares ─ Fit ─┬─ triad ─ TriadCalibration ─┐
      │                                 └────────────────────────────┴─ validation
      parameters

Everything up to the fit is written once, for S sets of poses side by side; a session is S = 1.

``model``           a sum of effects, fitted jointly
``parameters``      alpha, b, k of the paper and the linear form that is fitted
``stacked``         records whose arrays have a leading axis of sets
``linear``          columns of one length, and stacks of small systems that may be singular
``rows``            the equations: magnitude, null and prior rows with their derivatives
``least_squares``   the estimate with its covariance, from the ellipsoid or as published
``triad``           the calibrated triad: its sds, its correction, its frame
``validation``      errors at poses that were not fitted: leave-one-out, excluded, next log
"""
