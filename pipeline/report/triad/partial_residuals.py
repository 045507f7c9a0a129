"""Partial residuals: the error of every axis against the quantity that drives an effect.

The residual of a magnitude changes its sign with the attitude of the pose, so that an error of one
axis looks like noise in it. With θ and the whitened residual r of the exact fit with the effect,
h_a the whitened change of every row per unit error of sensitive axis a, and E the errors of the
axes per unit of each parameter,

    error of axis a in pose p      Σ h r / Σ h² + θ_j E_aj,    sd  1 / sqrt(Σ h²)

the sums over the rows of the pose (Cook & Weisberg, Residuals and Influence in Regression, 1982,
2.3). An effect proportional to the reading of its axis is shown as a change of scale; an effect on
the reference as a relative error of the reference, pose by pose;
:mod:`pipeline.report.triad.drivers` gives the abscissa.
"""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from calib.effects.effect import Effect
from calib.effects.variation import about_mean
from calib.errors import Undetermined
from calib.fit.least_squares.result import Fit
from calib.fit.rows.sensitive_axes import ALIGNED
from calib.fit.validation.leave_one_out import compare
from calib.numbers import NO_LENGTH
from calib.poses.conditions import FIELDS, Conditions
from calib.poses.imu_log import AXES, FloatArray, IntArray
from pipeline.report.triad.drivers import Dependence, Driver, dependence
from pipeline.text.formatting import DISPLAY

Rows = tuple[FloatArray, FloatArray]
PPM = 1e6  #: parts in one, by definition
GRID = 60  #: points of a drawn curve
POOREST = 2.5  #: times the best sd of an axis: poses of a larger sd are not shown
FEWEST = 4  #: poses of a panel: fewer show no shape
REFERENCE = "reference"  #: in the place of an axis
NEVER = 1e-12  #: relative: columns of an axis below this are rounding


@dataclass(frozen=True, eq=False)
class Panel:
    """One axis, or the reference, against the driver of the effect, in display units.

    ``against`` and ``per`` are name and unit of the driver. ``x``, ``before``, ``after``, ``sd``
    (m,), ``pose`` (m,) their poses; ``curve`` (2, g) the part that the effect explains; ``slope``
    and ``slope_sd`` per unit of the driver, NaN where the curve bends. ``ticks`` are the names of
    the runs where x is the number of the pose.
    """

    axis: str
    parameter: str
    against: str
    per: str
    unit: str
    x: FloatArray
    before: FloatArray
    after: FloatArray
    sd: FloatArray
    pose: IntArray
    curve: FloatArray
    slope: float
    slope_sd: float
    ticks: tuple[tuple[float, str], ...] = ()

    @property
    def significance(self) -> float:
        """Span of the part that the effect explains, in sds of a dot."""
        return float(np.ptp(self.curve[1]) / np.median(self.sd))


@dataclass(frozen=True, eq=False)
class _Parameter:
    """Parameter j on axis a: its columns in the poses, its value and sd, SI."""

    effect: Effect
    shape: float | None
    at: Conditions
    a: int
    j: int
    theta: float
    theta_sd: float

    @property
    def name(self) -> str:
        return self.effect.parameters[self.j]

    @property
    def words(self) -> str:
        """Its column in words."""
        words = self.effect.follows_words or self.effect.page.formula.rpartition("= ")[2]
        return words.replace("{axis}", AXES[self.a]).replace("{parameter}", self.name)

    def column(self, at: Conditions) -> FloatArray:
        """Error of the axis per unit of the parameter, SI (n,)."""
        return np.asarray(self.effect.evaluate(at, self.shape)[:, self.a, self.j])


def panels(fit: Fit, effect: Effect, sd: FloatArray | None = None) -> tuple[Panel, ...]:
    """A panel for every parameter of ``effect``; none where these poses do not determine it.

    Parameters
    ----------
    fit : Fit
        With ``effect`` in its model, and with the other effects that are missing too.
    effect : Effect
        Acting on the sensor or on the reference.
    sd : array, shape (k,), optional
        Sds of its parameters as they are quoted elsewhere, SI; else those of the fit.
    """
    where = fit.model.slices()[effect.name]
    if effect.acts_on == "reading" or not fit.determined[where].all():
        return ()
    if effect.acts_on == "reference":
        return tuple(_reference_panels(fit, effect))
    equations, s = fit.equations, fit.rows.vector
    value, theta = fit.shapes.get(effect.name), fit.theta[where]
    theta_sd = np.sqrt(np.diag(fit.cov)[where])
    if sd is not None and len(sd) == len(theta_sd):
        theta_sd = sd
    axes = ALIGNED if effect.orthogonal else fit.rows.axes
    turn, at = axes.to_orthogonal, equations.conditions(s)
    at = replace(at, vector=axes.sensed(at.vector))
    errors = about_mean(effect, fit.model.names, at).evaluate(at, value)
    after = fit.rows.residual[: equations.data_count]
    sensitivity = equations.whitened(np.tile(turn, (len(s), 1, 1)), s)
    try:
        depends = dependence(fit.poses.triad, effect, value, at)
    except Undetermined:  # a user's function fails at conditions that these poses do not have
        depends = None
    shown = []
    for j in range(len(effect.parameters)):
        strength = np.sqrt((errors[:, :, j] ** 2).mean(axis=0))
        if not strength.max() > NEVER:
            continue
        a = int(strength.argmax())
        parameter = _Parameter(effect, value, at, a, j, float(theta[j]), float(theta_sd[j]))
        rows = _error_per_pose(fit, sensitivity[:, a], after)
        shown.append(_panel(fit, parameter, depends, rows))
    return tuple(panel for panel in shown if panel is not None)


def _panel(
    fit: Fit, of: _Parameter, depends: Dependence | None, rows: Rows
) -> Panel | None:
    """The panel of a parameter: against the condition that drives it, else its own column."""
    with suppress(Undetermined):  # a user's function fails at conditions that no pose has
        driver, is_scale = depends.driver_of(of.a, of.j) if depends else (None, False)
        return _drawn_panel(fit, of, driver, is_scale, rows)
    return _drawn_panel(fit, of, None, False, rows)


def _drawn_panel(
    fit: Fit, of: _Parameter, driver: Driver | None, is_scale: bool, rows: Rows
) -> Panel | None:
    at = of.at
    per = at.vector[:, of.a] if is_scale else np.ones(len(at))
    unit, factor = ("ppm", PPM) if is_scale else DISPLAY[fit.poses.triad]
    with np.errstate(divide="ignore", invalid="ignore"):
        share, sd = rows[0] / per, rows[1] / np.abs(per)
    x = of.column(at) if driver is None else driver.of(at)
    # Poses with a small sd of the axis; no panel if these are too few, or x does not vary in them.
    kept = np.flatnonzero(np.isfinite(sd) & (sd <= POOREST * np.min(sd, initial=np.inf)))
    if len(kept) < FEWEST or np.ptp(x[kept]) == 0:
        return None

    def explained(values: FloatArray) -> FloatArray:
        """Effect of one unit of the parameter at ``values`` of the driver, SI or relative."""
        if driver is None:
            return values
        first: dict[str, Any] = {key: np.repeat(getattr(at, key)[kept[:1]], len(values), axis=0)
                                 for key in ("vector", *FIELDS)}
        same = Conditions(**first, columns={key: np.repeat(column[kept[:1]], len(values))
                                            for key, column in at.columns.items()})
        error = of.column(driver.changed(same, values))
        return np.asarray(error / same.vector[:, of.a] if is_scale else error)

    grid = np.linspace(x[kept].min(), x[kept].max(), 2 if driver is None else GRID)
    mean = float(explained(x[kept]).mean())
    curve = explained(grid) - mean
    bend = np.abs(np.diff(curve, 2)).max(initial=0.0)
    is_straight = bend <= 1e-6 * max(np.abs(curve).max(), NO_LENGTH)
    label, per_unit, size = (of.words, "", 1.0) if driver is None else (
        driver.label, driver.unit, driver.factor)
    change = (curve[-1] - curve[0]) / (grid[-1] - grid[0])
    slope = factor * change / size if is_straight else np.nan
    after = share[kept] * factor
    return Panel(
        AXES[of.a], of.name, label, per_unit, unit, x[kept] * size,
        after + of.theta * factor * (explained(x[kept]) - mean), after, sd[kept] * factor, kept,
        np.stack([grid * size, of.theta * factor * curve]),
        of.theta * slope, of.theta_sd * abs(slope),
    )


def _error_per_pose(fit: Fit, h: FloatArray, after: FloatArray) -> Rows:
    """Remaining error of one axis in every pose, and its sd, SI (n,); infinite where unseen."""
    pose, n = fit.equations.row_pose, len(fit.poses)
    weight = np.bincount(pose, h**2, n)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.bincount(pose, h * after, n) / weight, 1 / np.sqrt(weight)


def _reference_panels(fit: Fit, effect: Effect) -> Iterator[Panel]:
    """The relative error of the reference in every pose, in the order of the runs."""
    magnitude, n = fit.poses.reference.magnitude, len(fit.poses)
    turning = np.flatnonzero(~fit.poses.reference.is_null)
    if len(turning) < FEWEST:
        return
    at = fit.equations.conditions(fit.rows.vector)
    columns = effect.evaluate(at, fit.shapes.get(effect.name))
    theta = fit.theta[fit.model.slices()[effect.name]]
    poses = compare(fit).poses
    error, sd = (np.array([getattr(pose, name) for pose in poses]) for name in ("residual", "sd"))
    relative = PPM / magnitude[turning]
    position = np.arange(n, dtype=float)[turning]
    for j, name in enumerate(effect.parameters):
        explained = columns[turning, j] * relative
        remains = error[turning] * relative
        yield Panel(
            REFERENCE, name, "pose", "", "ppm", position, remains + theta[j] * explained, remains,
            sd[turning] * relative, turning, np.stack([position, theta[j] * explained]),
            np.nan, np.nan, tuple(_run_ticks(fit, turning)),
        )


def _run_ticks(fit: Fit, turning: IntArray) -> Iterator[tuple[float, str]]:
    """The middle of every run, and its name."""
    runs = np.array(fit.poses.run)[turning]
    for run in dict.fromkeys(runs):
        yield float(turning[runs == run].mean()), str(run)
