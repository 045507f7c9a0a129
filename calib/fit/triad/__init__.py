"""A fitted model to a calibrated triad.

    calibration: parameters, sds, the budget of what these are of
      ├ determined: the sds beside the sizes;  run_scatter: rates that scatter between runs
      └ correction: the model applied to readings
    rotation ─ frame_alignment: the gyroscope's frame in that of the accelerometer
"""
