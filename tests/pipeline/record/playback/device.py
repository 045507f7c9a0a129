"""The simulated device: the bytes that a sensor in the recorded poses would send.

The poses come in the order of the configuration, each is held for a while, a hand moves the sensor
from one to the next, and the sequence is repeated without end. The device speaks the legacy Xsens
protocol, the lines of this project's sketch, those of i2cdevlib's MPU6050_raw, or its binary
stream; stated shares of the samples are damaged.
"""

import random
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray
from pipeline.devices.line_pattern import HEADER, mpu6050_temperature_word, sketch_line
from pipeline.devices.sample import CLOCK_MODULUS
from pipeline.devices.xsens import (
    COUNTER_MODULUS,
    DATA_LENGTH_AT,
    ERROR,
    GO_TO_CONFIG,
    GO_TO_MEASUREMENT,
    MTDATA,
    RAW_COUNTED,
    REQUEST_CONFIGURATION,
    RESET,
    SET_PERIOD,
    TEMPERATURE_STEP_C,
    TICKS_PER_S,
    WAKE_UP,
    WAKE_UP_ACK,
    WRONG_PERIOD,
    XbusReader,
    frame,
)
from tests.pipeline.record.playback import Protocol

CONFIGURATION_BYTES = 118  #: of the answer to a request of configuration, by the manual
MOVE_S = 1.2  #: a hand's motion from one pose to the next
HAND_M_S2, HAND_RAD_S = 3.0, 1.5  #: standard deviation of what the hand adds
GREETING = b"Initializing I2C devices...\r\nMPU6050 connection successful\r\n"
HEADER_EVERY = 1000  #: samples
NO_FIELD = (2**15,) * 3  #: words of the magnetometer: the middle of their range
SAME_RATE = 0.02  #: relative; a device sets itself to the nearest rate that it can do


@dataclass(frozen=True, eq=False)
class Pose:
    """Counts of one pose: ``words`` (t, 6), accelerometer and gyroscope; ``temperature_c`` (t,)."""

    label: str
    words: FloatArray
    temperature_c: FloatArray


@dataclass(frozen=True)
class Faults:
    """Shares of the samples that are lost, get a bit flipped, or have garbage before them."""

    lost: float = 0.0
    flipped: float = 0.0
    garbage: float = 0.0

    def apply(self, data: bytes, rng: random.Random) -> bytes:
        """The bytes of one sample as they arrive: whole, damaged or none."""
        if rng.random() < self.lost:
            return b""
        if rng.random() < self.flipped:
            hit = bytearray(data)
            hit[rng.randrange(len(hit))] ^= 1 << rng.randrange(8)
            data = bytes(hit)
        if rng.random() < self.garbage:
            data = rng.randbytes(rng.randrange(1, 12)) + data
        return data


def played(
    poses: list[Pose], rate_hz: float, hold_s: float, specs: tuple[TriadSpec, TriadSpec], seed: int
) -> Iterator[tuple[FloatArray, float]]:
    """Words (6,) and temperature of every sample, without end.

    A pose shorter than ``hold_s`` is played forwards and backwards in turn, which leaves its noise
    as it is and makes no jump.
    """
    rng = np.random.default_rng(seed)
    scale = np.repeat([1 / spec.nominal_scale for spec in specs], 3)
    hand = np.repeat([HAND_M_S2, HAND_RAD_S], 3) * scale
    moving = round(MOVE_S * rate_hz)
    last = poses[-1].words[-1]
    while True:
        for pose in poses:
            first = pose.words[0]
            share = np.linspace(0, 1, moving)[:, None]
            way = last + share * (first - last) + hand * rng.standard_normal((moving, 6))
            for words in way:
                yield words, float(pose.temperature_c[0])
            there_and_back = np.concatenate([np.arange(len(pose.words)),
                                             np.arange(len(pose.words) - 2, 0, -1)])
            for i in range(round(hold_s * rate_hz)):
                at = there_and_back[i % len(there_and_back)]
                yield pose.words[at], float(pose.temperature_c[at])
            last = pose.words[at]


class PlaybackDevice:
    """Bytes of a device: what it sends by itself, and what it answers.

    Parameters
    ----------
    protocol : str
        One of ``PROTOCOLS``.
    poses, rate_hz, hold_s, specs, seed
        See :func:`played`.
    faults : Faults
    """

    def __init__(
        self,
        protocol: Protocol,
        poses: list[Pose],
        rate_hz: float,
        hold_s: float,
        specs: tuple[TriadSpec, TriadSpec],
        seed: int = 0,
        faults: Faults | None = None,
    ) -> None:
        self._protocol, self._rate_hz = protocol, rate_hz
        self._samples = played(poses, rate_hz, hold_s, specs, seed)
        self._low, self._high = np.array([spec.count_range for spec in specs]).repeat(3, axis=0).T
        self._faults, self._rng = faults or Faults(), random.Random(seed)
        self._count = 0
        self._requests = XbusReader()
        self.measuring = protocol != "xsens-mti"

    def greeting(self) -> bytes:
        """What the device sends when it is switched on or reset."""
        if self._protocol == "xsens-mti":
            return frame(WAKE_UP)
        return b"" if self._protocol == "sketch" else GREETING

    def next_sample(self) -> bytes:
        """The bytes of the next sample, as they come over the line."""
        words, temperature_c = next(self._samples)
        counts = np.clip(np.rint(words), self._low, self._high).astype(int).tolist()
        data = self._encode(counts, temperature_c)
        self._count += 1
        return self._faults.apply(data, self._rng)

    def _encode(self, words: list[int], temperature_c: float) -> bytes:
        n = self._count
        if self._protocol == "xsens-mti":
            return frame(MTDATA, RAW_COUNTED.pack(
                *words, *NO_FIELD, round(temperature_c / TEMPERATURE_STEP_C), n % COUNTER_MODULUS))
        if self._protocol == "sketch":
            micros = round(n / self._rate_hz * 1e6) % CLOCK_MODULUS
            line = sketch_line(n, micros, (*words, mpu6050_temperature_word(temperature_c)))
            head = "" if n % HEADER_EVERY else f"{HEADER}v1 mpu6050\r\n"
            return f"{head}{line}\r\n".encode()
        if self._protocol == "a/g":
            return ("a/g:\t" + "\t".join(map(str, words)) + "\r\n").encode()
        return b"".join(word.to_bytes(2, "big", signed=True) for word in words)

    def answer(self, data: bytes) -> bytes:
        """What the device answers to the bytes it was sent."""
        if self._protocol != "xsens-mti":
            return b""
        return b"".join(self._answer(message.mid, message.data)
                        for message in self._requests.feed(data))

    def _answer(self, mid: int, data: bytes) -> bytes:
        if mid == WAKE_UP_ACK:
            return b""
        if mid == RESET:
            self.measuring = False
            return frame(RESET + 1) + self.greeting()
        if mid in (GO_TO_CONFIG, GO_TO_MEASUREMENT):
            self.measuring = mid == GO_TO_MEASUREMENT
        if mid == SET_PERIOD:  # what is played has a rate of its own
            wanted_hz = TICKS_PER_S / max(1, int.from_bytes(data, "big"))
            if abs(wanted_hz / self._rate_hz - 1) > SAME_RATE:
                return frame(ERROR, bytes([WRONG_PERIOD]))
        if mid == REQUEST_CONFIGURATION:  # the length of the data is all that the host reads
            length = RAW_COUNTED.size.to_bytes(2, "big")
            after = bytes(CONFIGURATION_BYTES - DATA_LENGTH_AT - len(length))
            return frame(mid + 1, bytes(DATA_LENGTH_AT) + length + after)
        return frame(mid + 1)
