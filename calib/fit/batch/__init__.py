"""Many sensors at once: sessions of one design as arrays with a leading axis.

    pose_stack (the rows' inputs) ─ start (ellipsoids) ─ stacked_rows ─ descent ─ fit_many
    joint_axes, joint_rows ─ joint_equations (any listed effects) ─ joint_basis (what poses see)
        ─ joint_descent ─ joint_finish (covariances, checks) ─ extend_many

The rows, the start, the steps and the checks are those of :mod:`calib.fit.least_squares`, for S
sets of poses in one call of NumPy. ``fit_many`` fits bias, scale and misalignment from nothing, as
far as a calibration goes; ``extend_many`` adds effects of any kind to such fits from where they
stand, as far as sets of effects are weighed. They are two, since a base needs neither axes nor
vectors that are solved for. What leaves its stack, or fails a check, is fitted by
:func:`calib.fit.least_squares.solver.fit` or ``extend``, so that results and refusals are the same.
"""
