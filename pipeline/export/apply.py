"""A log corrected by a calibration: counts in, SI units out.

What a log cannot tell is refused by name rather than left out: an effect that follows a column
the log lacks, or the time since the session began. Effects of the bench (the plate's rate, the
lever to its axis, the Earth's rotation) are no errors of the sensor and stay out of the correction.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from calib.effects.effect import Effect
from calib.errors import Undetermined, UnusableLog
from calib.fit.model import Correction, Model, pick
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray, ImuLog
from pipeline.logs.write import LARGEST, csv_rows
from pipeline.results.read import Stored, StoredTriad

#: Effects of the bench, which a log taken elsewhere does not have.
OF_THE_BENCH = ("lever_arm", "earth_rate")
#: Effects that follow the time since the calibration session began.
OF_THE_SESSION = ("bias_drift", "scale_drift", "warm_up")
BLOCK = 20_000  #: rows corrected at a time

#: Name and decimals of the corrected columns: micrometres per second², 0.01 °/h.
OUTPUT = {
    "accelerometer": (("acc_x_m_s2", "acc_y_m_s2", "acc_z_m_s2"), 6),
    "gyroscope": (("gyr_x_rad_s", "gyr_y_rad_s", "gyr_z_rad_s"), 8),
}
MOST_DECIMALS = 6  #: of time and of further columns


@dataclass(frozen=True, eq=False)
class Applied:
    """A corrected log.

    ``triads`` holds the corrected vectors (t, 3) by triad; ``left_out`` says which of the model's
    effects had nothing to correct, and why.
    """

    time_s: FloatArray
    triads: Mapping[str, FloatArray]
    columns: Mapping[str, FloatArray]
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
    n = len(log.time_s)
    absent, absent_vector = np.broadcast_to(np.nan, n), np.broadcast_to(np.nan, (n, 3))
    force = absent_vector
    origin_s = float(stored.found["session_start_s"] or 0.0)
    for each in stored.triads:
        if not log.has(each.triad):
            left_out.append(f"{log.label} has no {each.triad}; nothing to correct there.")
            continue
        left_out += [
            f"{each.triad}: {effect.name} belongs to the bench and is no error of the sensor."
            for effect in each.correction.model.effects
            if effect.name in OF_THE_BENCH or effect.acts_on == "reference"
        ]
        correction = _of_the_sensor(each)
        counts = getattr(log, each.triad)
        at = Conditions(
            vector=correction.spec.nominal(counts),
            magnitude=absent,
            force=force,
            spin_rad_s=absent,
            time_s=log.time_s - origin_s if session_clock else absent,
            previous=absent_vector,
            vibration=absent_vector,
            columns=log.columns,
        )
        _require_columns(log.label, each.triad, correction, at)
        corrected[each.triad] = _correct(correction, at)
        if each.triad == "accelerometer":
            force = corrected[each.triad]
    if not corrected:
        there = " and ".join(each.triad for each in stored.triads) or "no triad"
        raise Undetermined(
            f"{log.label}: {stored.path} calibrates {there}, and the log holds no such columns. "
            f"Name a log of the same sensor, with the columns acc_x, acc_y, acc_z or gyr_x, gyr_y, "
            f"gyr_z."
        )
    return Applied(log.time_s, corrected, log.columns, tuple(left_out))


def _require_writable(log: ImuLog) -> None:
    for name, values in log.columns.items():
        largest = float(np.nanmax(np.abs(values), initial=0.0))
        if not largest < LARGEST:
            raise UnusableLog(
                f"{log.label}: column {name} holds {largest:g}, numbers below {LARGEST:.0e} are "
                f"expected. Delete the column from the log, or the rows in which it is wrong."
            )


def _of_the_sensor(stored: StoredTriad) -> Correction:
    """The correction without the effects of the bench."""
    correction = stored.correction
    effects = tuple(
        effect
        for effect in correction.model.effects
        if effect.acts_on != "reference" and effect.name not in OF_THE_BENCH
    )
    theta = correction.theta[pick(correction.model, effects)]
    return replace(correction, model=Model(effects), theta=theta)


def _require_columns(label: str, triad: str, correction: Correction, at: Conditions) -> None:
    first = _rows(at, slice(0, 1))
    for effect in correction.model.effects:
        if not np.isfinite(effect.evaluate(first)).all():
            raise Undetermined(
                f"{label}: the calibration of the {triad} contains {effect.name}, which cannot be "
                f"corrected in this log: {_lacking(effect)}"
            )


def _lacking(effect: Effect) -> str:
    if effect.name in OF_THE_SESSION:
        return (
            "it follows the time since the calibration session began. If the log's time_s counts "
            "on that clock, add --session-clock; else calibrate without it."
        )
    if effect.name.startswith("column:"):
        column = effect.name.removeprefix("column:")
        return f"there is no column {column}. Log it, or calibrate without it."
    if effect.name.startswith("temperature_"):
        return "there is no column temperature_c. Log it, or calibrate without it."
    if effect.name.startswith("g_"):
        return (
            "it follows the specific force. Log the accelerometer as well, and calibrate it in "
            "the same results."
        )
    return "it is known for whole poses only, not for samples. Calibrate without it."


def _correct(correction: Correction, at: Conditions) -> FloatArray:
    """Block by block, which keeps the effects' columns small and in the processor's cache."""
    n = len(at.vector)
    blocks = [slice(start, start + BLOCK) for start in range(0, n, BLOCK)]
    return np.concatenate([correction.correct(_rows(at, block)) for block in blocks])


def _rows(at: Conditions, rows: slice) -> Conditions:
    return Conditions(
        vector=at.vector[rows],
        magnitude=at.magnitude[rows],
        force=at.force[rows],
        spin_rad_s=at.spin_rad_s[rows],
        time_s=at.time_s[rows],
        previous=at.previous[rows],
        vibration=at.vibration[rows],
        columns={name: values[rows] for name, values in at.columns.items()},
    )


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
    return b"".join([",".join(names).encode() + b"\n", *csv_rows(columns, decimals)])


def _fewest_decimals(values: FloatArray) -> int:
    """How many decimals show all that was logged, within what a sixth decimal can."""
    logged = np.abs(values[np.isfinite(values)])
    largest = float(logged.max(initial=0.0))
    for decimals in range(MOST_DECIMALS):
        scaled = logged * 10.0**decimals
        shown = np.allclose(scaled, np.rint(scaled), rtol=1e-15, atol=1e-9)
        if shown or largest * 10.0 ** (decimals + 1) >= LARGEST:
            return decimals
    return MOST_DECIMALS
