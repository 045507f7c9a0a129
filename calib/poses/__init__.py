"""Readings to poses.

    imu_log ─ static_intervals ─ averaging ─ mean_noise ─ runs ─┐
    data_sheet (counts to SI) ───────┘                          ├─ pose_set ─ conditions
                     reference (gravity, plate rate, null poses) ┘  (what effects see)

    a long log      still_search ─ rest_candidates (running_sums) ─ attitude_fit ─ static_intervals
    one pose        frozen ─ pose_checks (batches) ─ averaging: creep, sway, converter_steps,
                    envelope; drift_within judges it by the other poses of its run
    the directions  attitudes: which of them are covered, and their names
"""
