"""Units and encodings from the numbers: gravity has the same magnitude in every attitude.

At rest an accelerometer reads gravity: the radius of the sphere through its readings at rest is the
unit, independent of the bias.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import get_args

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.numbers import MEDIAN_OF_NORMAL
from calib.poses.imu_log import FloatArray, IntArray
from pipeline.config.sensor import ForceUnit, RateUnit
from pipeline.config.units import UNITS
from pipeline.guess.pool import ROUNDEST, Sphere, least_step, sphere_through, still_means

CODES = 65536.0  #: fact: number of codes of a converter of 16 bits
OFFSET_BINARY = "offset-binary"
BNO055_PER_G, BNO055_PER_DEG_S = 980.665, 16.0  #: facts: 100 counts per m/s², and 16 per °/s
TENTHS_OF_MG = 10_000.0  #: fact: whole numbers for 1 g of loggers that drop the point of 1.0000 g
MISTAKEN = ((BNO055_PER_G, 1000.0, 1024.0), (1000 * STANDARD_GRAVITY_M_S2, TENTHS_OF_MG))
"""Facts: whole numbers for 1 g that differ by no more than scale errors: of a BNO055, mg, and 12
bits over ±2 g; mm/s² and tenths of mg."""
MPU_PER_G = (16384.0, 8192.0, 4096.0, 2048.0)  #: facts: an MPU-6050's ±2, 4, 8 and 16 g
COUNTS_PER_G = (16384, TENTHS_OF_MG, 8192, 4096, 2048, 1024, BNO055_PER_G, 512, 256, 128, 64)
"""Facts: 16 bits over ±2, 4, 8 and 16 g; tenths of mg; 12 bits over ±2 and 4 g; 100 counts per m/s²
of a BNO055; 10 bits over ±2, 4 and 8 g."""
OFFSET_COUNTS_PER_G = tuple(CODES / 2 * STANDARD_GRAVITY_M_S2 / full for full in (17.0, 50.0))
"""Facts: MTi with 16 bits over 17 and 50 m/s²."""
COUNTS_PER_DEG_S = tuple(CODES / 2 / full for full in (250.0, 500.0, 1000.0, 2000.0))
"""Facts: 16 bits over ±250, 500, 1000 and 2000 °/s."""
RARE_COUNTS_PER_DEG_S = tuple(CODES / 2 / full for full in (125.0, 4000.0))
"""Facts: 16 bits over ±125 and ±4000 °/s, of few sensors; told where a usual range is taken."""
OFFSET_COUNTS_PER_DEG_S = tuple(CODES / 2 / full for full in (150.0, 300.0, 1200.0))
"""Facts: MTi with 16 bits over ±150, 300 and 1200 °/s."""
ST_SHARE = 1000 / 8.75 / COUNTS_PER_DEG_S[0]
"""Fact: share of these counts in parts of ST's, whose ±250 °/s are 8.75 m°/s per count."""
USUAL_COUNTS_PER_DEG_S = (*COUNTS_PER_DEG_S, *(ST_SHARE * size for size in COUNTS_PER_DEG_S))
"""Facts: those, and those of ST's parts."""
RATE_UNITS = {unit: UNITS[unit][1] for unit in get_args(RateUnit)}  #: fact: rad/s per unit
UNITS_PER_DEG_S = {unit: math.radians(1) / size for unit, size in RATE_UNITS.items()}  #: facts
NEAR_RANGE = math.log(1.1)
"""Largest log ratio of a gyroscope's gain to that of its range: the ranges of two makers are 14 %
apart, and factory gains are within 3 %."""
AS_NEAR = 0.03  #: log ratio by which another range may be farther and still explain a factory gain
RECORD_RPM = (100 / 6, 100 / 3, 45.0, 78.26)
"""Speeds of record players; the slowest and the last are those of gramophones."""

RPM_TOLERANCE = 0.05
"""Relative error of a speed: cheap players turn 2 % too fast and gyroscopes read 3 % wrong."""

GRAVITY_TOLERANCE = 0.15
"""Relative error of gravity: a factory accelerometer reads it within a tenth in every attitude."""

LOOSEST = 1.8
"""Largest ratio of a reading at rest to gravity, or of gravity to it, for an accelerometer: one
board in ``tests`` reads 1.4 g upright."""

FORCE_UNITS = {unit: UNITS[unit][1] for unit in get_args(ForceUnit)}  #: fact: m/s² per unit
MOST_INNER = 0.7
"""Share of readings in the inner half of the codes above which the code of zero is in the middle,
not at the ends. Tuned: ``tests.bench.study_import``, half changes no set, double one of 37."""

NEARLY_ALL = 0.99  #: share of rows; a few may be written while the sensor starts
UNIT_LENGTH = 2e-3
"""Largest relative error of the length of a computed attitude or direction: it is written with at
least three decimals. A sensor's noise and scale errors are larger."""


def encoding_of(values: FloatArray) -> str:
    """The encoding of readings (t, 3) as counts; empty for numbers that are not counts."""
    whole = np.array_equal(values, np.rint(values))
    if not len(values) or not whole or np.abs(values).max() < COUNTS_PER_G[-1] / 2:
        return ""
    if values.min() < 0 or values.max() >= CODES:
        return "twos-complement"
    inner = float(((values > CODES / 4) & (values < 3 * CODES / 4)).mean())
    if inner > MOST_INNER:
        return OFFSET_BINARY
    return "unsigned-twos-complement" if (values > 3 * CODES / 4).any() else "twos-complement"


def signed(values: FloatArray, encoding: str) -> FloatArray:
    """Readings (t, 3) with their sign, in their unit."""
    if encoding == OFFSET_BINARY:
        return values - (CODES - 1) / 2
    if encoding == "unsigned-twos-complement":
        return np.where(values >= CODES / 2, values - CODES, values)
    return values


def is_direction(values: FloatArray) -> bool:
    """Whether readings (t, 3) that turn have the length 1 in nearly all rows: normalised ones."""
    length = np.linalg.norm(values, axis=1)
    usual = float(np.median(length))
    turns = np.ptp(values, axis=0).max() > 2 * GRAVITY_TOLERANCE
    return bool(turns and abs(usual - 1) < UNIT_LENGTH
                and (np.abs(length / usual - 1) < UNIT_LENGTH).mean() > NEARLY_ALL)


def typical_length(values: FloatArray) -> float:
    """Median length of readings (t, 3)."""
    return float(np.median(np.linalg.norm(values, axis=1)))


def sample_noise_sd(values: FloatArray) -> float:
    """Sd of one sample of readings (t, 3), from the differences of successive samples; at least
    that of rounding to the levels that they take."""
    steps = np.abs(np.diff(values, axis=0))
    return max(float(np.median(steps)) / MEDIAN_OF_NORMAL / math.sqrt(2),
               least_step(steps) / math.sqrt(12)) if len(steps) else 0.0


def size_of(values: FloatArray) -> tuple[float, float, bool]:
    """Nearly the largest of readings (t, 3), the noise of one, and whether all are whole numbers.
    """
    return (float(np.quantile(np.abs(values), NEARLY_ALL)), sample_noise_sd(values),
            np.array_equal(values, np.rint(values)))


@dataclass(frozen=True)
class GravityUnit:
    """The unit in which a triad reads gravity.

    ``unit`` is a unit of the configuration or ``counts``, ``per_g`` the number of units per g;
    ``is_sure``: most readings have the length that a known unit gives.
    """

    unit: str
    per_g: float
    encoding: str
    length: float
    is_sure: bool

    @property
    def si_per_unit(self) -> float:
        """SI units per unit of the log."""
        return STANDARD_GRAVITY_M_S2 / self.per_g

    @property
    def may_be_ut(self) -> bool:
        """Whether they may be a magnetic field in whole µT, and not few counts of gravity."""
        return self.per_g in COUNTS_PER_G[-2:] and not self.is_exact

    @property
    def is_exact(self) -> bool:
        """Whether the length differs from gravity in the known unit by no more than a factory gain
        does, as that of a magnetic field does only by chance."""
        return self.is_sure and abs(math.log(self.length / self.per_g)) < AS_NEAR


def gravity_unit(
    values: FloatArray, table: IntArray, step_s: float, encoding: str
) -> GravityUnit | None:
    """The unit in which signed readings (t, 3) are gravity; None if there is none."""
    lengths = np.linalg.norm(values, axis=1)
    length = float(np.median(lengths))
    if not length > 0:
        return None
    spread = float(np.subtract(*np.quantile(lengths, [0.75, 0.25]))) / length
    rests: Sphere | None = sphere_through(still_means(values, table, step_s))
    if rests is not None and rests.is_far:
        return None
    if rests is not None and rests.misfit < spread:
        length, spread = rests.radius, rests.misfit
    physical = () if encoding else [
        (unit, STANDARD_GRAVITY_M_S2 / size) for unit, size in FORCE_UNITS.items()]
    usual = OFFSET_COUNTS_PER_G if encoding == OFFSET_BINARY else COUNTS_PER_G
    counts = [("counts", float(per_g)) for per_g in usual
              if encoding or length > COUNTS_PER_G[-2]]  # not µT
    if encoding == "twos-complement":
        counts += [(unit, STANDARD_GRAVITY_M_S2 / FORCE_UNITS[unit])
                   for unit in ("mg", "mm_s2", "ug")]
    unit, per_g = min((*physical, *counts), key=lambda known: abs(math.log(length / known[1])))
    off = abs(math.log(length / per_g))
    steady = spread < GRAVITY_TOLERANCE
    # If it is gravity at all, its constant length is in a range or unit that is none of these.
    is_unusual = off >= GRAVITY_TOLERANCE and (
        unit == "counts" or (rests is not None and rests.misfit < ROUNDEST))
    if off > math.log(LOOSEST) and not (is_unusual and steady):
        return None
    if is_unusual and steady and (encoding or unit == "counts" or off > math.log(LOOSEST)):
        unit, per_g = "counts", float(f"{length:.3g}")
    elif unit == "counts" and off >= GRAVITY_TOLERANCE:
        per_g = float(f"{length:.2g}")
    return GravityUnit(unit, per_g, encoding, length, steady and off < GRAVITY_TOLERANCE)


def rate_scales(encoding: str, beside_per_g: float) -> tuple[float, ...]:
    """Known scales of a gyroscope with an encoding, in units or counts per °/s.

    ``beside_per_g`` is the accelerometer's scale, units per g, which identifies a BNO055.
    """
    units = tuple(UNITS_PER_DEG_S.values())
    if encoding and math.isclose(beside_per_g, BNO055_PER_G):
        return (BNO055_PER_DEG_S, *units)
    return (*USUAL_COUNTS_PER_DEG_S, *units) if encoding else units


def near_scales(per_deg: float, known: Sequence[float]) -> tuple[float, ...]:
    """The known scales near a measured one, the nearest first; empty if none is near."""
    off = {scale: abs(math.log(per_deg / scale)) for scale in known}
    farthest = min(NEAR_RANGE, min(off.values()) + AS_NEAR)
    return tuple(sorted((scale for scale in off if off[scale] < farthest), key=off.__getitem__))


def record_rpm(rate_rad_s: float) -> float | None:
    """The record player's speed near a rate, in revolutions per minute; None if none is near."""
    rpm = rate_rad_s * 30 / math.pi
    nearest = min(RECORD_RPM, key=lambda speed: abs(math.log(rpm / speed))) if rpm > 0 else 0.0
    return nearest if nearest and abs(rpm / nearest - 1) < RPM_TOLERANCE else None
