"""The calibration of one triad as an object with methods to query, extend and show it."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from calib.assess import AssessedTriad, assess
from calib.consistency.data_sheet import gain_off_the_sheet
from calib.diagnosis.diagnose import Diagnosis
from calib.effects.effect import Effect
from calib.effects.needs import unavailable
from calib.errors import CalibrationError, Undetermined, UnusableLog
from calib.fit.model import Model
from calib.notebook import display
from calib.notebook.tables import SI, columns_of
from calib.poses.averaging.pose_mean import TIME, triad_columns
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.pose_set import PoseSet
from calib.spelling import nearest_name

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

IN_SI: Mapping[str, Any] = {"spec": SI}  #: options of a table in m/s² or rad/s


@dataclass(frozen=True, eq=False, repr=False)
class Calibration:
    """The calibration of one triad; a change returns a new one.

    Parameters
    ----------
    poses : PoseSet
        The fitted poses.
    model : tuple of (str or Effect)
        The effects of the model.
    assessed : AssessedTriad
        Fit, comparison with the poses, diagnosis, prediction.
    candidates : tuple of Effect
        Effects of one's own that the diagnosis considers beside the catalogue's.
    options : mapping of str to object
        Further arguments of :func:`calib.assess.assess`, the data sheet of the readings included.
    """

    poses: PoseSet
    model: tuple[str | Effect, ...]
    assessed: AssessedTriad
    candidates: tuple[Effect, ...]
    options: Mapping[str, Any]

    @property
    def triad(self) -> Triad:
        """``accelerometer`` or ``gyroscope``."""
        return self.poses.triad

    def diagnose(self) -> Diagnosis:
        """The effects that the model lacks: verdict, names, odds, advice, ranking."""
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
        return calibrated(self.poses, (*self.model, *effects), self.candidates, self.options)

    def remove(self, *names: str) -> "Calibration":
        """The calibration without these effects.

        Raises
        ------
        CalibrationError
            One of them is not in the model.
        """
        listed = [display.name_of(one) for one in self.model]
        if absent := set(names) - set(listed):
            wrong = min(absent)
            raise CalibrationError(f"'{wrong}' is not in the model{nearest_name(wrong, listed)}")
        kept = tuple(one for one in self.model if display.name_of(one) not in names)
        return calibrated(self.poses, kept, self.candidates, self.options)

    def correct(self, table: Any) -> FloatArray:
        """Correct a table of readings.

        Parameters
        ----------
        table : DataFrame, mapping of name to sequence, structured array, or array of shape (n, 3)
            Readings in the unit of those of the calibration, as logged, with the columns that its
            effects follow.

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
        vector = self.assessed.calibration.spec.nominal(
            np.column_stack([columns.pop(name) for name in triad_columns(self.triad)]))
        known = {TIME: columns.pop(TIME)} if TIME in columns else {}
        return self.assessed.calibration.correct(Conditions.of_vectors(vector, columns, **known))

    def to_pandas(self) -> "DataFrame":
        """Every parameter with its sd and unit, one row each."""
        from pandas import DataFrame

        names, units, values, sds = zip(*display.parameters_of(self.assessed), strict=True)
        return DataFrame({"value": values, "sd": sds, "unit": units}, index=list(names))

    def poses_to_pandas(self) -> "DataFrame":
        """Every pose: residual, its sd, leave-one-out residual, reference, logged columns."""
        from pandas import DataFrame

        poses, one = self.assessed.calibration.fit.poses, self.assessed.comparison.poses
        return DataFrame({
            "run": poses.run, "reference": poses.reference.magnitude,
            **{key: [getattr(pose, key) for pose in one] for key in ("residual", "sd", "left_out")},
            **poses.columns}, index=list(poses.label))

    def plot(self, effect: str | Effect | None = None) -> "Figure":
        """Residual and leave-one-out residual of every pose with the noise band.

        With an ``effect`` that is not in the model: what it would explain in addition.
        """
        if effect is None:
            return display.figure(self.assessed)
        return display.partial_figure(self.assessed, self._known(effect))

    def correlations(self) -> "DataFrame":
        """Correlations of the parameters of the linear form, effects by their names."""
        from pandas import DataFrame

        fit = self.assessed.calibration.fit
        names = [f"{effect.name} {label}".strip() for effect in fit.model.effects
                 for label in effect.parameters or ("",)]
        sd = np.sqrt(np.diag(fit.cov))
        return DataFrame(fit.cov / np.outer(sd, sd), index=names, columns=names)

    def _known(self, effect: str | Effect) -> Effect:
        """The effect, if these poses can evaluate it and it is not in the model."""
        defined = {one.name: one for one in self.candidates}
        known = effect if isinstance(effect, Effect) else Model.of([effect], defined).effects[0]
        if known.name in self.assessed.calibration.fit.model.names:
            raise CalibrationError(f"{known.name} is in the model already; remove it first, as in "
                                   f"remove({known.name!r}).plot({known.name!r}).")
        require_usable(known, self.assessed.calibration.fit.poses)
        return known

    def __repr__(self) -> str:
        return display.text(self.assessed)

    def _repr_html_(self) -> str:
        return display.html(self.assessed)


def calibrated(
    poses: PoseSet, effects: tuple[str | Effect, ...], candidates: Sequence[Effect] = (),
    options: Mapping[str, Any] = IN_SI,
) -> Calibration:
    """The calibration of one sensor by the effects of a model; arguments as :class:`Calibration`.

    Raises
    ------
    CalibrationError
        An effect is unknown or not for this triad, the poses do not determine the model or
        contradict each other, or the fit does not converge.
    """
    require_effects(effects)
    defined = {one.name: one for one in (*candidates, *effects) if isinstance(one, Effect)}
    model = Model.of([display.name_of(one) for one in effects], defined)
    for effect in model.effects:
        require_usable(effect, poses)
    assessed = assess(poses, model, candidates=tuple(defined.values()), **options)
    of_sheet = assessed.calibration.parameters, assessed.calibration.spec
    for doubt in gain_off_the_sheet(*of_sheet, poses.triad):
        warnings.warn(doubt, stacklevel=3)
    return Calibration(poses, effects, assessed, tuple(defined.values()), options)


def require_effects(model: Any) -> None:
    """Refuse a model that is not a list of effects and names.

    Raises
    ------
    CalibrationError
        Naming the entry.
    """
    if isinstance(model, str) or not isinstance(model, Sequence) or not model or not all(
            isinstance(one, (str, Effect)) for one in model):
        raise CalibrationError(f"model={model!r}: a list of effects or their names is expected, as "
                               f"in model=['bias', 'scale', 'misalignment'].")


def require_usable(effect: Effect, poses: PoseSet) -> None:
    """Refuse an effect that does not act on the triad of ``poses``, or that they cannot evaluate.

    Raises
    ------
    CalibrationError
        Naming the triad that it acts on, or the columns that the poses have.
    """
    if poses.triad not in effect.triads:
        others = " and the ".join(effect.triads)
        raise CalibrationError(f"{effect.name} is an effect of the {others}, and this is a "
                               f"calibration of the {poses.triad}.")
    if (reason := unavailable(effect, poses.conditions(poses.reading))) is not None:
        known = ", ".join(poses.columns) or "none"
        raise Undetermined(f"{effect.name} cannot be evaluated in these poses: {reason}. Their "
                           f"columns are: {known}.")


def parameter_differences(one: Calibration, other: Calibration) -> "DataFrame":
    """Every parameter of two calibrations, and their difference in its sd.

    Parameters
    ----------
    one, other : Calibration
        Of the same triad; their sds count as independent.

    Returns
    -------
    DataFrame
        Columns ``one``, ``other``, ``difference``, ``sd``, ``in_sd`` and ``unit`` by the
        parameter's name; NaN for a parameter that only one of them has.

    Raises
    ------
    UnusableLog
        They are of different triads, or of different data sheets.
    TypeError
        One of them is no calibration.
    """
    from pandas import DataFrame

    for item in (one, other):
        if not isinstance(item, Calibration):
            raise TypeError(f"two calibrations are compared, and one is {item!r}.")
    if one.triad != other.triad:
        raise UnusableLog(f"one calibration is of the {one.triad}, the other of the {other.triad}: "
                          "compare two of the same triad.")
    if one.assessed.calibration.spec != other.assessed.calibration.spec:
        raise UnusableLog("the calibrations are of readings in different units or ranges: a count "
                          "of the one is no count of the other.")
    first, second = (item.to_pandas() for item in (one, other))
    names = first.index.union(second.index, sort=False)
    first, second = first.reindex(names), second.reindex(names)
    difference, sd = second["value"] - first["value"], np.hypot(first["sd"], second["sd"])
    return DataFrame({
        "one": first["value"], "other": second["value"], "difference": difference, "sd": sd,
        "in_sd": difference / sd, "unit": first["unit"].fillna(second["unit"])})
