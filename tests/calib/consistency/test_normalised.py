"""Readings that were brought to one length say nothing of the sensor."""

import numpy as np
import pytest

from calib.consistency.raw_samples import require_raw
from calib.errors import Undetermined
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, ImuLog

SHEET = TriadSpec(2 * 9.80665, 16, "twos-complement")


def logs_of(sd: tuple[float, float, float], length: float | None) -> list[ImuLog]:
    """Six poses with noise of so many counts on each axis; brought to ``length`` where given."""
    rng = np.random.default_rng(1)
    logs = []
    for k, up in enumerate(16384 * np.vstack([np.eye(3), -np.eye(3)])):
        counts: FloatArray = up + np.array([120.0, -80.0, 40.0])
        counts = counts + sd * rng.standard_normal((300, 3))
        if length is not None:
            counts *= length / np.linalg.norm(counts, axis=1, keepdims=True)
        logs.append(ImuLog(f"pose_{k + 1:02d}.csv", np.arange(300) / 50, np.rint(counts),
                           np.full((300, 3), np.nan)))
    return logs


def test_vectors_of_one_length_are_refused() -> None:
    with pytest.raises(Undetermined, match=r"pose_01\.csv: .* have one length .* 5 other logs"):
        require_raw(logs_of((50.0, 50.0, 50.0), 16384.0), SHEET)


@pytest.mark.parametrize("sd", [(50.0, 50.0, 50.0), (15.0, 50.0, 50.0), (0.2, 0.2, 0.2)])
def test_what_a_sensor_delivers_is_not(sd: tuple[float, float, float]) -> None:
    require_raw(logs_of(sd, None), SHEET)
