"""Which columns of a table are the gyroscope's, and in what unit."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from calib.poses.imu_log import AXES, FloatArray
from pipeline.guess.magnitudes import (
    COUNTS_PER_DEG_S,
    LOOSEST,
    RATE_UNITS,
    decoded,
    nearest_rate_unit,
    rate_scale,
    record_rpm,
    sample_noise_sd,
    typical_length,
)
from pipeline.guess.triads import (
    AXIS_COUNT,
    SURE_AGREEMENT,
    UNIT_WORDS,
    Columns,
    TriadGuess,
    Triple,
    neighbours,
    rate_triad,
    stacked,
    triples_by_name,
    turning_triples,
    turns_beside,
)
from pipeline.logs.header_words import GYR, read_name

FUSED_M_S2, BESIDE_FUSED = 0.01, (16.384, 16.0)
"""Fact: the BNO055 reads 100 counts per m/s² and 16 per °/s, which turns tell from 16.384 nowhere.
"""
FASTEST_HAND_RAD_S = 25.0
"""Gyroscopes of phones and hobby boards end at 2000 °/s, and no hand turns as fast as 1400 °/s."""

NOISIEST_RAD_S = 0.03
"""Noise of one sample of a gyroscope, at most: 2 °/s, ten times that of an MPU-6050."""

LARGEST_BIAS_RAD_S = 0.35
"""Bias of a gyroscope that rests in most of its log: 20 °/s, the most that data sheets allow."""


def guess_gyroscope(
    columns: Columns, hint: str, accelerometer: TriadGuess | None, time_s: FloatArray | None
) -> TriadGuess | None:
    """The gyroscope among ``columns``, by name or by its place behind the accelerometer.

    ``time_s`` (t,) shows its unit by how fast gravity turns; None where no clock is known.
    """
    force = {*accelerometer.columns} if accelerometer else {}
    named = [triple for triple in triples_by_name(list(columns), "gyr") if not {*triple} & {*force}]
    triple = named[0] if named else _neighbour_triple(columns, hint, accelerometer, time_s)
    if triple is None:
        return None
    values = stacked(columns, triple)
    signed, encoding = decoded(values[np.isfinite(values).all(axis=1)])
    words = read_name(triple[0])
    if not encoding and accelerometer is not None and _are_counts(accelerometer, signed):
        encoding = "twos-complement"  # a few counts at rest look like any small numbers
    because = "their names" if named else "they stand beside the accelerometer"
    if hint == "gyr" and not named:
        because = "the name of the file"
    measured = None
    if accelerometer is not None and time_s is not None:
        measured = turns_beside(columns, accelerometer, triple, time_s)
    if words.unit in RATE_UNITS and (
            measured is None or LOOSEST > measured[0] / RATE_UNITS[words.unit] > 1 / LOOSEST):
        return rate_triad(triple, words.unit, None, "", f"{because}, which state the unit", "")
    if measured is not None:
        unit, per_deg = nearest_rate_unit(measured[0], bool(encoding))
        doubt = (f"its names state {UNIT_WORDS[words.unit]}, in which gravity would turn by "
                 f"{RATE_UNITS[words.unit] / measured[0]:.3g} times what the accelerometer sees"
                 if words.unit in RATE_UNITS else "")
        assert accelerometer is not None
        if per_deg == BESIDE_FUSED[0] and accelerometer.si_per_unit == FUSED_M_S2:
            per_deg, doubt = BESIDE_FUSED[1], "as the BNO055's, and not 16.4 as others at 2000 °/s"
        return rate_triad(triple, unit, per_deg, encoding, (
            f"{because}; between the rests gravity turns by what {measured[0]:.3g} rad/s per unit "
            f"make of the readings (correlation {measured[1]:.2f})"), doubt)
    sized = _sized_gyroscope(triple, signed, encoding, because)
    if accelerometer is None or time_s is None:
        return sized
    axes = _other_axes(columns, accelerometer, triple, time_s)
    return replace(sized, doubt="; ".join(filter(None, [sized.doubt, axes])))


def _other_axes(
    columns: Columns, accelerometer: TriadGuess, triple: Triple, time_s: FloatArray
) -> str:
    """What the axes of a gyroscope are by the turns of gravity, where they are others by name."""
    force, rate = stacked(columns, accelerometer.columns), stacked(columns, triple)
    whole = np.isfinite(force).all(axis=1) & np.isfinite(rate).all(axis=1)
    for turn in Rotation.create_group("O").as_matrix().round():
        seen = rate_scale(decoded(rate[whole])[0] @ turn.T, decoded(force[whole])[0], time_s[whole])
        if seen is not None and seen[1] > SURE_AGREEMENT:
            named = ", ".join(f"{'-' if row.sum() < 0 else '+'}{AXES[int(np.abs(row).argmax())]}"
                              for row in turn.T)
            return (f"the gyroscope's x, y, z turn gravity as rates about the accelerometer's "
                    f"{named} would: the two sensors are mounted differently")
    return ""


def _are_counts(accelerometer: TriadGuess, values: FloatArray) -> bool:
    """Whether readings (t, 3) are whole numbers beside an accelerometer in signed counts."""
    signed = dict(accelerometer.sheet).get("encoding") == "twos-complement"
    return signed and np.array_equal(values, np.rint(values))


def _sized_gyroscope(triple: Triple, signed: FloatArray, encoding: str, because: str) -> TriadGuess:
    """The unit by how fast things turn."""
    length, noise = typical_length(signed), sample_noise_sd(signed)
    for unit, size in RATE_UNITS.items():
        rpm = record_rpm(length * size) if not encoding else None
        if rpm is not None and noise * size < NOISIEST_RAD_S:
            return rate_triad(triple, unit, None, "", (
                f"{because}; {length:.4g} is {rpm:.3g} rpm, a speed of record players"), "")
    if encoding:
        return replace(rate_triad(triple, "counts", COUNTS_PER_DEG_S[0], encoding, because, (
            "nothing in the log shows the sensitivity of the gyroscope; 131 counts per °/s is that "
            "of ±250 °/s at 16 bits")), is_open=True)
    fastest = float(np.quantile(np.abs(signed - np.median(signed, axis=0)), 0.999))
    slow = (fastest < FASTEST_HAND_RAD_S and length < LARGEST_BIAS_RAD_S
            and noise < NOISIEST_RAD_S)
    unit = "rad_s" if slow else "deg_s"
    return rate_triad(triple, unit, None, "", because, (
        f"nothing in the log shows the unit of the gyroscope; its readings reach {fastest:.3g}, "
        f"which suits {UNIT_WORDS[unit]}"))


def _neighbour_triple(
    columns: Columns, hint: str, accelerometer: TriadGuess | None, time_s: FloatArray | None
) -> Triple | None:
    """Three columns without a meaning that turn gravity, or stand behind or before the
    accelerometer's; all of a file's."""
    names = [name for name in columns if read_name(name).quantity in ("", "gyr")
             or (accelerometer is not None and name in accelerometer.columns)]
    if accelerometer is None:
        free = [name for name in names if not _is_else(name)]
        alone = hint == "gyr" or (hint != "acc" and len(free) == AXIS_COUNT)
        return next(neighbours(free), None) if alone else None
    turned = {} if time_s is None else turning_triples(columns, names, accelerometer, time_s)
    beside = [triple for triple in neighbours(names) if not any(map(_is_else, triple))
              and not {*triple} & {*accelerometer.columns}]
    turned = {triple: agreement for triple, agreement in turned.items()
              if triple in beside or agreement > SURE_AGREEMENT}
    at = names.index(accelerometer.columns[0])
    next_to = [{*names[start : start + AXIS_COUNT]}
               for start in (at + AXIS_COUNT, at - AXIS_COUNT) if start >= 0]
    return max(turned, key=lambda triple: turned[triple], default=next(
        (triple for places in next_to for triple in beside if {*triple} == places), None))


def _is_else(name: str) -> bool:
    """Whether a name with letters stands for something that is not known."""
    stem, quantity = read_name(name).stem, read_name(name).quantity
    return bool(stem) and not stem.isdecimal() and quantity != "gyr" and stem not in GYR
