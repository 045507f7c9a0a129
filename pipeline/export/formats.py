"""The formats that ``pipeline export`` writes, as its help lists them; imports nothing."""

#: Format -> one line of help, in the order in which they are listed.
FORMATS: dict[str, str] = {
    "json": "matrix, bias, sds and effects of each triad",
    "csv": "one line for each parameter, with sd, unit and what it may stand for",
    "imu_tk": "acc.calib and gyro.calib of imu_tk",
    "kalibr": "imu.yaml of Kalibr and OpenVINS, scale-misalignment",
    "ros": "imu_calib.yaml of the ROS package imu_calib; accelerometer only",
    "arduino": "a C header with a function for each triad, every effect included",
    "python": "the same as a Python module without dependencies",
    "matlab": "the same as MATLAB and Octave functions",
    "fusion": "a C header for FusionModelInertial of x-io Fusion",
    "px4": "CAL_ACC0 and CAL_GYRO0 parameters of PX4, with its thermal calibration",
    "inav": "CLI commands of INAV",
    "ardupilot": "INS parameters of ArduPilot, with its temperature calibration",
    "residuals": "a CSV row for each pose: residual, sd, leave-one-out, readings",
    "certificate": "one page to print and file (HTML): parameters, reference, residuals, verdict",
}
