"""A log corrected by a calibration: counts in, SI units out, in vehicle axes if measured.

An effect that needs a column that the log does not contain is refused by name. What no log tells
(:attr:`calib.effects.effect.Effect.told_by`) counts as after the session, and is stated. Effects of
the bench (the plate's rate, the lever arm to its axis, the Earth's rotation) are not errors of the
sensor and are not part of the correction.

If the results contain a mounting R (vehicle to sensor, Promrit et al.), both triads are rotated by
``Rᵀ``. R refers to the frame of the accelerometer; the vectors of the gyroscope are first rotated
into that frame if the calibration session determined the angles between the two frames.
"""

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from calib.effects.effect import Effect
from calib.effects.needs import lacking
from calib.errors import Undetermined, UnusableLog
from calib.fit.triad.correction import Correction
from calib.poses.conditions import OTHER_TRIAD, Conditions
from calib.poses.data_sheet import LARGEST_SI
from calib.poses.imu_log import BoolArray, FloatArray, ImuLog
from calib.poses.past import past_columns
from calib.poses.triad_kind import PerKind
from pipeline.logs.write import LARGEST, csv_rows
from pipeline.results.read import Stored
from pipeline.text.plain import cell
from pipeline.text.untold import untold_notes

BLOCK = 20_000  #: rows corrected at a time

#: Names and decimals of the corrected columns: micrometres per second², 0.01 °/h.
OUTPUT: Mapping[str, tuple[tuple[str, ...], int]] = PerKind(lambda kind: (
    tuple(f"{column}_{kind.sheet_units[0]}" for column in kind.columns),
    8 if kind.name == "gyroscope" else 6))
SATURATED = "saturated"  #: 1 in samples with an axis at the end of its range, else 0
MOST_DECIMALS = 6  #: decimals of time and of further columns


@dataclass(frozen=True, eq=False)
class Applied:
    """A corrected log.

    ``triads`` contains the corrected vectors (t, 3) by triad; ``axes`` names their axes;
    ``saturated`` (t,) marks samples with an axis at the end of its range, None where no range is
    known; ``left_out`` lists effects of the model that were not corrected, or not in
    every sample, and why.
    """

    time_s: FloatArray
    triads: Mapping[str, FloatArray]
    columns: Mapping[str, FloatArray]
    axes: str
    saturated: BoolArray | None
    left_out: tuple[str, ...]


def apply_results(stored: Stored, log: ImuLog, session_clock: bool = False) -> Applied:
    """Correct every triad that is both in the log and in the results.

    Parameters
    ----------
    stored : Stored
        A results.json.
    log : ImuLog
        Raw readings of the same sensor.
    session_clock : bool
        The log's ``time_s`` counts on the clock of the calibration session, so that drifts can be
        corrected.

    Raises
    ------
    Undetermined
        No triad is in both, or an effect needs what the log does not hold.
    UnusableLog
        A further column holds numbers that cannot be written out again.
    """
    _require_writable(log)
    corrected: dict[str, FloatArray] = {}
    left_out: list[str] = []
    clock = log.time_s - float(stored.contents.session_start_s or 0.0)
    known: dict[str, FloatArray] = {}
    for triad in stored.triads:
        if not log.has(triad.name):
            left_out.append(f"{log.label} has no {triad.name}; the {triad.name} is not "
                            f"corrected.")
            continue
        left_out += [
            f"{triad.name}: {effect.name} is an effect of the bench, not an error of the sensor."
            for effect in triad.correction.model.effects
            if effect.told_by == "bench"
        ]
        left_out += _unknown_pasts(log.label, triad.name, triad.correction.model.effects)
        left_out += untold_notes(triad.name, triad.correction.model.effects,
                                 triad.section.error_parts.untold, session_clock)
        correction = triad.correction.sensor_part()
        nominal = correction.spec.nominal(log.readings(triad.name))
        pasts = [past for effect in correction.model.effects for past in effect.pasts]
        columns = {**_other_triad(stored, triad.name, log), **log.columns,
                   **past_columns(log.columns, log.time_s, pasts)}
        at = Conditions.of_vectors(nominal, columns, **known).as_in_a_log(
            clock if session_clock else triad.end_s)
        _require_evaluable(log.label, triad.name, correction, at)
        # Block by block, which keeps the effects' columns small and in the processor's cache.
        corrected[triad.name] = np.concatenate([
            correction.correct(at.take(slice(start, start + BLOCK)))
            for start in range(0, len(nominal), BLOCK)])
        _require_numbers(log.label, triad.name, corrected[triad.name])
        if triad.name == "accelerometer":
            known["force"] = corrected[triad.name]
    if not corrected:
        there = " and ".join(triad.name for triad in stored.triads) or "no triad"
        raise Undetermined(
            f"{log.label}: {stored.path} calibrates {there}, and the log has no such columns. "
            f"Use a log of the same sensor with the columns acc_x, acc_y, acc_z or gyr_x, gyr_y, "
            f"gyr_z."
        )
    axes, turned = _vehicle_axes(stored, corrected)
    of_output = {SATURATED, *(name for titles, _ in OUTPUT.values() for name in titles)}
    columns_kept = {name: values for name, values in log.columns.items()
                    if name not in of_output}
    left_out += [f"the column {name} of the log is not copied: the output has one of this name."
                 for name in log.columns if name in of_output]
    has_range = any(np.isfinite(triad.range_counts).any()
                    for triad in stored.triads if log.has(triad.name))
    saturated = saturated_samples(stored, log) if has_range else None
    return Applied(log.time_s, turned, columns_kept, axes, saturated, tuple(left_out))


def _unknown_pasts(label: str, triad: str, effects: Sequence[Effect]) -> Iterator[str]:
    """What a log does not show of effects with a memory: their state at its first sample."""
    for effect in effects:
        if effect.pasts:
            yield (f"{triad}: {effect.name} follows the past of {' and '.join(effect.logged)}, "
                   f"which {label} does not hold before its first sample; there it counts as in "
                   f"balance. If it changed before, the first part of the output is wrong: begin "
                   f"the log in balance, or longer before than the memory lasts.")


def _other_triad(stored: Stored, triad: str, log: ImuLog) -> dict[str, FloatArray]:
    """The nominal reading of the other triad than ``triad``, where it was logged."""
    for one in stored.triads:
        if one.name != triad and log.has(one.name):
            nominal = one.correction.spec.nominal(log.readings(one.name))
            return dict(zip(OTHER_TRIAD, nominal.T, strict=True))
    return {}


def _vehicle_axes(
    stored: Stored, corrected: Mapping[str, FloatArray]
) -> tuple[str, Mapping[str, FloatArray]]:
    """Name of the axes of the output, and the vectors in them: the vehicle's where R is known."""
    to_sensor = stored.mounting_rotation
    if to_sensor is None:
        return "the axes of the sensor (the results contain no installation)", corrected
    angles = stored.gyroscope_to_accelerometer_rad
    turned = {}
    for triad, vectors in corrected.items():
        in_sensor = vectors
        if triad == "gyroscope" and angles is not None:
            in_sensor = Rotation.from_rotvec(angles).apply(vectors)
        turned[triad] = np.asarray(in_sensor @ to_sensor)  # row by row Rᵀ v
    axes = "the axes of the vehicle, rotated by the installation of these results"
    if "gyroscope" in turned and angles is None:
        axes += "; the angles between gyroscope and accelerometer were not measured and count as 0"
    return axes, turned


def saturated_samples(stored: Stored, log: ImuLog) -> BoolArray:
    """Samples (t,) in which an axis of a calibrated triad is at the end of its range."""
    saturated = np.zeros(len(log.time_s), bool)
    for triad in stored.triads:
        if log.has(triad.name):
            low, high = triad.range_counts
            readings = triad.correction.spec.signed(log.readings(triad.name))
            saturated |= ((readings <= low) | (readings >= high)).any(axis=1)
    return saturated


def _require_writable(log: ImuLog) -> None:
    for name, values in log.columns.items():
        largest = float(np.nanmax(np.abs(values), initial=0.0))
        if not largest < LARGEST:
            raise UnusableLog(
                f"{log.label}: column {name} contains {largest:g}; expected are numbers below "
                f"{LARGEST:.0e}. Delete this column or the wrong rows from the log."
            )


def _require_numbers(label: str, triad: str, vectors: FloatArray) -> None:
    """Refuse results that no sensor has: the readings are from another sensor."""
    wrong = ~(np.abs(vectors) < LARGEST_SI).all(axis=1)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise UnusableLog(
            f"{label}: sample {row + 1} of the {triad} becomes {vectors[row]} SI units, which no "
            f"sensor reads. Is the log in the counts or the unit of the calibration session?"
        )


def _require_evaluable(label: str, triad: str, correction: Correction, at: Conditions) -> None:
    """Refuse an effect that some row of the log cannot evaluate, with the reason."""
    for effect in correction.model.acting_on("sensor"):
        if not np.isfinite(effect.evaluate(at, correction.shapes.get(effect.name))).all():
            raise Undetermined(
                f"{label}: the calibration of the {triad} contains {effect.name}, which cannot be "
                f"corrected in this log: {_reason(effect, at)}"
            )


def _reason(effect: Effect, at: Conditions) -> str:
    needs, columns = lacking(effect, at)
    if "force" in needs:
        return ("it depends on the specific force. Log the accelerometer too, and calibrate it in "
                "the same session.")
    if columns:
        values = at.column(columns[0])
        if not np.isfinite(values).any():
            return f"the log has no column {columns[0]}. Log it, or calibrate without it."
        row = int(np.flatnonzero(~np.isfinite(values))[0])
        return (
            f"the column {columns[0]} has no number at sample {row + 1}. Delete the rows in which "
            f"it is empty, or calibrate without it."
        )
    return "its formula gives no number there. Calibrate without it."


def applied_csv(applied: Applied) -> bytes:
    """The corrected log as CSV, units in the header, further columns as they were."""
    names, columns = ["time_s"], [applied.time_s]
    decimals = [_fewest_decimals(applied.time_s)]
    for triad, vectors in applied.triads.items():
        titles, digits = OUTPUT[triad]
        names += titles
        columns += list(vectors.T)
        decimals += [digits] * 3
    names += list(applied.columns)
    columns += list(applied.columns.values())
    decimals += [_fewest_decimals(values) for values in applied.columns.values()]
    if applied.saturated is not None:
        names.append(SATURATED)
        columns.append(applied.saturated.astype(float))
        decimals.append(0)
    header = io.StringIO()
    csv.writer(header, lineterminator="\n").writerow([cell(name) for name in names])
    return b"".join([header.getvalue().encode(), *csv_rows(columns, decimals)])


def _fewest_decimals(values: FloatArray) -> int:
    """Number of decimals that show all logged digits, six at most."""
    logged = np.abs(values[np.isfinite(values)])
    largest = float(logged.max(initial=0.0))
    for decimals in range(MOST_DECIMALS):
        scaled = logged * 10.0**decimals
        shown = np.allclose(scaled, np.rint(scaled), rtol=1e-15, atol=1e-9)
        if shown or largest * 10.0 ** (decimals + 1) >= LARGEST:
            return decimals
    return MOST_DECIMALS
