"""Common parts of exports, and the size of the error that a format leaves.

It is evaluated over the conditions of the session: the corrected vectors of its poses; for the
specific force gravity along every face, edge and corner; for time and every logged column the
values of the poses.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib.consistency.data_sheet import range_by_gain
from calib.effects.effect import Effect
from calib.fit.rows.sensitive_axes import Axes, sensor_columns
from calib.poses.attitudes import natural_directions
from calib.poses.conditions import Conditions
from calib.poses.imu_log import SI_UNIT, TEMPERATURE, FloatArray
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.logs.columns import MINUS
from pipeline.results.read import Stored, StoredTriad
from pipeline.text.plain import one_line
from pipeline.text.untold import untold_notes


def remaining_error(
    stored: Stored, triad: StoredTriad, lost: Iterable[str]
) -> float | None:
    """Largest error by effects that are not corrected, over the conditions of the session.

    Parameters
    ----------
    stored : Stored
    triad : StoredTriad
    lost : iterable of str
        Names of the effects that the format does not hold.

    Returns
    -------
    float or None
        Length of the error vector in SI units; None where the results do not tell.
    """
    names = {*lost}
    effects = [effect for effect in triad.correction.model.effects
               if effect.name in names and effect.told_by in ("sample", "clock")]
    at = session_conditions(stored, triad, effects)
    theta = triad.correction.theta[triad.correction.model.positions(effects)]
    axes = Axes(triad.alignment, np.asarray(np.linalg.inv(triad.alignment), float))
    errors = sensor_columns(effects, at, triad.correction.shapes, axes) @ theta
    lengths = np.linalg.norm(errors, axis=1)
    return float(np.nanmax(lengths)) if np.isfinite(lengths).any() else None


def session_conditions(
    stored: Stored, triad: StoredTriad, effects: Iterable[Effect]
) -> Conditions:
    """Every pose of the session, corrected; once for each direction of gravity where an effect
    needs the specific force.
    """
    poses = [pose for pose in triad.section.poses if None not in pose.corrected]
    vectors = np.array([pose.corrected for pose in poses], float).reshape(-1, 3)
    names = {name for pose in poses for name in pose.columns}
    columns = {name: np.array([pose.columns.get(name) for pose in poses], float) for name in names}
    time_s = np.array([pose.time_s for pose in poses], float)
    whole = Conditions.of_vectors(vectors, columns, time_s=time_s)
    if not any("force" in effect.needs for effect in effects):
        return whole
    units = natural_directions()
    rows = np.repeat(np.arange(len(whole)), len(units))
    repeated = whole.take(rows)
    force = np.tile(stored.gravity_m_s2 * units, (len(whole), 1))
    return Conditions.of_vectors(repeated.vector, repeated.columns, time_s=repeated.time_s,
                                 force=force)


#: Direction of the worked example, in units of its size: no axis is zero.
EXAMPLE_DIRECTION = np.array([0.3, -0.4, 0.85])
ONE_G, OF_OTHERS = 10.0, 1.0  #: size of the example, SI: an accelerometer's, and of others
HASH_DIGITS = 16  #: hexadecimal; two of a million files agree by chance with a probability of 3e-8
SMALL_M_S2 = 1.0  #: errors below are shown in mm/s²


@dataclass(frozen=True)
class Export:
    """Content of each file by name, and the parts of the calibration that they do not store."""

    files: Mapping[str, str | bytes]
    loses: tuple[str, ...]


def triad_named(stored: Stored, name: str) -> StoredTriad | None:
    """The triad of this name; None where it was not calibrated."""
    return next((triad for triad in stored.triads if triad.name == name), None)


def example_counts(triad: StoredTriad) -> FloatArray:
    """The reading of the worked example, counts, (3,)."""
    wanted = EXAMPLE_DIRECTION * (ONE_G if triad.name == "accelerometer" else OF_OTHERS)
    counts = triad.parameters.bias_counts + wanted * triad.parameters.scale_counts_per_unit
    return np.round(counts) if triad.correction.spec.bits else counts


def example(triad: StoredTriad) -> tuple[FloatArray, FloatArray]:
    """A reading in counts and its correction by bias, scale and misalignment, SI; both (3,)."""
    counts = example_counts(triad)
    return counts, triad.parameters.correct(counts)


def example_text(triad: StoredTriad) -> str:
    """The worked example in one line."""
    counts, si = example(triad)
    return f"counts ({plain_row(counts)}) are ({plain_row(si)}) {SI_UNIT[triad.name]}"


def plain_row(values: FloatArray) -> str:
    """Numbers with commas, for a comment."""
    return ", ".join(f"{value:.8g}" for value in values)


def no_sds(stored: Stored) -> tuple[str, ...]:
    """A note that the format does not store the uncertainties."""
    return ("The file does not contain the uncertainties.",) if stored.triads else ()


def no_effects(
    stored: Stored, program: str, held: Mapping[str, tuple[str, ...]] | None = None
) -> tuple[str, ...]:
    """Added effects that ``program`` cannot store; ``held`` by triad are those it can."""
    return tuple(
        note for triad in stored.triads
        for note in lost_effects(
            stored, triad,
            [name for name in triad.section.effects
             if name not in (held or {}).get(triad.name, ())],
            program)
    )


def lost_effects(
    stored: Stored, triad: StoredTriad, names: Sequence[str], program: str
) -> tuple[str, ...]:
    """A note on the effects of a triad that ``program`` does not correct, with their error.

    Effects of the bench are no errors of a reading, and drawn ones cannot be corrected: they need
    no note.
    """
    lost = [one for one in triad.correction.model.effects
            if one.name in names and one.told_by != "bench" and one.acts_on != "noise"]
    notes = untold_notes(triad.name, [one for one in lost if one.told_by == "nothing"],
                         triad.section.error_parts.untold)
    told = [one.name for one in lost if one.told_by != "nothing"]
    if not told:
        return tuple(notes)
    clock = all(one.told_by == "clock" for one in lost)
    error = remaining_error(stored, triad, told)
    size = "" if error is None else f"In this session it is up to {error_text(error, triad.name)}. "
    return (
        f"{program} cannot store {', '.join(told)} of the {triad.name}: its corrected "
        f"readings keep this error. {size}`pipeline apply{' --session-clock' if clock else ''}` "
        f"corrects it.", *notes,
    )


def error_text(error: float, triad: str) -> str:
    """An error of a triad in its usual unit."""
    if triad != "accelerometer":
        kind = TRIAD_KINDS[triad]
        return f"{error * kind.errors_per_unit:.2g} {kind.error_unit}"
    return f"{1000 * error:.3g} mm/s²" if error < SMALL_M_S2 else f"{error:.2g} m/s²"


def origin(stored: Stored) -> tuple[str, ...]:
    """The origin of the numbers, for the comments of a file; each is one line without controls."""
    title = one_line(stored.contents.title) or "untitled"
    lines = [
        f"Calibration of {one_line(stored.contents.sensor)}: {title}",
        f"configuration {one_line(stored.contents.config_sha256)[:HASH_DIGITS]} (SHA-256)",
    ]
    for triad in stored.triads:
        spec = triad.correction.spec
        if spec.bits:
            by_gain = range_by_gain(triad.parameters.scale_counts_per_unit, spec)
            over = f"over +-{spec.full_scale:.6g} {SI_UNIT[triad.name]}"
            if by_gain is not None:
                over = (f"over about +-{by_gain:.3g} {SI_UNIT[triad.name]} by the measured gain, "
                        f"which refutes the +-{spec.full_scale:.6g} of the configuration")
            lines.append(f"{triad.name}: {spec.bits} bits {over}; the calibration is valid for "
                         f"the range of the session only")
    lines += stood_for(stored)
    warmth = temperatures(stored)
    if warmth:
        lines.append(f"calibrated between {min(warmth):.1f} and {max(warmth):.1f} degrees Celsius")
    return tuple(lines)


def stood_for(stored: Stored) -> tuple[str, ...]:
    """Effects that represent others which the poses of the session cannot separate."""
    return tuple(
        f"{name} of the {triad.name} stands for its class: the poses do not tell it from "
        f"{' or '.join(others)}"
        for triad in stored.triads for name, effect in triad.section.effects.items()
        if (others := [one_line(other) for other in effect.stands_for])
    )


def of_gravity(stored: Stored) -> tuple[str, ...]:
    """A note where the session's logs hold gravity in place of the specific force."""
    return ("The accelerometer of these logs reads -1 g along the axis that points up: change the "
            "sign of its readings before they are corrected.",) * any(
        name.startswith(MINUS) for row in stored.contents.columns for name in row)


def temperatures(stored: Stored) -> list[float]:
    """Temperatures of all poses that have one, degrees Celsius."""
    return [
        warmth
        for triad in stored.triads
        for pose in triad.section.poses
        if (warmth := pose.columns.get(TEMPERATURE)) is not None
    ]


def gains(triad: StoredTriad) -> FloatArray:
    """Factors for nominal readings, about 1, no unit, shape (3,)."""
    return np.asarray(triad.units_per_count / triad.correction.spec.nominal_scale)
