"""Readings to poses.

    imu_log ─ static_intervals ─ averaging ─ runs ─┐
    data_sheet (counts to SI) ───────┘             ├─ pose_set ─ conditions (what effects see)
    reference (gravity, rate, null rows) ──────────┘
                                                attitudes: which directions are covered
"""
