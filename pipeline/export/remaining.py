"""How large an error remains in readings that a format corrects only in part.

Evaluated over the conditions of the session: the corrected vectors of its poses; of the specific
force gravity along every face, edge and corner; of time and of every logged column the values of
the poses.
"""

import math
from collections.abc import Iterable

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.effects.effect import Effect
from calib.fit.rows.sensitive_axes import Axes, sensor_columns
from calib.poses.attitudes import natural_directions
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray
from pipeline.results.read import Stored, StoredTriad

#: Effects whose conditions a results.json does not hold: what they add cannot be evaluated.
UNKNOWN = ("previous", "vibration")


def remaining_error(
    stored: Stored, triad: StoredTriad, lost: Iterable[str]
) -> float | None:
    """The largest error by effects that are not corrected, over the conditions of the session.

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
               if effect.name in names and effect.belongs_to != "bench"]
    if any(name in effect.needs for effect in effects for name in UNKNOWN):
        return None
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
    poses = [pose for pose in stored.contents[triad.name]["poses"]
             if None not in pose["corrected"]]
    vectors = np.array([pose["corrected"] for pose in poses], float).reshape(-1, 3)
    names = {name for pose in poses for name in pose["columns"]}
    columns = {name: _numbers(pose["columns"].get(name) for pose in poses) for name in names}
    start = float(stored.contents["session_start_s"] or 0.0)
    time_s = _numbers(pose["time_s"] for pose in poses) - start
    whole = Conditions.of_vectors(vectors, columns, time_s=time_s)
    if not any("force" in effect.needs for effect in effects):
        return whole
    accelerometer = stored.contents["accelerometer"]
    gravity = (STANDARD_GRAVITY_M_S2 if accelerometer is None
               else accelerometer["gravity"]["value_m_s2"])
    units = natural_directions()
    rows = np.repeat(np.arange(len(whole)), len(units))
    repeated = whole.take(rows)
    force = np.tile(gravity * units, (len(whole), 1))
    return Conditions.of_vectors(repeated.vector, repeated.columns, time_s=repeated.time_s,
                                 force=force)


def _numbers(values: Iterable[float | None]) -> FloatArray:
    return np.array([math.nan if value is None else value for value in values], float)
