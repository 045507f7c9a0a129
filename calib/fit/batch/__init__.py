"""Many sensors at once: sessions of one design as arrays with a leading axis.

    pose_stack (the rows' inputs) ─ start (ellipsoids) ─ stacked_rows ─ descent ─ fit_many

The rows, the start, the steps and the checks are those of :mod:`calib.fit.least_squares.solver`,
for S sets of poses in one call of NumPy. What does not go straight to its minimum, or fails a
check, leaves the stack and is fitted by :func:`calib.fit.least_squares.solver.fit`, so that results
and refusals are the same.
"""
