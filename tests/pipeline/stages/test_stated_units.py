"""A log in SI units of a sensor that is stated in counts is refused with the right unit."""

from pathlib import Path

import pytest

from tests.pipeline.guess.hand_log import hand_log
from tests.pipeline.logs.flight_logs import px4_log
from tests.sessions import configured, pipeline

pytest.importorskip("pyulog")
CONFIG = """\
sensor: {sensor}
site: {{gravity_m_s2: 9.80665}}
accelerometer: {{poses: {{log: flight.ulg, find: still}}}}
"""


@pytest.mark.parametrize(("sensor", "code", "message"), [
    ("mpu-6050", 2, r"flight.ulg is a PX4 log, whose accelerometer is in "
                    r"m/s²; the sensor is stated with `full_scale_g: 2`. Write `sensor: "
                    r"{accelerometer: {unit: m_s2}"),
    ("{accelerometer: {unit: g}}", 2, "stated with `unit: g`. Write"),
    ("{accelerometer: {unit: m_s2}, gyroscope: {unit: deg_s}}", 2, "gyroscope is in rad/s"),
    ("{accelerometer: {unit: m_s2}}", 0, ""),
])
def test_the_unit_of_the_format_counts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], sensor: str, code: int, message: str
) -> None:
    log = hand_log(rests=12)
    px4_log(tmp_path / "flight.ulg", log.time_s, log.acc, log.gyr)
    assert pipeline("check", configured(tmp_path, CONFIG.format(sensor=sensor))) == code
    assert message in capsys.readouterr().err
