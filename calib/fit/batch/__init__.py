"""Many sensors at once: sessions of one design as arrays with a leading axis.

    pose_stack (the rows' inputs) ─ start (ellipsoids) ─ stacked_rows ─ descent ─ fit_many
    joint_axes, joint_rows ─ joint_equations (any listed effects) ─ joint_descent ─ extend_many

The rows, the start, the steps and the checks are those of :mod:`calib.fit.least_squares`, for S
sets of poses in one call of NumPy. ``fit_many`` fits a base from nothing; ``extend_many`` adds
effects to fits from where they stand. What does not go straight to its minimum, or fails a check,
leaves the stack and is fitted by :func:`calib.fit.least_squares.solver.fit` or ``extend``, so that
results and refusals are the same.
"""
