"""PX4 logs (ULog): sensor_accel and sensor_gyro, the uncorrected readings."""

from pathlib import Path

import numpy as np
from pyulog import ULog
from pyulog.exceptions import ULogException

from calib.poses.imu_log import TEMPERATURE
from pipeline.errors import UnreadableInput
from pipeline.logs.columns import ACCELEROMETER, GYROSCOPE, TIME
from pipeline.logs.formats.file_table import FileTable

TOPICS = {"sensor_accel": ACCELEROMETER, "sensor_gyro": GYROSCOPE}
#: Topic whose readings the autopilot's own calibration has corrected.
CORRECTED = "sensor_combined"


def tables(path: Path) -> list[FileTable]:
    """A table for each instance of each sensor, in m/s², rad/s and seconds."""
    try:
        with path.open("rb") as file:  # the library does not close files that it refuses
            log = ULog(file, [*TOPICS, CORRECTED])
    except ULogException as error:
        raise UnreadableInput(f"{path}: is no complete PX4 log ({error}). Copy it again from the "
                              "flight controller.") from error
    listed = []
    for data in log.data_list:
        if data.name in TOPICS:
            triad = TOPICS[data.name]
            stamp = data.data.get("timestamp_sample", data.data["timestamp"])
            columns = {TIME: np.asarray(stamp, float) * 1e-6}
            columns |= {ours: np.asarray(data.data[axis], float)
                        for ours, axis in zip(triad, "xyz", strict=True)}
            if "temperature" in data.data:
                columns[TEMPERATURE] = np.asarray(data.data["temperature"], float)
            listed.append(FileTable(f"{data.name}_{data.multi_id}", columns))
    if not listed and any(data.name == CORRECTED for data in log.data_list):
        raise UnreadableInput(
            f"{path}: holds {CORRECTED} only, which the autopilot has corrected by its old "
            "calibration. Set SDLOG_PROFILE to log sensor_accel and sensor_gyro, and record again."
        )
    return listed
