"""From a fitted model to a calibrated triad.

    calibration: parameters, sds and their budget
      ├ determined: sds against sizes;  run_scatter: rates that scatter between runs
      └ correction: the model applied to readings
    rotation ─ frame_alignment: the gyroscope's frame in that of the accelerometer
"""
