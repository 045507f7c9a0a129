"""A rehearsal without hardware: a simulated MPU-6050 in a hand that takes each requested pose.

The sensor sends the lines of this project's sketch, several times faster than real time; its own
clock counts the seconds. Gains, biases and noise are those of an ordinary part.
"""

import time
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.poses.data_sheet import Specs
from calib.poses.imu_log import TRIADS, FloatArray
from pipeline.config.load import Config, load_config
from pipeline.config.sensor import sensor_specs
from pipeline.devices.line_pattern import HEADER, mpu6050_temperature_word, sketch_line
from pipeline.devices.sample import CLOCK_MODULUS
from pipeline.errors import ConfigError
from pipeline.files import write_whole
from pipeline.record.session import RecordingDisplay, RecordingView, Session

RATE_HZ, SPEED = 100.0, 6.0  #: samples a second by the sensor's clock, and speed over real time
READ_S = 0.02  #: duration of a read
MOVE_S = 1.5  #: a hand's motion from one pose to the next
HAND_M_S2, HAND_RAD_S = 3.0, 1.0  #: sd of the hand's motion
GAIN = (np.array([1.01, 0.985, 1.02]), np.array([0.99, 1.015, 1.0]))  #: over that of the data sheet
BIAS = (np.array([0.3, -0.2, 0.4]), np.array([0.03, -0.02, 0.01]))  #: m/s², rad/s
NOISE = (0.03, 0.001)  #: sd of a sample, m/s² and rad/s
WARMTH_C = 27.0  #: warmth of the simulated chip; chosen
NAME = "config.yaml"


class DemoSensor:
    """The sensor in the hand: :meth:`lay` sets its next pose, :meth:`lines` gives its lines."""

    def __init__(self, specs: Specs, seed: int = 0) -> None:
        self._specs = specs
        self._rng = np.random.default_rng(seed)
        self._up, self._rate = np.array([0.0, 0.0, 1.0]), 0.0
        self._from, self._moving = self._up, 0.0
        self._count = 0

    def lay(self, up: FloatArray, rate_rad_s: float) -> None:
        """Turn the side ``up`` (3,) of the sensor upwards, on a plate at this rate."""
        if not np.array_equal(up, self._up) or rate_rad_s != self._rate:
            self._from, self._moving = self._up, MOVE_S
            self._up, self._rate = np.asarray(up), rate_rad_s

    def lines(self, count: int) -> Iterator[str]:
        """The next ``count`` lines."""
        for _ in range(count):
            if not self._count:
                yield f"{HEADER}v1 mpu6050 fs_a=2 fs_g=250 odr={RATE_HZ:g}\r\n"
            micros = round(self._count / RATE_HZ * 1e6) % CLOCK_MODULUS
            words = (*self._words(), mpu6050_temperature_word(WARMTH_C))
            yield sketch_line(self._count, micros, words) + "\r\n"
            self._count += 1

    def _words(self) -> tuple[int, ...]:
        """The six readings of one sample in counts."""
        self._moving = max(0.0, self._moving - 1 / RATE_HZ)
        share = 1 - self._moving / MOVE_S
        up = (1 - share) * self._from + share * self._up
        up = up / max(float(np.linalg.norm(up)), 1e-9)
        hand = (HAND_M_S2, HAND_RAD_S) if self._moving else (0.0, 0.0)
        true = (STANDARD_GRAVITY_M_S2 * up, self._rate * up)
        words: list[int] = []
        for triad, value, gain, bias, noise, shake in zip(
                TRIADS, true, GAIN, BIAS, NOISE, hand, strict=True):
            spec = self._specs[triad]
            reading = gain * value + bias + np.hypot(noise, shake) * self._rng.standard_normal(3)
            low, high = spec.count_range
            words += np.clip(np.rint(reading / spec.nominal_scale), low, high).astype(int).tolist()
        return tuple(words)


class DemoPort:
    """The line of a :class:`DemoSensor`; see :class:`pipeline.record.serial_port.Port`."""

    def __init__(self, sensor: DemoSensor) -> None:
        self._sensor = sensor
        self._begun, self._sent = time.monotonic(), 0

    def read(self) -> tuple[bytes, float]:
        """Lines that the sensor has sent since the last read."""
        time.sleep(READ_S)
        now = time.monotonic()
        due = int((now - self._begun) * RATE_HZ * SPEED)
        # A pause of this process is left out: nobody waits for unread lines.
        count = min(due - self._sent, round(RATE_HZ))
        self._sent = due
        return "".join(self._sensor.lines(count)).encode(), now

    def write(self, data: bytes) -> None:
        """Ignore the data: the sensor has no settings."""

    def set_baud(self, baud: int) -> None:
        """Accept any speed."""

    def close(self) -> None:
        """Nothing to release."""


class ObeyedDisplay:
    """A display that also passes the next requested pose to the sensor."""

    def __init__(self, display: RecordingDisplay, sensor: DemoSensor) -> None:
        self._display, self._sensor = display, sensor
        self.say, self.recorded = display.say, display.recorded

    def show(self, view: RecordingView) -> None:
        """Show the view, and take the requested pose."""
        if (wanted := view.next_wanted) is not None:
            self._sensor.lay(wanted, view.block.rate_rad_s or 0.0)
        self._display.show(view)


def demo_config(folder: Path) -> Config:
    """The configuration of the rehearsal in ``folder``, written if it is not there yet.

    Raises
    ------
    ConfigError
        The folder has a configuration of somebody else.
    """
    text = files("pipeline.config").joinpath("templates", "rehearsal.yaml").read_text("utf-8")
    path = folder / NAME
    if path.exists() and path.read_text(encoding="utf-8").partition("\n")[0] != text.partition(
            "\n")[0]:
        raise ConfigError(f"{path}: is no rehearsal. Name a new folder: simulated poses must not "
                          "come among measured ones.")
    if not path.exists():
        write_whole(path, text)
    return load_config(path, files_may_be_missing=True)


def demo_session(config: Config, display: RecordingDisplay) -> Session:
    """The recording of ``config`` from a simulated sensor."""
    sensor = DemoSensor(sensor_specs(config.sensor))
    return Session(config, lambda _baud: DemoPort(sensor), ObeyedDisplay(display, sensor))
