"""The unit or counts of a triad, with the reason and the doubts."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.poses.imu_log import FloatArray
from pipeline.config.units import UNIT_WORDS
from pipeline.guess.clocks import ClockGuess
from pipeline.guess.magnitudes import (
    BNO055_PER_DEG_S,
    BNO055_PER_G,
    CODES,
    COUNTS_PER_DEG_S,
    FORCE_UNITS,
    GRAVITY_TOLERANCE,
    LOOSEST,
    MISTAKEN,
    OFFSET_BINARY,
    OFFSET_COUNTS_PER_DEG_S,
    RATE_UNITS,
    UNITS_PER_DEG_S,
    GravityUnit,
    near_scales,
    rate_scales,
    signed,
    size_of,
)
from pipeline.guess.triads import ChosenTriads, PossibleTriad, Triple, called, triples_by_name
from pipeline.guess.turns import OWN
from pipeline.logs.clock import ASSUMED_HZ, USUAL_HZ
from pipeline.logs.header_words import read_name

BITS, MORE_BITS = 16, 32
"""Facts: word lengths of converters in use: 16 bits for smaller ones, 32 bits for those of 24."""
USUAL_RATE_UNITS = ("rad_s", "deg_s", "mdeg_s")  #: fact: usual units of a gyroscope
WHOLE_RATE_UNITS = ("mrad_s", "mdeg_s", "deg_s")  #: fact: units that are logged as whole numbers
OF_APPLE = re.compile(r"user_?accel|accelerometeraccel|rotation_?rate[ ._]?[xyz]\b", re.IGNORECASE)
"""Names of Apple's CoreMotion beside or of an accelerometer: ``motionUserAccelerationX``, and
``rotationRate.x``, which a browser calls alpha, beta and gamma."""
SPELLED = re.compile(r"[(\[]([^()\[\]]*[/°][^()\[\]]*)[)\]]")
"""A unit of a rate in a name."""
FASTEST_RAD_S = math.radians(4000.0)  #: fact: the widest range of a MEMS gyroscope in use
QUIETEST_RAD_S, NOISIEST_RAD_S = 1e-4, 0.03
"""Range of the noise of one sample of a gyroscope: 0.006 °/s, a third of that of a phone, to 2 °/s,
ten times that of an MPU-6050."""

SHORTEST_LOG_S = 10.0  #: least duration of a log with turns between rests: six poses; a judgement


@dataclass(frozen=True)
class TriadGuess:
    """Guess of the unit or counts of a triad.

    Parameters
    ----------
    columns : tuple of str
        Names of x, y, z in the file.
    sheet : tuple of (str, value) pairs
        Its entry under ``sensor:`` in a configuration.
    unit : str
        The same in words.
    because : str
        Reason for the guess.
    si_per_unit : float
        Approximate SI units per unit of the log; negative of an accelerometer that reads gravity
        and not the specific force.
    doubt : str
        Doubts about the guess; empty if there are none.
    choices : tuple of float
        Possible units per °/s that remain; empty if the unit is known.
    encoding : str
        Encoding of counts; empty for numbers that are not counts.
    is_unusual : bool
        Whether no sensor and no program in use writes such a unit.
    rival : tuple of str or None
        Other columns that may be the accelerometer as well, and these a magnetometer.
    """

    columns: Triple
    sheet: tuple[tuple[str, str | float], ...]
    unit: str
    because: str = field(compare=False)
    si_per_unit: float
    doubt: str = ""
    choices: tuple[float, ...] = ()
    encoding: str = ""
    is_unusual: bool = False
    rival: Triple | None = None

    def scaled(self, per_deg: float, because: str, doubt: str) -> "TriadGuess":
        """The gyroscope with a scale of ``per_deg`` units per °/s, and a ``doubt`` of it or ""."""
        return rate_triad(self.columns, per_deg, self.encoding, f"{self.because}; {because}",
                          "; ".join(filter(None, [self.doubt, doubt])),
                          int(dict(self.sheet).get("bits", BITS)))

    def si(self, values: FloatArray) -> FloatArray:
        """Readings (t, 3) of the file in SI units."""
        return signed(values, self.encoding) * self.si_per_unit


def accelerometer_in(force: PossibleTriad, chosen: ChosenTriads) -> TriadGuess:
    """The guess of an accelerometer beside others, in the unit in which it reads gravity."""
    unit, words = force.gravity, force.words
    assert unit is not None
    named = triples_by_name(list(force.pool.columns), "acc")
    off = abs(unit.length / unit.per_g - 1)
    doubts = ["their names are those of a gyroscope, but they have gravity's length at rest"] * (
        called(words) == "gyr" and words.stem != "g")
    doubts += [f"{', '.join(other)} may be an accelerometer's too" for other in named
              if force.columns in named and other not in (
                  force.columns, chosen.rate.columns if chosen.rate else None)
              and not read_name(other[0]).gravity_free][:1]
    if words.unit in FORCE_UNITS and words.unit != unit.unit:
        doubts.append(f"their names say {words.unit}, in which the median reading would be "
                      f"{unit.length * FORCE_UNITS[words.unit]:.4g} m/s²; they are taken "
                      f"for {_unit_text(unit)}")
    elif not unit.is_sure:
        doubts.append(f"a typical reading is {unit.length:.4g} long, which is gravity in no usual "
                      f"unit or range; {_unit_text(unit)} is taken")
    elif unit.encoding and not (unit.is_exact or called(words) or force.pool.hint
                                or words.unit in FORCE_UNITS):
        doubts.append(f"a typical reading is {unit.length:.4g} long, {off:.0%} off gravity in the "
                      f"nearest unit, {_unit_text(unit)}; a magnetic field has one length too")
    if unit.encoding and words.unit not in FORCE_UNITS:
        doubts += [f"whole numbers {unit.length:.5g} long at rest may be {may_be}; "
                   f"{_unit_text(unit)} is nearest" for may_be, able in zip(
                       ("mg, or counts of which 980.665 or 1024 are 1 g",
                        "mm/s², or counts of which 10,000 are 1 g"), MISTAKEN, strict=True)
                   if any(math.isclose(unit.per_g, per_g) for per_g in able)]
    of_apple = unit.unit == "g" and any(map(OF_APPLE.search, force.pool.columns))
    doubts += ["in g under names of Apple's, they read -1 along the axis that points up; they are "
               "taken with the opposite sign"] * of_apple
    because = "their names" if called(words) == "acc" else "their readings are as long as gravity"
    sheet = ((("unit", unit.unit),) if unit.unit != "counts" else
             _counts("counts_per_g", unit.per_g, unit.encoding, _bits(force)))
    return TriadGuess(force.columns, sheet, _unit_text(unit),
                      f"{because}; a reading at rest is {unit.length:.4g} long",
                      unit.si_per_unit * (-1 if of_apple else 1), "; ".join(doubts),
                      encoding=unit.encoding, rival=chosen.rival.columns if chosen.rival else None)


def gyroscope_in(
    rate: PossibleTriad, force: PossibleTriad | None, accelerometer: TriadGuess | None
) -> TriadGuess:
    """The guess of a gyroscope, in the unit that names or turns of gravity show, or in several."""
    words, encoding = rate.words, rate.encoding
    because = ("their names" if called(words) == "gyr" else "their file"
               if rate.pool.hint == "gyr" else "they read as one beside the accelerometer")
    stated = RATE_UNITS.get(words.unit, 0.0)
    largest, _, whole = size_of(rate.values)
    if not encoding and whole and accelerometer and accelerometer.encoding == "twos-complement":
        encoding = "twos-complement"  # a few counts at rest are not recognised by size
    turn = rate.turns(force) if force else None
    mounted = (f"the gyroscope's x, y, z turn gravity as rates about the accelerometer's "
               f"{turn.axes} would: the two sensors are mounted differently"
               if turn and turn.is_sure and turn.axes != OWN else "")
    seen = turn.si_per_unit if turn and turn.is_exact and rate.pool.has_clock else None
    if stated and (1 / LOOSEST < seen / stated < LOOSEST if seen else not whole or (
            largest * stated < FASTEST_RAD_S)):
        return rate_triad(rate.columns, math.radians(1) / stated, "",
                          f"{because}, which state the unit", mounted)
    spelled = SPELLED.search(rate.columns[0])
    doubt = (f"its names state {spelled[1]}, which is no unit that is known"
             if spelled and not stated else "")
    doubt = f"its names state {UNIT_WORDS[words.unit]}, in which " + (
        f"gravity would turn by {stated / seen:.3g} times what the accelerometer sees" if seen else
        f"whole numbers up to {largest:.0f} are {math.degrees(largest * stated):.3g} °/s: they are "
        f"counts") if stated else doubt
    per_g = STANDARD_GRAVITY_M_S2 / accelerometer.si_per_unit if accelerometer else 0.0
    if turn is None or seen is None:
        choices = _open_scales(rate, encoding, accelerometer, per_g)
        return rate_triad(rate.columns, choices[0], encoding, because,
                          "; ".join(filter(None, [doubt, mounted])), _bits(rate),
                          choices if len(choices) > 1 else ())
    per_deg = math.radians(1) / seen
    able = near_scales(per_deg, rate_scales(encoding, per_g))
    if not able:
        doubt = (f"{doubt}; at {stated / seen / rate.pool.step_s:.3g} Hz both would agree" if stated
                 else f"gravity turns by what {per_deg:.3g} units per °/s of the gyroscope make of "
                      f"its readings, which is no usual unit or range")
    triad = rate_triad(rate.columns, able[0] if able else float(f"{per_deg:.3g}"), encoding, (
        f"{because}; between the rests gravity turns by what {seen:.3g} rad/s per unit make of the "
        f"readings (correlation {turn.agreement:.2f})"),
        "; ".join(filter(None, [doubt, mounted])), _bits(rate), able if len(able) > 1 else ())
    return replace(triad, is_unusual=not able and encoding != OFFSET_BINARY)


def _open_scales(
    rate: PossibleTriad, encoding: str, beside: TriadGuess | None, per_g: float
) -> tuple[float, ...]:
    """Possible units per °/s of a gyroscope by its noise and its largest reading; whole numbers are
    counts of a usual range, or whole °/s, or a small unit if the accelerometer is in mg. So are
    means beside those of an accelerometer in counts."""
    largest, noise, _ = size_of(rate.values)
    sizes = sorted(RATE_UNITS[unit] for unit in USUAL_RATE_UNITS)
    able = [size for size in sizes if largest * size < FASTEST_RAD_S
            and (noise == 0 or QUIETEST_RAD_S < noise * size < NOISIEST_RAD_S)]
    if not encoding:
        in_counts = beside is not None and "counts_per_g" in dict(beside.sheet)
        units = tuple(math.radians(1) / size for size in able or sizes)
        return (*COUNTS_PER_DEG_S, *units) if in_counts else units
    if encoding == OFFSET_BINARY:
        return OFFSET_COUNTS_PER_DEG_S
    bno055 = (BNO055_PER_DEG_S,) if math.isclose(per_g, BNO055_PER_G) else ()
    in_mg = beside is not None and beside.sheet == (("unit", "mg"),)
    whole = [unit for unit in WHOLE_RATE_UNITS
             if (RATE_UNITS[unit] in able if unit == "deg_s" else in_mg)]
    return (*bno055, *COUNTS_PER_DEG_S, *(UNITS_PER_DEG_S[unit] for unit in whole))


def clocked_by_turns(
    clocks: Sequence[ClockGuess], rate: PossibleTriad, force: PossibleTriad, gyroscope: TriadGuess
) -> list[ClockGuess]:
    """Clocks at the rate at which the gyroscope turns gravity as the accelerometer does; unchanged
    where its unit is open, or the rate or the duration would be none of a log."""
    turn = rate.turns(force)
    if turn is None or not turn.is_exact or gyroscope.choices:
        return [*clocks]
    hz = float(f"{ASSUMED_HZ * gyroscope.si_per_unit / turn.si_per_unit:.3g}")
    longest_s = max(len(clock.time_s) for clock in clocks) / hz
    if not (USUAL_HZ[0] < hz < USUAL_HZ[1] and longest_s > SHORTEST_LOG_S):
        return [*clocks]
    return [clock.at(hz, f"{hz:g} Hz follows from the turns, off by 5 % at most")
            for clock in clocks]


def per_sample(
    force: TriadGuess, rate: TriadGuess, step_s: float
) -> tuple[TriadGuess, TriadGuess]:
    """Both triads as increments of velocity and angle, in m/s and rad per sample, if their scales
    are near these (navigation sensors); else unchanged."""
    off = max(abs(math.log(abs(triad.si_per_unit) * step_s)) for triad in (force, rate))
    if off > GRAVITY_TOLERANCE or "unit" in dict(rate.sheet):
        return force, rate
    per_g = STANDARD_GRAVITY_M_S2 * step_s
    because = f"gravity and its turns are what changes in {step_s:.4g} s"
    exact = replace(force, sheet=_counts("counts_per_g", per_g, "", BITS), si_per_unit=1 / step_s,
                    unit=f"counts, {per_g:.5g} per g", because=because, doubt="")
    return exact, rate_triad(rate.columns, math.radians(1) * step_s, "", because, "")


def rate_triad(
    triple: Triple, per_deg: float, encoding: str, because: str, doubt: str,
    bits: int = BITS, choices: tuple[float, ...] = (),
) -> TriadGuess:
    """The guess of a gyroscope with ``per_deg`` units or counts per °/s."""
    unit, size = rate_unit(per_deg), math.radians(1) / per_deg
    if not unit:
        scale = "of a range that is open" if choices else f"{per_deg:g} per °/s"
        return TriadGuess(triple, _counts("counts_per_deg_s", per_deg, encoding, bits),
                          f"counts, {scale}" + (f", {encoding}" if encoding else ""),
                          because, size, doubt, choices, encoding)
    words = " or ".join(UNIT_WORDS.get(rate_unit(choice), f"counts, {choice:g} per °/s")
                        for choice in choices) or UNIT_WORDS[unit]
    return TriadGuess(triple, (("unit", unit),), words, because, size, doubt, choices)


def per_deg_of(stated: str | float | None) -> float | None:
    """Units per °/s of a stated unit, or counts per °/s of a 16-bit sensor with that full scale."""
    if stated is None:
        return None
    return math.radians(1) / RATE_UNITS[stated] if isinstance(stated, str) else CODES / 2 / stated


def rate_unit(per_deg: float) -> str:
    """The unit with ``per_deg`` units per °/s; empty if there is none."""
    return next((unit for unit, size in RATE_UNITS.items()
                 if math.isclose(size * per_deg, math.radians(1))), "")


def _bits(triad: PossibleTriad) -> int:
    """Word length in bits that holds all readings."""
    return BITS if np.abs(triad.values).max() <= CODES / 2 else MORE_BITS


def _counts(
    key: str, value: float, encoding: str, bits: int
) -> tuple[tuple[str, str | float], ...]:
    """Entries of a data sheet for counts, with those of the converter if there is an encoding."""
    stated: tuple[tuple[str, str | float], ...] = ((key, value),)
    return (*stated, ("bits", bits), ("encoding", encoding)) if encoding else stated


def _unit_text(unit: GravityUnit) -> str:
    if unit.unit != "counts":
        return UNIT_WORDS.get(unit.unit, unit.unit)
    return f"counts, {unit.per_g:g} per g" + (f", {unit.encoding}" if unit.encoding else "")
