"""Partial residuals: the error of every axis against the quantity that drives an effect.

The residual of a magnitude changes its sign with the attitude of the pose, so that an error of one
axis looks like noise in it. With y the whitened residual, J the Jacobian of the model, h_a the
whitened change of every row per unit error of sensitive axis a, and C = h_a E_aj the columns of the
effect,

    θ      least squares of y on C, with J projected out of both
    after  residual of the model with the effect
    error of axis a in pose p      Σ h after / Σ h² + θ_j E_aj,    sd  1 / sqrt(Σ h²)

the sums over the rows of the pose (Cook & Weisberg, Residuals and Influence in Regression, 1982,
2.3). What drives E_aj is asked of the effect itself: the one condition whose change changes it. An
effect proportional to the reading of its axis is shown as a change of scale.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import fdtrc

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.effects.effect import Effect
from calib.fit.identifiability import VISIBLE_SHARE
from calib.fit.result import MISFIT_P_VALUE, Fit
from calib.fit.sensitive_axes import ALIGNED
from calib.poses.conditions import Conditions
from calib.poses.imu_log import AXES, FloatArray, IntArray
from pipeline.formatting import DISPLAY, RPM

PPM = 1e6
GRID = 60  #: points of a drawn curve
SHIFT = 0.37  #: of the range of a condition, to see whether an effect depends on it
POOREST = 2.5  #: times the best sd of an axis: poses that say less about it are not shown
FEWEST = 4  #: poses of a panel: fewer show no shape
NOTHING = 1e-9  #: relative change that is rounding


@dataclass(frozen=True, eq=False)
class Driver:
    """A scalar condition of the poses: its label with unit, and display units per unit.

    ``field`` is a logged column or a field of :class:`Conditions`."""

    label: str
    unit: str
    factor: float
    field: str
    part: int | None = None  #: component of a vector

    def of(self, at: Conditions) -> FloatArray:
        """Its value in every pose, (n,)."""
        values = at.columns[self.field] if self.field in at.columns else getattr(at, self.field)
        return np.asarray(values if self.part is None else values[:, self.part])

    def changed(self, at: Conditions, value: FloatArray) -> Conditions:
        """The same conditions with ``value`` (n,) for this one."""
        if self.field in at.columns:
            return replace(at, columns={**at.columns, self.field: value})
        whole: FloatArray = value
        if self.part is not None:
            whole = np.array(getattr(at, self.field))
            whole[:, self.part] = value
        changes: dict[str, Any] = {self.field: whole}
        return replace(at, **changes)


@dataclass(frozen=True, eq=False)
class Panel:
    """One axis against one driver, in display units.

    ``x``, ``before``, ``after``, ``sd`` (m,), ``pose`` (m,) their poses; ``curve`` (2, g) what the
    effect explains; ``slope`` and ``slope_sd`` per unit of the driver, NaN where the curve bends.
    """

    axis: str
    parameter: str
    driver: Driver
    unit: str
    x: FloatArray
    before: FloatArray
    after: FloatArray
    sd: FloatArray
    pose: IntArray
    curve: FloatArray
    slope: float
    slope_sd: float


def drivers(triad: str, at: Conditions) -> Iterator[Driver]:
    """Every scalar condition that these poses know."""
    unit, size = (("g", 1 / STANDARD_GRAVITY_M_S2) if triad == "accelerometer"
                  else ("°/s", DISPLAY[triad][1]))
    felt = "specific force along" if triad == "accelerometer" else "rate about"
    yield Driver("time since the session began", "min", 1 / 60, "time_s")
    yield Driver("rate of the plate", "rpm", 1 / RPM, "spin_rad_s")
    for name in at.columns:
        temperature = name == "temperature_c"
        yield Driver("temperature" if temperature else name, "°C" if temperature else "",
                     1.0, name)
    for k, axis in enumerate(AXES):
        yield Driver(f"{felt} {axis}", unit, size, "vector", k)
        yield Driver(f"{felt} {axis} in the pose before", unit, size, "previous", k)
        yield Driver(f"specific force along {axis}", "g", 1 / STANDARD_GRAVITY_M_S2, "force", k)


def panels(fit: Fit, effect: Effect, shape: float | None = None) -> tuple[Panel, ...]:
    """A panel for every parameter of ``effect`` that acts on one axis and has one driver.

    Parameters
    ----------
    fit : Fit
        With or without ``effect`` in its model.
    effect : Effect
        Acting on the sensor; one that acts on the reference has no axis, and no panel.
    shape : float, optional
        Value of its shape parameter; by default the fitted one, else the first start.
    """
    if effect.acts_on != "sensor":
        return ()
    equations, s = fit.equations, fit.rows.vector
    axes = ALIGNED if effect.orthogonal else fit.rows.axes
    turn = axes.to_orthogonal  # T, from the sensitive axes
    at = equations.conditions(s)
    at = replace(at, vector=axes.sensed(at.vector))
    value = fit.shapes.get(effect.name, shape)
    errors = effect.evaluate(at, value)
    solved = _solved(fit, effect, equations.whitened(turn @ errors, s))
    if solved is None:
        return ()
    theta, theta_sd, after = solved
    sensitivity = equations.whitened(np.tile(turn, (len(s), 1, 1)), s)
    shown = []
    for j, name in enumerate(effect.parameters):
        acting = np.flatnonzero(np.abs(errors[:, :, j]).max(axis=0) > 0)
        if len(acting) != 1:
            continue
        a = int(acting[0])
        driven = _driver(fit.poses.triad, effect, value, at, a, j)
        if driven is None:
            continue
        driver, is_scale = driven
        rows = _per_pose(fit, sensitivity[:, a], after)
        shown.append(_panel(fit, effect, value, at, (a, j, name), driver, is_scale, rows,
                            (theta[j], theta_sd[j])))
    return tuple(panel for panel in shown if panel is not None)


def _solved(
    fit: Fit, effect: Effect, columns: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """θ, its sd, and the residual with the effect; None where these poses do not determine it.

    The sd has the Birge ratio in it where noise does not explain the residual with the effect.
    """
    d = fit.equations.data_count
    if effect.name in fit.model.names:
        where = fit.model.slices()[effect.name]
        return fit.theta[where], np.sqrt(np.diag(fit.cov)[where]), fit.rows.residual[:d]
    root = np.sqrt(fit.weight)
    norm = np.sqrt((columns**2).sum(axis=0))
    if not (np.isfinite(norm).all() and (norm > 0).all()):
        return None
    full = np.vstack([columns / norm, np.zeros((len(root) - d, columns.shape[1]))])
    jacobian = fit.rows.jacobian * root[:, None]
    length = np.sqrt((jacobian**2).sum(axis=0))
    q, r = np.linalg.qr(jacobian / np.where(length > 0, length, 1.0))
    q = q[:, np.abs(np.diag(r)) > NOTHING]
    rest = full * root[:, None]
    rest = rest - q @ (q.T @ rest)
    u, size, vt = np.linalg.svd(rest, full_matrices=False)
    if size[-1] < VISIBLE_SHARE:
        return None
    y = fit.rows.residual * root
    theta = vt.T @ ((u.T @ y) / size)
    sd = np.sqrt(((vt.T / size) ** 2).sum(axis=1))
    remainder = y - rest @ theta
    dof = max(fit.dof - len(theta), 1)
    ratio = float(remainder @ remainder) / dof
    if fdtrc(dof, fit.poses.noise_dof, ratio) < MISFIT_P_VALUE:
        sd = sd * np.sqrt(ratio)
    return theta / norm, sd / norm, remainder[:d] / np.maximum(root[:d], NOTHING)


def _per_pose(
    fit: Fit, h: FloatArray, after: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Error of one axis that is left in every pose, and its sd, SI (n,); infinite where unseen."""
    pose, n = fit.equations.row_pose, len(fit.poses)
    weight = np.bincount(pose, h**2, n)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.bincount(pose, h * after, n) / weight, 1 / np.sqrt(weight)


def _driver(
    triad: str, effect: Effect, shape: float | None, at: Conditions, a: int, j: int
) -> tuple[Driver, bool] | None:
    """The one condition that drives parameter j, and whether it acts on the scale of axis a."""
    value = effect.evaluate(at, shape)[:, a, j]
    size = float(np.abs(value).max())
    known = [each for each in drivers(triad, at) if np.isfinite(each.of(at)).all()]
    moving = []
    for each in known:
        now = each.of(at)
        reach = np.ptp(now) or np.abs(now).max() or 1.0
        with np.errstate(all="ignore"):  # a time before the session can be out of an effect's range
            others = [effect.evaluate(each.changed(at, changed), shape)[:, a, j] - value
                      for changed in (now + SHIFT * reach, -now)]
        if not np.abs(others).max() <= NOTHING * size:
            moving.append(each)
    if len(moving) == 1:
        return moving[0], False
    scale = next((each for each in moving if (each.field, each.part) == ("vector", a)), None)
    if len(moving) != 2 or scale is None:
        return None
    twice = effect.evaluate(scale.changed(at, 2 * scale.of(at)), shape)[:, a, j]
    if np.abs(twice - 2 * value).max() > NOTHING * size:
        return None
    return next(each for each in moving if each is not scale), True


def _panel(
    fit: Fit, effect: Effect, shape: float | None, at: Conditions, which: tuple[int, int, str],
    driver: Driver, is_scale: bool, rows: tuple[FloatArray, FloatArray],
    size: tuple[float, float],
) -> Panel | None:
    """One panel; None where too few poses know the axis, or the driver does not vary in them."""
    a, j, name = which
    unit, factor = DISPLAY[fit.poses.triad]
    error, sd = rows
    per = at.vector[:, a] if is_scale else np.ones(len(sd))
    unit, factor = ("ppm", PPM) if is_scale else (unit, factor)
    with np.errstate(divide="ignore", invalid="ignore"):
        share, sd = error / per, sd / np.abs(per)
    x = driver.of(at)
    best = float(np.min(sd, initial=np.inf))
    kept = np.flatnonzero(np.isfinite(sd) & (sd <= POOREST * best))
    if len(kept) < FEWEST or np.ptp(x[kept]) == 0:
        return None

    def explained(values: FloatArray) -> FloatArray:
        """What one unit of the parameter does at ``values`` of the driver, SI or relative."""
        first: dict[str, Any] = {key: np.repeat(getattr(at, key)[kept[:1]], len(values), axis=0)
                 for key in ("vector", "magnitude", "force", "spin_rad_s", "time_s", "previous",
                             "vibration")}
        same = Conditions(**first, columns={key: np.repeat(column[kept[:1]], len(values))
                                            for key, column in at.columns.items()})
        unit_error = effect.evaluate(driver.changed(same, values), shape)[:, a, j]
        return np.asarray(unit_error / same.vector[:, a] if is_scale else unit_error)

    grid = np.linspace(x[kept].min(), x[kept].max(), GRID)
    mean = float(explained(x[kept]).mean())
    curve = explained(grid) - mean
    change = curve[-1] - curve[0]
    straight = np.abs(np.diff(curve, 2)).max() <= 1e-6 * max(np.abs(curve).max(), 1e-300)
    slope = factor * change / ((grid[-1] - grid[0]) * driver.factor) if straight else np.nan
    after = share[kept] * factor
    return Panel(
        AXES[a], name, driver, unit, x[kept] * driver.factor,
        after + size[0] * factor * (explained(x[kept]) - mean), after, sd[kept] * factor, kept,
        np.stack([grid * driver.factor, size[0] * factor * curve]),
        size[0] * slope, size[1] * abs(slope),
    )
