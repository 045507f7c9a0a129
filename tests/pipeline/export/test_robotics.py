"""Kalibr and ROS: the file read back corrects a log as the calibration does, in its own frame."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from pipeline.export.apply import apply_results
from pipeline.export.parts import triad_named
from pipeline.export.robotics import lower_and_rotation, to_kalibr, to_ros
from pipeline.results.read import Stored, load_results
from tests.pipeline.conftest import RunSession
from tests.pipeline.export.stored_results import a_log, with_effects

COMMENTED = "    # bias: "


def kalibr_of(stored: Stored) -> tuple[dict[str, Any], list[np.ndarray]]:
    """The file's mapping as Kalibr reads it, and the biases that stand in its comments."""
    text = to_kalibr(stored).files["imu.yaml"]
    biases = [np.array(yaml.safe_load(line.removeprefix(COMMENTED)))
              for line in text.splitlines() if line.startswith(COMMENTED)]
    read: dict[str, Any] = yaml.safe_load(text)["imu0"]
    return read, biases


def nominal(stored: Stored, triad: str, counts: np.ndarray) -> np.ndarray:
    """What a driver publishes: SI units by the data sheet."""
    own = triad_named(stored, triad)
    assert own is not None
    return own.correction.spec.nominal(counts)


def corrected_by_kalibr(stored: Stored) -> tuple[np.ndarray, np.ndarray]:
    """Specific force and rate of the test's log in the body frame of the file.

    Inverse of what Kalibr predicts of a reading: accelerometer M a + b, gyroscope
    M (C w) + A (C a) + b, C = C_gyro_i. Source: ethz-asl/kalibr, ``IccSensors.py``,
    ``IccScaledMisalignedImu.addAccelerometerErrorTerms`` and ``addGyroscopeErrorTerms``.
    """
    read, (bias_a, bias_g) = kalibr_of(stored)
    log = a_log()
    m = np.array(read["accelerometers"]["M"])
    force = np.linalg.solve(m, (nominal(stored, "accelerometer", log.accelerometer) - bias_a).T)
    gyro = {key: np.array(read["gyroscopes"][key]) for key in ("M", "C_gyro_i", "A")}
    bent = gyro["A"] @ gyro["C_gyro_i"] @ force
    left = (nominal(stored, "gyroscope", log.gyroscope) - bias_g).T - bent
    rate = np.linalg.solve(gyro["M"] @ gyro["C_gyro_i"], left)
    return force.T, rate.T


def body_rotation(stored: Stored) -> np.ndarray:
    """From the accelerometer's frame here to the body of the file, by what both make of M."""
    read, _ = kalibr_of(stored)
    own = triad_named(stored, "accelerometer")
    assert own is not None
    matrix = own.alignment * own.units_per_count / own.correction.spec.nominal_scale
    return np.linalg.inv(np.array(read["accelerometers"]["M"])) @ np.linalg.inv(matrix)


def test_the_decomposition_is_a_lower_triangle_times_a_rotation() -> None:
    square = np.eye(3) + 0.05 * np.random.default_rng(1).standard_normal((3, 3))
    lower, q = lower_and_rotation(square)
    assert lower @ q == pytest.approx(square, abs=1e-14)
    assert np.triu(lower, 1) == pytest.approx(0.0, abs=1e-15)
    assert np.diag(lower).min() > 0
    assert q @ q.T == pytest.approx(np.eye(3), abs=1e-14)
    assert np.linalg.det(q) == pytest.approx(1.0)


def test_kalibr_has_its_keys_and_lower_triangles(finished: RunSession) -> None:
    read, _ = kalibr_of(load_results(finished.folder))
    assert list(read) == ["T_i_b", "accelerometers", "gyroscopes", "model", "rostopic",
                          "time_offset"]
    assert set(read["gyroscopes"]) == {"M", "C_gyro_i", "A"}
    assert read["model"] == "scale-misalignment"
    for triad in ("accelerometers", "gyroscopes"):
        assert np.triu(np.array(read[triad]["M"]), 1) == pytest.approx(0.0)


@pytest.mark.parametrize("sensitivity", [0.0, 3e-3])
def test_kalibr_reads_back_as_the_same_correction_in_its_frame(
    finished: RunSession, tmp_path: Path, sensitivity: float
) -> None:
    sizes = sensitivity * np.arange(1.0, 10.0)
    stored = with_effects(finished, tmp_path, "gyroscope", {"g_sensitivity": sizes.tolist()})
    applied = apply_results(stored, a_log()).triads
    force, rate = corrected_by_kalibr(stored)
    body = body_rotation(stored)
    assert body @ body.T == pytest.approx(np.eye(3), abs=1e-9)  # a rotation, nothing else
    assert force == pytest.approx(applied["accelerometer"] @ body.T, abs=1e-7)
    to_accelerometer = Rotation.from_rotvec(
        stored.gyroscope_to_accelerometer_rad).as_matrix()
    expected = applied["gyroscope"] @ to_accelerometer.T @ body.T
    assert rate == pytest.approx(expected, abs=1e-8)


def test_kalibr_says_what_it_loses(finished: RunSession, tmp_path: Path) -> None:
    stored = with_effects(
        finished, tmp_path, "gyroscope",
        {"g_sensitivity": [0.0] * 9, "quadratic": [0.1, 0.2, 0.3]},
    )
    loses = " ".join(to_kalibr(stored).loses)
    assert "stores no bias" in loses
    assert "body frame of the file is that of this calibration, rotated by" in loses
    assert "noise_density" in loses
    assert "cannot store quadratic of the gyroscope" in loses
    assert "g_sensitivity" not in loses


def test_ros_reads_back_as_the_same_correction_from_counts_and_from_the_driver(
    finished: RunSession,
) -> None:
    stored, log = load_results(finished.folder), a_log()
    text = to_ros(stored).files["imu_calib.yaml"]
    expected = apply_results(stored, log).triads["accelerometer"]
    alternative = "\n".join(
        line.removeprefix("# ") for line in text.splitlines() if line.startswith(("# SM", "# bias"))
    )
    published = nominal(stored, "accelerometer", log.accelerometer)
    for raw, given in ((log.accelerometer, yaml.safe_load(text)),
                       (published, yaml.safe_load(alternative))):
        assert list(given) == ["SM", "bias"]
        assert (len(given["SM"]), len(given["bias"])) == (9, 3)
        by_export = raw @ np.array(given["SM"]).reshape(3, 3).T - given["bias"]
        assert by_export == pytest.approx(expected, abs=1e-7)


def test_ros_says_that_the_gyroscope_is_left_out(finished: RunSession) -> None:
    assert any("gyroscope" in says for says in to_ros(load_results(finished.folder)).loses)
