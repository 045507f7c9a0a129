"""Readings to poses.

    imu_log, data_sheet (counts to SI) ─ samples ─ checks ─ averaging ─ runs ─ pose_set
                                          a long log: rests ┘     reference ┘     │
                                            conditions (what effects see), attitudes

    samples     what readings of one stretch show: batch means, waves in step with the plate, the
                converter's steps, creep
    checks      frozen blocks, samples that are no measurement, whether a pose is one
    averaging   one pose to one mean with an honest sd
    rests       where a long log lies still
    runs        poses under one reference; the rings of a plate that leans
"""
