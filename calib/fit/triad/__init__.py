"""From a fitted model to a calibrated triad.

    calibration: parameters, sds and their budget
      ├ determined: sds against sizes, and rates that scatter between runs
      ├ within_poses: what the readings of all poses do alike
      ├ correction: the model applied to readings
      └ other_poses: the accelerometer in the poses of the gyroscope
    frame_alignment, leaning: the gyroscope's frame in that of the accelerometer
"""
