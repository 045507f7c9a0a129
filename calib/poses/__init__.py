"""Readings to poses.

    imu_log ─ static_intervals ─ averaging ─ mean_noise ─ runs ─┐
    data_sheet (counts to SI) ───────┘                          ├─ pose_set ─ conditions
                     reference (gravity, plate rate, null poses) ┘  (what effects see)
                                                attitudes: which directions are covered

    static_intervals: rest_candidates (what one threshold gives) ─ attitude_fit (which is best)
"""
