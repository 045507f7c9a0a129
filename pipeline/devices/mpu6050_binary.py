"""MPU-6050 on an Arduino: i2cdevlib's OUTPUT_BINARY_ACCELGYRO.

Twelve bytes a sample: ax ay az gx gy gz as 16-bit two's complement, big endian, with neither a
start sign nor a checksum. The phase is found where the sketch's last line of text ends, if that
was heard; else from the readings of a sensor at rest: at the right phase neighbouring samples
differ least, the first three words have the length of gravity and are the noisier ones.
"""

import math
import struct
from itertools import pairwise

from pipeline.devices.sample import COUNTS, DeviceClock, Sample

SAMPLE = struct.Struct(">6h")
GREETING = b"connection successful"  #: the sketch's last words before the readings begin
COUNTS_PER_G = 16384.0  #: fact: at ±2 g, which the chip is set to where nothing else is said
JUDGED = 32  #: samples by which a phase is chosen, and checked ever after
CLEARER = 2.0
"""A phase must be this many times smoother than all at an odd distance: there the low bytes, which
are noise, take the place of the high ones."""

GRAVITY_SHARE = (0.5, 1.6)
"""Shares of what the data sheet says for gravity: offsets and scale of a bad part stay within."""

NOISIER = 2.0
"""At its finest ranges the chip's accelerometer is eight times as noisy, in counts, as its gyro."""

REST_WORD = 3000  #: largest typical gyro word at rest: 23 °/s at ±250 °/s


class Mpu6050BinaryParser:
    """Samples of the binary stream; see :class:`pipeline.devices.sample.Parser`.

    Parameters
    ----------
    counts_per_g : float
        By the data sheet and the range that is set.
    """

    unit = COUNTS
    clock: DeviceClock | None = None

    def __init__(self, counts_per_g: float = COUNTS_PER_G) -> None:
        self.bad = 0
        self.advice = ""
        self._counts_per_g = counts_per_g
        self._buffer = bytearray()
        self._recent = bytearray()
        self._locked = False

    def feed(self, data: bytes) -> list[Sample]:
        """The samples that ``data`` completes."""
        self._buffer += data
        if not self._locked and not self._skip_greeting():
            self._find_phase()
        return self._samples() if self._locked else []

    def finish(self) -> list[Sample]:
        """Nothing: half a sample cannot be told from noise."""
        return []

    def _skip_greeting(self) -> bool:
        """Cut off the text that ends with the greeting; whether the greeting was there."""
        at = self._buffer.find(GREETING)
        if at < 0:
            return False
        end = self._buffer.find(b"\n", at)
        if end >= 0:
            del self._buffer[: end + 1]
            self._locked, self.advice = True, ""
        return True

    def _find_phase(self) -> None:
        needed = SAMPLE.size * (JUDGED + 1)
        if len(self._buffer) < needed:
            return
        if (phase := self._phase_of(self._buffer)) is not None:
            del self._buffer[:phase]
            self._locked, self.advice = True, ""
            return
        self.bad += 1
        del self._buffer[: len(self._buffer) - needed + SAMPLE.size]
        self.advice = (
            "the binary stream has no start sign and its phase is not clear in this pose; press "
            "the board's reset button so that the sketch's first lines are heard, or lay the "
            "sensor on another side"
        )

    def _phase_of(self, data: bytearray) -> int | None:
        """The one phase at which ``data`` reads as a sensor at rest, None where it is not clear."""
        rough = [_roughness(data, phase) for phase in range(SAMPLE.size)]
        parity = rough.index(min(rough)) % 2
        if min(rough[1 - parity :: 2]) <= CLEARER * min(rough):
            return None
        plausible = [phase for phase in range(parity, SAMPLE.size, 2)
                     if self._is_plausible(data, phase)]
        if len(plausible) > 1:
            plausible = [phase for phase in plausible if _is_noisier_first(data, phase)]
        return plausible[0] if len(plausible) == 1 else None

    def _is_plausible(self, data: bytearray, phase: int) -> bool:
        """The first three words have the length of gravity, the last three are small."""
        means = [sum(column) / JUDGED for column in zip(*_samples(data, phase), strict=True)]
        size, rate = math.hypot(*means[:3]), max(map(abs, means[3:]))
        low, high = (share * self._counts_per_g for share in GRAVITY_SHARE)
        return bool(low < size < high and rate < REST_WORD)

    def _samples(self) -> list[Sample]:
        whole = len(self._buffer) // SAMPLE.size * SAMPLE.size
        data = bytes(self._buffer[:whole])
        del self._buffer[:whole]
        self._recent += data
        if len(self._recent) >= SAMPLE.size * (JUDGED + 1):
            recent = self._recent[-SAMPLE.size * (JUDGED + 1) :]
            self._recent.clear()
            # A phase other than 0 that alone reads as a sensor at rest: bytes were lost.
            if self._phase_of(recent) not in (None, 0):
                self.bad += 1
                self._locked = False
                return []
        return [Sample((a, b, c), (d, e, f)) for a, b, c, d, e, f in SAMPLE.iter_unpack(data)]


def _samples(data: bytearray, phase: int) -> list[tuple[int, ...]]:
    return [SAMPLE.unpack_from(data, phase + i * SAMPLE.size) for i in range(JUDGED)]


def _is_noisier_first(data: bytearray, phase: int) -> bool:
    """Whether each of the first three words changes more than any of the last three."""
    changes = [sorted(abs(x - y) for x, y in pairwise(column))[JUDGED // 2]
               for column in zip(*_samples(data, phase), strict=True)]
    return bool(min(changes[:3]) > NOISIER * max(changes[3:]))


def _roughness(data: bytearray, phase: int) -> float:
    """Median change from one sample to the next, summed over the six words; at least 1."""
    steps = sorted(sum(abs(x - y) for x, y in zip(one, two, strict=True))
                   for one, two in pairwise(_samples(data, phase)))
    return float(max(1, steps[len(steps) // 2]))
