"""What the numbers of a triad are: its unit or counts, why, and what is not sure of it."""

import math
from dataclasses import dataclass

import numpy as np

from calib.poses.imu_log import FloatArray
from pipeline.guess.magnitudes import (
    CODES,
    COUNTS_PER_DEG_S,
    FORCE_UNITS,
    LEAST_AGREEMENT,
    LOOSEST,
    NEAR_THOUSAND,
    OFFSET_BINARY,
    OFFSET_COUNTS_PER_DEG_S,
    RATE_UNITS,
    GravityUnit,
    nearest_rate_unit,
    record_rpm,
    sample_noise_sd,
    signed,
    typical_length,
)
from pipeline.guess.triads import SURE_AGREEMENT, PossibleTriad, Triple, called, triples_by_name

BITS, MORE_BITS = 16, 32
"""Facts: of the converters in use; a smaller one gives words of 16 bits, one of 24 those of 32."""
UNIT_WORDS = {"m_s2": "m/s²", "rad_s": "rad/s", "deg_s": "°/s", "mrad_s": "mrad/s",
              "mdeg_s": "m°/s", "rpm": "rpm"}
FASTEST_HAND_RAD_S = 25.0
"""Gyroscopes of phones and hobby boards end at 2000 °/s, and no hand turns as fast as 1400 °/s."""

FASTEST_DEG_S = 4000.0  #: fact: the widest range of a MEMS gyroscope in use
NOISIEST_RAD_S = 0.03
"""Noise of one sample of a gyroscope, at most: 2 °/s, ten times that of an MPU-6050."""

LARGEST_BIAS_RAD_S = 0.35
"""Bias of a gyroscope that rests in most of its log: 20 °/s, the most that data sheets allow."""


@dataclass(frozen=True)
class TriadGuess:
    """What the numbers of a triad are.

    Parameters
    ----------
    columns : tuple of str
        Their names in the file, x, y, z.
    sheet : tuple of (str, value) pairs
        What a configuration states under ``sensor:``.
    unit : str
        The same in words.
    because : str
        Why.
    si_per_unit : float
        Roughly, SI units per unit of the log.
    doubt : str
        What is not sure of it; empty where nothing is.
    is_open : bool
        Whether its range is only the most usual one.
    encoding : str
        How it is written as whole numbers; empty for numbers that are no counts.
    """

    columns: Triple
    sheet: tuple[tuple[str, str | float], ...]
    unit: str
    because: str
    si_per_unit: float
    doubt: str = ""
    is_open: bool = False
    encoding: str = ""

    def ranged(self, per_deg: float, because: str) -> "TriadGuess":
        """The gyroscope with ``per_deg`` counts per °/s."""
        return rate_triad(self.columns, "counts", per_deg, self.encoding,
                          f"{self.because}; {because}", "",
                          bits=int(dict(self.sheet).get("bits", BITS)))

    def si(self, values: FloatArray) -> FloatArray:
        """Readings (t, 3) of the file in SI units."""
        return signed(values, self.encoding) * self.si_per_unit


def accelerometer_in(force: PossibleTriad) -> TriadGuess:
    """The accelerometer in the unit in which it reads gravity."""
    unit, words = force.gravity, force.words
    assert unit is not None
    named = triples_by_name(list(force.pool.columns), "acc")
    doubts = (["other columns may be an accelerometer's too"]
              if force.columns in named and len(named) > 1 else [])
    if words.unit in FORCE_UNITS and words.unit != unit.unit:
        doubts.append(f"their names say {words.unit}, in which the median reading would be "
                      f"{unit.length * FORCE_UNITS[words.unit]:.4g} m/s²; they are taken "
                      f"for {_unit_text(unit)}")
    elif not unit.is_sure:
        doubts.append(f"a typical reading is {unit.length:.4g} long, which is gravity in no usual "
                      f"unit or range; {_unit_text(unit)} is taken")
    if unit.encoding and unit.per_g in NEAR_THOUSAND and words.unit not in FORCE_UNITS:
        doubts.append(f"whole numbers {unit.length:.4g} long at rest may be mg, or counts of which "
                      f"980.665 or 1024 are 1 g; {_unit_text(unit)} is nearest")
    because = ("their names" if called(words) == "acc" else
               "their readings are as long as gravity")
    sheet = ((("unit", unit.unit),) if unit.unit != "counts" else
             _counts("counts_per_g", unit.per_g, unit.encoding, _bits(force)))
    return TriadGuess(force.columns, sheet, _unit_text(unit),
                      f"{because}; a reading at rest is {unit.length:.4g} long", unit.si_per_unit,
                      "; ".join(doubts), encoding=unit.encoding)


def gyroscope_in(
    rate: PossibleTriad, force: PossibleTriad | None, accelerometer: TriadGuess | None
) -> TriadGuess:
    """The gyroscope in the unit that its name, the turns of gravity or its size shows."""
    words, encoding = rate.words, rate.encoding
    because = ("their names" if called(words) == "gyr" else "the name of the file"
               if rate.pool.hint == "gyr" else "they stand beside the accelerometer")
    whole = np.array_equal(rate.values, np.rint(rate.values))
    if not encoding and whole and accelerometer and accelerometer.encoding == "twos-complement":
        encoding = "twos-complement"  # a few counts at rest look like any small numbers
    turned = rate.turns(force) if force and rate.is_sensor else None
    seen = turned if turned and turned[1] >= LEAST_AGREEMENT and rate.pool.has_clock else None
    if words.unit in RATE_UNITS and (
            seen is None or LOOSEST > seen[0] / RATE_UNITS[words.unit] > 1 / LOOSEST):
        return rate_triad(rate.columns, words.unit, None, "",
                          f"{because}, which state the unit", "")
    if seen is not None:
        unit, per_deg = nearest_rate_unit(seen[0], encoding,
                                          accelerometer.si_per_unit if accelerometer else None)
        doubt = (f"its names state {UNIT_WORDS[words.unit]}, in which gravity would turn by "
                 f"{RATE_UNITS[words.unit] / seen[0]:.3g} times what the accelerometer sees"
                 if words.unit in RATE_UNITS else "")
        if unit == "counts" and not encoding:
            doubt = (f"gravity turns by {seen[0]:.3g} rad/s per unit of the gyroscope, which is no "
                     f"usual unit; see whether the times are right")
        return rate_triad(rate.columns, unit, per_deg, encoding, (
            f"{because}; between the rests gravity turns by what {seen[0]:.3g} rad/s per unit "
            f"make of the readings (correlation {seen[1]:.2f})"), doubt, bits=_bits(rate))
    sized = _by_size(rate, encoding, because)
    if force is None or turned is None or turned[1] >= LEAST_AGREEMENT:
        return sized
    axes, agreement = rate.turns_about(force)
    if agreement < SURE_AGREEMENT:
        return sized
    doubt = (f"the gyroscope's x, y, z turn gravity as rates about the accelerometer's {axes} "
             f"would: the two sensors are mounted differently")
    return TriadGuess(sized.columns, sized.sheet, sized.unit, sized.because, sized.si_per_unit,
                      "; ".join(filter(None, [sized.doubt, doubt])), sized.is_open, sized.encoding)


def _by_size(rate: PossibleTriad, encoding: str, because: str) -> TriadGuess:
    """The unit of a gyroscope by how fast things turn."""
    length, noise = typical_length(rate.values), sample_noise_sd(rate.values)
    for unit, size in RATE_UNITS.items():
        rpm = record_rpm(length * size) if not encoding else None
        if rpm is not None and noise * size < NOISIEST_RAD_S:
            return rate_triad(rate.columns, unit, None, "", (
                f"{because}; {length:.4g} is {rpm:.3g} rpm, a speed of record players"), "")
    if encoding:
        known = OFFSET_COUNTS_PER_DEG_S if encoding == OFFSET_BINARY else COUNTS_PER_DEG_S
        return rate_triad(rate.columns, "counts", known[0], encoding, because, (
            f"nothing in the log shows the sensitivity of the gyroscope; {known[0]:.0f} counts per "
            f"°/s is one of several"), is_open=True, bits=_bits(rate))
    fastest = float(np.quantile(np.abs(rate.values - np.median(rate.values, axis=0)), 0.999))
    slow = (fastest < FASTEST_HAND_RAD_S and length < LARGEST_BIAS_RAD_S
            and noise < NOISIEST_RAD_S)
    unit = "rad_s" if slow else "deg_s" if fastest < FASTEST_DEG_S else "mdeg_s"
    return rate_triad(rate.columns, unit, None, "", because, (
        f"nothing in the log shows the unit of the gyroscope; its readings reach {fastest:.3g}, "
        f"which suits {UNIT_WORDS[unit]}"))


def rate_triad(
    triple: Triple, unit: str, per_deg: float | None, encoding: str, because: str, doubt: str,
    is_open: bool = False, bits: int = BITS,
) -> TriadGuess:
    """A gyroscope in a unit, or in counts of which ``per_deg`` are 1 °/s."""
    if per_deg is not None:
        return TriadGuess(triple, _counts("counts_per_deg_s", per_deg, encoding, bits),
                          f"counts, {per_deg:g} per °/s" + (f", {encoding}" if encoding else ""),
                          because, math.radians(1) / per_deg, doubt, is_open, encoding)
    return TriadGuess(triple, (("unit", unit),), UNIT_WORDS[unit], because, RATE_UNITS[unit], doubt)


def _bits(triad: PossibleTriad) -> int:
    """The bits of the words that hold all readings."""
    return BITS if np.abs(triad.values).max() <= CODES / 2 else MORE_BITS


def _counts(
    key: str, value: float, encoding: str, bits: int
) -> tuple[tuple[str, str | float], ...]:
    """Counts with their converter; means of counts have none."""
    stated: tuple[tuple[str, str | float], ...] = ((key, value),)
    return (*stated, ("bits", bits), ("encoding", encoding)) if encoding else stated


def _unit_text(unit: GravityUnit) -> str:
    if unit.unit != "counts":
        return UNIT_WORDS.get(unit.unit, unit.unit)
    return f"counts, {unit.per_g:g} per g" + (f", {unit.encoding}" if unit.encoding else "")
