"""Validity of a calibration for the log to which it is applied.

`run` knows the poses of a calibration; a later log may be of another sensor, in other units,
hotter, or beyond the range. Impossible logs are refused; excesses are reported with figures.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from calib.effects.effect import Effect
from calib.errors import UnusableLog
from calib.poses.conditions import Conditions
from calib.poses.data_sheet import LARGEST_DRIFT
from calib.poses.imu_log import AXES, SI_UNIT, TEMPERATURE, FloatArray, ImuLog, Triad
from calib.poses.rests.rest_candidates import WINDOW_S
from calib.poses.samples.batches import SHORTEST_SAMPLES
from pipeline.export.apply import Applied, apply_results, saturated_samples
from pipeline.results.read import Stored, StoredTriad

QUIETEST = 0.25
"""Share of the windows that count as rest, of which the median is used: a vehicle that never stands
still is quiet while it moves evenly, and there the force is gravity too."""


LARGEST_DIFFERENCE = 0.3
"""Share of gravity: differences of gains between parts of one type, and offsets, are a tenth of it.
"""

MARGIN = 0.1  #: share of the calibration's span by which telemetry may exceed it without a warning
ROUNDING = 1e-9  #: relative error of the mean of equal numbers; numerical


def require_counts(stored: Stored, log: ImuLog) -> None:
    """Refuse readings outside the range of the calibrated converter.

    Raises
    ------
    UnusableLog
    """
    for triad in stored.triads:
        spec = triad.correction.spec
        if not log.has(triad.name) or not spec.bits:
            continue
        readings = spec.signed(log.readings(triad.name))
        low, high = spec.count_range
        if readings.min() < low or readings.max() > high:
            raise UnusableLog(
                f"{log.label}: {triad.name} readings run from {readings.min():g} to "
                f"{readings.max():g}, but {stored.path} is valid for {spec.bits} bit "
                f"{spec.encoding} counts, {low:g} to {high:g}. Use a raw log of the calibrated "
                f"sensor, in the range and encoding of the session."
            )


def compare_with_gravity(stored: Stored, log: ImuLog, applied: Applied) -> tuple[str, ...]:
    """Compare the corrected specific force at rest with gravity.

    Returns
    -------
    tuple of str
        A warning where they differ by more than drift and age explain, or where no rest is seen.

    Raises
    ------
    UnusableLog
        They have nothing to do with each other.
    """
    if "accelerometer" not in applied.triads:
        return ()
    gravity = stored.gravity_m_s2
    rest = _magnitude_at_rest(log.time_s, applied.triads["accelerometer"], gravity)
    if rest is None:
        return (f"{log.label}: no part of the log shows the sensor at rest, so its corrected "
                f"specific force was not compared with gravity.",)
    difference = abs(rest - gravity) / gravity
    at_rest = f"{log.label}: at rest the corrected specific force is {rest:.4g} m/s²"
    if not difference <= LARGEST_DIFFERENCE:
        raise UnusableLog(
            f"{at_rest}, where gravity is {gravity:.4g} m/s². The readings seem to be those of "
            f"another sensor, in another range, unit or encoding, or corrected already. Use a raw "
            f"log of the sensor of {stored.path}; if the log was never at rest, add "
            f"--anyway."
        )
    if difference > LARGEST_DRIFT:  # worth a look
        return (f"{at_rest}, {100 * difference:.2g} % off gravity ({gravity:.5g} m/s²). Is it the "
                f"sensor of the session, and was it ever at rest in this log?",)
    return ()


def _magnitude_at_rest(time_s: FloatArray, force: FloatArray, gravity: float) -> float | None:
    """Median magnitude of the mean force in the quietest windows; None where none is a rest.

    A mean is shorter than its parts, by half the square of their relative scatter: in a rest this
    is no drift.
    """
    step_s = float(np.median(np.diff(time_s)))
    length = min(max(SHORTEST_SAMPLES, round(WINDOW_S / step_s)), len(force))
    count = len(force) // length
    windows = force[: count * length].reshape(count, length, 3)
    scatter = windows.var(axis=1).sum(axis=1)
    quietest = np.argsort(scatter)[: max(1, round(QUIETEST * count))]
    magnitudes = np.linalg.norm(windows[quietest].mean(axis=1), axis=1)
    moved = scatter[quietest] / 2 > LARGEST_DRIFT * np.maximum(magnitudes, gravity) ** 2
    return None if moved.all() else float(np.median(magnitudes[~moved]))


def warnings_of(stored: Stored, log: ImuLog, session_clock: bool) -> Iterator[str]:
    """Warnings of parts of this log beyond the range of the calibration, a paragraph each.

    Raises
    ------
    UnusableLog, Undetermined
        By the correction of the log, as :func:`pipeline.export.apply.apply_results`.
    """
    for triad in stored.triads:
        if not log.has(triad.name):
            continue
        readings = triad.correction.spec.signed(log.readings(triad.name))
        if triad.correction.spec.bits and (readings != np.rint(readings)).any():
            yield (f"{log.label}: the {triad.name} has readings with decimals, where counts are "
                   f"whole numbers. If they are in physical units, the result is wrong.")
        stuck = np.ptp(readings, axis=0) == 0
        if len(readings) >= SHORTEST_SAMPLES and stuck.any():
            yield (f"{log.label}: {triad.name} {AXES[int(np.argmax(stuck))]} is stuck, or its "
                   f"noise is less than a count: it gives the same value in every sample.")
        yield from _reading_warnings(triad, stored, log)
    yield from _column_warnings(stored, log, session_clock)
    saturated = saturated_samples(stored, log)
    if saturated.any():
        first = float(log.time_s[np.argmax(saturated)])
        yield (f"{log.label}: {saturated.sum()} of {len(saturated)} samples are saturated, the "
               f"first at {first:.6g} s; the true values are unknown there. The column "
               f"`saturated` marks them with 1.")


def _seen(stored: Stored, triad: Triad, name: str) -> FloatArray:
    """The values of a column in the poses of a triad."""
    poses = stored.contents.triads[triad].poses
    values = [pose.time_s if name == "time_s" else pose.columns.get(name) for pose in poses]
    return np.array([value for value in values if value is not None], float)


def _column_warnings(stored: Stored, log: ImuLog, session_clock: bool) -> Iterator[str]:
    """Warnings of columns, and the session's clock, outside the range of the poses."""
    columns: Mapping[str, FloatArray] = (
        {**log.columns, "time_s": log.time_s - (stored.contents.session_start_s or 0.0)}
        if session_clock else log.columns)
    for name, values in columns.items():
        reasons = {one.name: _depending(one, name) for one in stored.triads
                   if log.has(one.name)}
        named = [f"{effect} of the {triad}" for triad, effects in reasons.items()
                 for effect in effects]
        if not named and name != TEMPERATURE:
            continue
        triads = [triad for triad, effects in reasons.items() if effects or not named]
        seen = np.concatenate([_seen(stored, triad, name) for triad in triads] or [np.zeros(0)])
        finite = values[np.isfinite(values)]
        if not seen.size or not finite.size:
            continue
        low, high = float(seen.min()), float(seen.max())
        margin = MARGIN * (high - low) + ROUNDING * max(abs(low), abs(high))
        outside = np.count_nonzero((finite < low) | (finite > high))
        if finite.min() < low - margin or finite.max() > high + margin:
            yield (f"{log.label}: {name} runs from {finite.min():.4g} to {finite.max():.4g}, the "
                   f"poses of the calibration from {low:.4g} to {high:.4g}; {outside} of "
                   f"{len(values)} samples are outside. "
                   + _consequence(stored, log, name, (low, high), named))


def _depending(triad: StoredTriad, name: str) -> list[str]:
    effects = triad.correction.model.acting_on("sensor")
    return [effect.name for effect in effects if effect.told_by in ("sample", "clock")
            and (name in effect.logged or (name == "time_s" and effect.told_by == "clock"))]


def _consequence(
    stored: Stored, log: ImuLog, name: str, bounds: tuple[float, float], named: list[str]
) -> str:
    if not named:
        return "The effect of these values on the readings is unknown and not corrected."
    if name not in log.columns:
        return f"There {' and '.join(named)} is extrapolated."
    inside = replace(log, columns={**log.columns, name: np.clip(log.columns[name], *bounds)})
    full, clipped = (apply_results(stored, one).triads for one in (log, inside))
    parts = [f"{np.abs(full[triad] - clipped[triad]).max():.2g} {SI_UNIT[triad]} of the {triad}"
             for triad in full if not np.array_equal(full[triad], clipped[triad])]
    return (f"There {' and '.join(named)} is extrapolated; this changes the result by up to "
            f"{' and '.join(parts) or '0'}.")


def _reading_warnings(triad: StoredTriad, stored: Stored, log: ImuLog) -> Iterator[str]:
    """Warnings of readings beyond those of the poses, where the model is not linear in them."""
    curved = [effect.name for effect in triad.correction.model.acting_on("sensor")
              if _is_curved(effect, triad.correction.shapes.get(effect.name))]
    if not curved:
        return
    seen = np.array([pose.reading for pose in triad.section.poses], float)
    largest_seen = float(np.nanmax(np.linalg.norm(seen, axis=1)))
    nominal = triad.correction.spec.nominal(log.readings(triad.name))
    largest = float(np.linalg.norm(nominal, axis=1).max())
    if largest > (1 + MARGIN) * largest_seen:
        unit = SI_UNIT[triad.name]
        yield (f"{log.label}: the {triad.name} reads up to {largest:.4g} {unit}, in the poses of "
               f"the calibration up to {largest_seen:.4g} {unit}. Beyond that "
               f"{' and '.join(curved)} is extrapolated.")


def _is_curved(effect: Effect, shape: float | None) -> bool:
    """Whether the effect is neither constant nor proportional to the vector it acts on."""
    vector = np.array([[1.0, -2.0, 3.0], [-3.0, 1.0, 2.0]])
    once, twice = (effect.evaluate(Conditions.of_vectors(v), shape) for v in (vector, 2 * vector))
    known = np.isfinite(once) & np.isfinite(twice)
    return not (np.allclose(once[known], twice[known])
                or np.allclose(2 * once[known], twice[known]))
