"""A log in SI units, and what is refused where nothing shows the scale of its gyroscope."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import UnreadableInput
from pipeline.guess.files import called_accelerometers, why_no_log
from pipeline.guess.no_log import fault_of_rows
from pipeline.guess.raw_tables import RawTable
from pipeline.guess.readings import readings_in_si
from pipeline.logs.text import raw_text

DEG = np.pi / 180
NAMES = ("t", "ax", "ay", "az", "gx", "gy", "gz")


@pytest.mark.parametrize(("name", "per_g", "per_deg", "format_", "option"), [
    ("counts", 16384.0, 131.072, "%d", "--gyroscope-range 2000"),
    ("floats", 9.80665, 1.0, "%.6f", "--gyroscope-unit "),
])
def test_a_log_at_rest_is_no_rate_before_its_scale_is_stated(
    tmp_path: Path, name: str, per_g: float, per_deg: float, format_: str, option: str
) -> None:
    rng = np.random.default_rng(5)
    force = per_g * (np.array([0.05, -0.03, 0.998]) + 2e-3 * rng.standard_normal((2000, 3)))
    rate = per_deg * (np.array([0.6, -0.4, 0.2]) + 0.015 * rng.standard_normal((2000, 3)))
    path = tmp_path / f"{name}.csv"
    np.savetxt(path, np.column_stack([0.01 * np.arange(2000), force, rate]), delimiter=",",
               comments="", fmt=["%.3f", *[format_] * 6], header=",".join(NAMES))
    with pytest.raises(UnreadableInput, match=option):
        readings_in_si(path, None, None, None, print)
    stated = readings_in_si(path, None, None, 250.0 if format_ == "%d" else "deg_s", print)
    assert np.std(stated.gyroscope) / np.std(rate) == pytest.approx(DEG / per_deg, rel=0.01)
    assert np.linalg.norm(stated.accelerometer, axis=1).mean() == pytest.approx(9.8, rel=0.01)


def test_counts_of_two_sensors_side_by_side_are_no_bytes() -> None:
    """Where one jumps by more than half a byte as the other steps back; bytes end at 255."""
    rows = [f"{276 + 150 * jumps},{26 - jumps},1" for jumps in (i % 50 == 0 for i in range(500))]
    text = raw_text(Path("log.csv"), ["", "az,gx,n", *rows])
    assert text is not None
    assert fault_of_rows(text) == ""


def test_a_battery_and_a_magnetometer_are_no_accelerometer_that_lies_still(tmp_path: Path) -> None:
    still = {"X (a.u.)": np.full(9, 1.0), "Y (a.u.)": np.full(9, 2.0), "Z (a.u.)": np.full(9, 3.0)}
    for name in ("Battery.csv", "Magnetometer.csv"):
        assert called_accelerometers(RawTable(tmp_path / name, still)) == []


def test_the_volts_of_an_analog_sensor_are_no_acceleration_without_gravity(tmp_path: Path) -> None:
    """At 3.3 V three axes read 1.65 V each at 0 g, 2.9 in all, a third of gravity in m/s²."""
    rng = np.random.default_rng(0)
    up = np.repeat(np.vstack([np.eye(3), -np.eye(3)]), 300, axis=0)
    volts = 1.6 + 0.3 * up + 1e-3 * rng.standard_normal(up.shape)
    table = RawTable(tmp_path / "log.csv", dict(zip(("acc_x", "acc_y", "acc_z"), volts.T,
                                                    strict=True)))
    assert "as the volts" in why_no_log(table)
