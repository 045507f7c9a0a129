"""``calibrate(table)``: one sensor, or with ``by`` the many sensors of a lot."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from calib.diagnosis.population.pool import Pool
from calib.effects.catalogue import BASE
from calib.effects.effect import Effect
from calib.errors import CalibrationError, UnusableLog
from calib.fit.model import Model
from calib.fit.triad.other_poses import correct_other_poses
from calib.lot import CalibratedBlock, SensorPoses, calibrate_blocks, pool_of_lot
from calib.notebook import display
from calib.notebook.calibration import Calibration, calibrated, require_effects
from calib.notebook.tables import SI, finite, gravity_runs, parts_by, plate_runs
from calib.poses.averaging.pose_mean import triad_columns
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.pose_set import PoseSet, pose_set

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, eq=False, repr=False)
class LotCalibration:
    """Many sensors of one design, fitted side by side; ``lot[sensor]`` is one with its diagnosis.

    Parameters
    ----------
    poses : mapping of str to PoseSet
        By sensor.
    model : tuple of (str or Effect)
    blocks : tuple of CalibratedBlock
        Parameters of every sensor, and why some are refused.
    """

    poses: Mapping[str, PoseSet]
    model: tuple[str | Effect, ...]
    blocks: tuple[CalibratedBlock, ...]

    def __len__(self) -> int:
        return len(self.poses)

    def __getitem__(self, sensor: str) -> Calibration:
        return calibrated(self.poses[sensor], self.model)

    @property
    def refusals(self) -> dict[str, CalibrationError]:
        """Reasons why sensors are not calibrated, by name."""
        return {name: error for block in self.blocks for name, error in block.refusals.items()}

    @cached_property
    def pool(self) -> Pool:
        """The effects that the lot lacks, by the summed evidence of all sensors."""
        return pool_of_lot(lambda: [_named(self.poses)], _model(self.model))

    def to_pandas(self) -> "DataFrame":
        """Parameters, sds and the fit of every sensor by its name, SI."""
        from pandas import DataFrame, concat

        return concat([DataFrame(
            {"poses": block.poses, "chi2": block.chi2, "dof": block.dof, "p_value": block.p_value,
             **block.columns(("misalignment", "bias", "scale"))}, index=list(block.sensors))
            for block in self.blocks])

    def __repr__(self) -> str:
        missing = ", ".join(effect.name for effect in self.pool.effects)
        return (f"{len(self) - len(self.refusals)} of {len(self)} sensors calibrated; the lot is "
                f"missing {missing or 'nothing'}")


@overload
def calibrate(
    table: Any, *, by: None = None, gravity: float | None = None, gravity_sd: float = 0.0,
    rate: float | None = None, rate_sd: float = 0.0, accelerometer: Calibration | None = None,
    model: Sequence[str | Effect] = BASE,
) -> Calibration: ...


@overload
def calibrate(
    table: Any, *, by: str, gravity: float | None = None, gravity_sd: float = 0.0,
    rate: float | None = None, rate_sd: float = 0.0, accelerometer: Calibration | None = None,
    model: Sequence[str | Effect] = BASE,
) -> LotCalibration: ...


def calibrate(
    table: Any,
    *,
    by: str | None = None,
    gravity: float | None = None,
    gravity_sd: float = 0.0,
    rate: float | None = None,
    rate_sd: float = 0.0,
    accelerometer: Calibration | None = None,
    model: Sequence[str | Effect] = BASE,
) -> Calibration | LotCalibration:
    """Calibrate an accelerometer against gravity, or a gyroscope against the plate's rate.

    Parameters
    ----------
    table : DataFrame, mapping of columns, structured array, or array of shape (n, 3)
        One row for each pose's mean, or the samples of poses: :mod:`calib.notebook.tables`.
    by : str, optional
        Column that names the sensor of a row: the table is a lot, and all its sensors are fitted
        side by side.
    gravity, gravity_sd : float
        Local gravity and its sd, m/s²: the table is an accelerometer's.
    rate, rate_sd : float
        Rate of the plate and its sd, rad/s; without ``gravity`` the table is a gyroscope's, and
        its column ``rate_rad_s`` may state a rate for each pose.
    accelerometer : Calibration, optional
        Corrects the specific force that effects on the gyroscope depend on.
    model : sequence of str or Effect

    Returns
    -------
    Calibration
        Of a lot :class:`LotCalibration`, in which a sensor that is refused leaves the others alone.

    Raises
    ------
    UnusableLog
        The table lacks a column, or holds something that is no number.
    Undetermined
        The poses do not determine the model.
    Contradiction
        The readings contradict the reference, or one another.
    FitFailed
        The fit does not converge.
    CalibrationError
        An effect of ``model`` is unknown, or not for this triad.

    Examples
    --------
    >>> import numpy as np
    >>> axes = np.vstack([np.eye(3), -np.eye(3), [[.6, .8, 0], [0, .6, .8], [.8, 0, .6],
    ...                   [-.6, 0, .8], [.8, -.6, 0], [0, .8, -.6]]])
    >>> calibrate(9.807 * axes * 1.01 + 0.05, gravity=9.807).correct([[0.05, 0.05, 9.95507]])
    ... # doctest: +SKIP
    array([[0., 0., 9.807]])
    """
    if gravity is not None and rate is not None:
        raise UnusableLog("State `gravity=` for an accelerometer or `rate=` for a gyroscope, one "
                          "of the two.")
    gravity_sd, rate_sd = finite("gravity_sd", gravity_sd, 0.0), finite("rate_sd", rate_sd, 0.0)
    gravity = None if gravity is None else finite("gravity", gravity)
    rate = None if rate is None else finite("rate", rate)
    require_effects(model)

    def poses_of(part: Any) -> PoseSet:
        return _poses_of(part, gravity, gravity_sd, rate, rate_sd, accelerometer)

    if by is None:
        return calibrated(poses_of(table), tuple(model))
    poses = {sensor: poses_of(part) for sensor, part in parts_by(table, by)}
    blocks = calibrate_blocks(lambda: [_named(poses)], _model(tuple(model)), SI)
    return LotCalibration(poses, tuple(model), tuple(blocks))


def _named(poses: Mapping[str, PoseSet]) -> list[SensorPoses]:
    return [SensorPoses(sensor, one) for sensor, one in poses.items()]


def _poses_of(
    table: Any, gravity: float | None, gravity_sd: float, rate: float | None, rate_sd: float,
    accelerometer: Calibration | None,
) -> PoseSet:
    """The poses of one sensor; the arguments are those of :func:`calibrate`."""
    if gravity is not None:
        return _poses("accelerometer", gravity_runs(table, gravity, gravity_sd))
    is_named = hasattr(table, "keys")
    if rate is None and is_named and set(triad_columns("gyroscope")).isdisjoint(table):
        raise UnusableLog("State `gravity=` in m/s² for an accelerometer, or give a table with "
                          "gyr_x, gyr_y, gyr_z and `rate=` in rad/s for a gyroscope.")
    correct = correct_other_poses(accelerometer.assessed.calibration) if accelerometer else None
    return _poses("gyroscope", plate_runs(table, rate, rate_sd), correct)


def _poses(
    triad: Triad, runs: Any, correct: Callable[[Conditions], FloatArray] | None = None
) -> PoseSet:
    times = np.array([mean.time_s for run in runs for mean in run.means])
    origin = float(np.nanmin(times)) if np.isfinite(times).any() else 0.0
    return pose_set(triad, runs, origin, correct)


def _model(effects: tuple[str | Effect, ...]) -> Model:
    defined = {effect.name: effect for effect in effects if isinstance(effect, Effect)}
    return Model.of([display.name_of(effect) for effect in effects], defined)
