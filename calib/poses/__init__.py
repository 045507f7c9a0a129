"""From readings to poses.

    imu_log, data_sheet (counts to SI) ─ samples ─ checks ─ averaging ─ runs ─ pose_set
                                          a long log: rests ┘     reference ┘     │
                                            conditions (inputs of effects), attitudes

    samples     statistics of one stretch: batch means, waves in step with the plate, the
                converter's steps, creep
    checks      frozen blocks, samples that are not measurements, tests of a pose
    averaging   from one pose to one mean with an honest sd
    rests       still stretches of a long log
    runs        poses under one reference; the rings of a plate that leans
"""
