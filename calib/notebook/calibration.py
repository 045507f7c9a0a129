"""``calibrate(table)``: the calibration of one triad as an object to ask, extend and show."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any

import numpy as np

from calib.assess import AssessedTriad, assess
from calib.diagnosis.diagnose import Diagnosis
from calib.effects.catalogue import BASE, UnknownEffect
from calib.effects.effect import EFFECTS, Effect
from calib.effects.needs import unavailable
from calib.errors import CalibrationError, Undetermined, UnusableLog
from calib.fit.model import Model
from calib.fit.triad.evaluable import correct_other_poses
from calib.notebook import display
from calib.notebook.partial import partial_figure
from calib.notebook.tables import SI, TIME, columns_of, gravity_runs, plate_runs, triad_columns
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.pose_set import PoseSet, pose_set

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


@dataclass(frozen=True, eq=False, repr=False)
class Calibration:
    """The calibration of one triad; what changes it returns another one.

    Parameters
    ----------
    poses : PoseSet
        What it was fitted to.
    model : tuple of (str or Effect)
        The effects of the model.
    assessed : AssessedTriad
        Fit, comparison with the poses, diagnosis, prediction.
    """

    poses: PoseSet
    model: tuple[str | Effect, ...]
    assessed: AssessedTriad

    @property
    def triad(self) -> Triad:
        """``accelerometer`` or ``gyroscope``."""
        return self.poses.triad

    def diagnose(self) -> Diagnosis:
        """What the model is missing: verdict, names, odds, advice, ranking."""
        return self.assessed.diagnosis

    def add(self, *effects: str | Effect) -> "Calibration":
        """The calibration with further effects, by name or as an :class:`Effect` of one's own.

        Raises
        ------
        CalibrationError
            An effect is unknown, or acts on the other triad only.
        Undetermined
            The poses lack a column that it needs, or do not determine it.
        """
        return _calibrated(self.poses, (*self.model, *effects))

    def remove(self, *names: str) -> "Calibration":
        """The calibration without these effects."""
        return _calibrated(self.poses, tuple(
            each for each in self.model if display.name_of(each) not in names))

    def correct(self, table: Any) -> FloatArray:
        """Correct a table of readings.

        Parameters
        ----------
        table : DataFrame, mapping of name to sequence, structured array, or array of shape (n, 3)
            Readings as those of the calibration, with the columns that its effects follow.

        Returns
        -------
        array, shape (n, 3)
            m/s² or rad/s.

        Raises
        ------
        UnusableLog
            A column of the triad is missing, a column is no numbers, or lengths differ.
        FitFailed
            The effects are larger than the readings.
        """
        columns, _ = columns_of(table, self.triad)
        vector = np.column_stack([columns.pop(name) for name in triad_columns(self.triad)])
        known = {TIME: columns.pop(TIME)} if TIME in columns else {}
        return self.assessed.calibration.correct(Conditions.of_vectors(vector, columns, **known))

    def to_pandas(self) -> "DataFrame":
        """Every parameter with its sd and unit, one row each."""
        return display.parameter_frame(self.assessed)

    def poses_to_pandas(self) -> "DataFrame":
        """Every pose: residual, its sd, leave-one-out residual, reference, logged columns."""
        return display.pose_frame(self.assessed)

    def plot(self, effect: str | Effect | None = None) -> "Figure":
        """Residual and leave-one-out residual of every pose with the noise band.

        With an ``effect`` that is not in the model: what it would explain beside what is there.
        """
        if effect is None:
            return display.figure(self.assessed)
        return partial_figure(self.assessed, self._known(effect))

    def correlations(self) -> "DataFrame":
        """Correlations of all parameters, by their names."""
        return display.correlation_frame(self.assessed)

    def _known(self, effect: str | Effect) -> Effect:
        """The effect, if it acts on this triad and is not in the model."""
        known = effect if isinstance(effect, Effect) else _model_of([effect], {}).effects[0]
        if known.name in self.assessed.calibration.fit.model.names:
            raise CalibrationError(f"{known.name} is in the model already; remove it first, as in "
                                   f"remove({known.name!r}).plot({known.name!r}).")
        require_for_triad(known, self.triad)
        return known

    def __repr__(self) -> str:
        return display.text(self.assessed)

    def _repr_html_(self) -> str:
        return display.html(self.assessed)


def calibrate(
    table: Any,
    *,
    gravity: float | None = None,
    gravity_sd: float = 0.0,
    rate: float | None = None,
    rate_sd: float = 0.0,
    accelerometer: Calibration | None = None,
    model: Sequence[str | Effect] = BASE,
) -> Calibration:
    """Calibrate an accelerometer against gravity, or a gyroscope against the plate's rate.

    Parameters
    ----------
    table : DataFrame, mapping of columns, structured array, or array of shape (n, 3)
        One row for each pose's mean, or the samples of poses: :mod:`calib.notebook.tables`.
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
    if gravity is not None:
        return _calibrated(_poses("accelerometer", gravity_runs(table, gravity, gravity_sd)),
                           tuple(model))
    is_named = hasattr(table, "keys")
    if rate is None and is_named and set(triad_columns("gyroscope")).isdisjoint(table):
        raise UnusableLog("State `gravity=` in m/s² for an accelerometer, or give a table with "
                          "gyr_x, gyr_y, gyr_z and `rate=` in rad/s for a gyroscope.")
    correct = correct_other_poses(accelerometer.assessed.calibration) if accelerometer else None
    return _calibrated(_poses("gyroscope", plate_runs(table, rate, rate_sd), correct),
                       tuple(model))


def _poses(
    triad: Triad, runs: Any, correct: Callable[[Conditions], FloatArray] | None = None
) -> PoseSet:
    times = np.array([mean.time_s for run in runs for mean in run.means])
    origin = float(np.nanmin(times)) if np.isfinite(times).any() else 0.0
    return pose_set(triad, runs, origin, correct)


def _calibrated(poses: PoseSet, effects: tuple[str | Effect, ...]) -> Calibration:
    defined = {each.name: each for each in effects if isinstance(each, Effect)}
    model = _model_of([display.name_of(each) for each in effects], defined)
    at = poses.conditions(poses.reading)
    for effect in model.effects:
        require_for_triad(effect, poses.triad)
        if (reason := unavailable(effect, at)) is not None:
            known = ", ".join(poses.columns) or "none"
            raise Undetermined(f"{effect.name} cannot be evaluated in these poses: {reason}. Their "
                               f"columns are: {known}.")
    return Calibration(poses, effects, assess(poses, model, SI, candidates=tuple(defined.values())))


def require_for_triad(effect: Effect, triad: Triad) -> None:
    """Refuse an effect that does not act on ``triad``.

    Raises
    ------
    CalibrationError
        Naming the triad that it acts on.
    """
    if triad not in effect.triads:
        others = " and the ".join(effect.triads)
        raise CalibrationError(f"{effect.name} is an effect of the {others}, and this is a "
                               f"calibration of the {triad}.")


def _model_of(names: Sequence[str], defined: dict[str, Effect]) -> Model:
    """The model of these names; the nearest right name where one is wrong."""
    try:
        return Model.of(names, defined)
    except UnknownEffect as error:
        near = get_close_matches(error.name, EFFECTS, 3)
        raise CalibrationError(f"{error}. Did you mean {', '.join(near)}?" if near else
                               f"{error}. There are {', '.join(EFFECTS)}.") from error
