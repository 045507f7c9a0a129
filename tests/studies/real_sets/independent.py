"""An independent fit of the stops of a log: own model, own rows, SciPy's least squares.

    |M (v - b) - e| = g      accelerometer, M upper triangular, e one effect at a time
    w = b + e                gyroscope at rest, the same axis by axis

Every model is judged by stops that took no part in its fit, each in turn, in the closed form
r / (1 - h) at SciPy's solution. Errors are weighted by the inverse variance of the stops, half of
it their own and half that of the log's typical stop, so that no calm stop decides alone.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import OptimizeResult, least_squares

from calib.poses.imu_log import BoolArray, FloatArray
from tests.studies.real_sets.logs import Stops

UPPER = np.triu_indices(3)
LEAST_LEFT = 1e-3
STEP_MARGIN, FEWEST_FOR_STEPS = 2, 8
DIFFERENCE = float(np.finfo(float).eps ** (1 / 3))  # of a central difference, parameters near one
Extra = Callable[[FloatArray, FloatArray], FloatArray]
"""(parameters (..., 1, k), corrected vectors (..., n, 3)) to errors (..., n, 3)."""


@dataclass(frozen=True)
class Judged:
    """One model: how many parameters more than the base, rms within, rms of stops left out, SI."""

    more: int
    rms: float
    left_out: float


def weights_of(sd: FloatArray) -> FloatArray:
    """Sd (n,) of each stop, steadied by the typical one."""
    return np.asarray(np.sqrt(0.5 * sd**2 + 0.5 * np.median(sd) ** 2))


# --- accelerometer -------------------------------------------------------------------------------


def magnitudes(x: FloatArray, readings: FloatArray) -> FloatArray:
    """|M (v - b)|, (..., n), by the nine parameters (..., 9): six of M, three of b."""
    return _corrected(x, readings, None)


def fit_magnitudes(
    stops: Stops, gravity: float, extra: Extra | None = None, count: int = 0
) -> tuple[OptimizeResult, FloatArray]:
    """SciPy's solution for 9 + ``count`` parameters, and the sd (n,) that weighted each stop."""
    sd = weighted(stops)
    start = np.r_[1, 0, 0, 1, 0, 1, 0, 0, 0, np.zeros(count)]
    scale = np.median(np.linalg.norm(stops.force, axis=1)) / gravity
    start[[0, 3, 5]] = 1 / scale

    def residual(x: FloatArray) -> FloatArray:
        return (_corrected(x, stops.force, extra) - gravity) / sd

    def jacobian(x: FloatArray) -> FloatArray:
        step = DIFFERENCE * np.maximum(1.0, np.abs(x))
        ahead, behind = residual(x + np.stack([np.diag(step), -np.diag(step)]))
        return np.asarray(((ahead - behind) / (2 * step[:, None])).T)

    return least_squares(residual, start, jac=jacobian, x_scale="jac", method="lm"), sd


def _corrected(x: FloatArray, readings: FloatArray, extra: Extra | None) -> FloatArray:
    matrix = np.zeros((*x.shape[:-1], 3, 3))
    matrix[(..., *UPPER)] = x[..., :6]
    s = (readings - x[..., None, 6:9]) @ matrix.swapaxes(-1, -2)
    if extra is not None:
        s = s - extra(x[..., None, 9:], s)
    return np.asarray(np.sqrt((s * s).sum(axis=-1)))


def weighted(stops: Stops) -> FloatArray:
    """Sd (n,) of the magnitude of each stop, as every fit here weights it."""
    return weights_of(_along(stops))


def _along(stops: Stops) -> FloatArray:
    """Sd of the magnitude of each stop."""
    up = stops.force / np.linalg.norm(stops.force, axis=1, keepdims=True)
    return np.asarray(np.sqrt(((stops.force_sd * up) ** 2).sum(axis=1)))


def judge_accelerometer(stops: Stops, gravity: float) -> dict[str, Judged]:
    """The base and every single effect, by what each leaves in stops left out of its fit."""
    judged = {}
    for name, (extra, count) in accelerometer_effects(stops).items():
        if len(stops) - 9 - count < 2:
            continue
        solution, sd = fit_magnitudes(stops, gravity, extra, count)
        hat = np.diag(solution.jac @ np.linalg.pinv(solution.jac))
        out = solution.fun / np.maximum(1 - hat, LEAST_LEFT)
        judged[name] = Judged(count, _rms(solution.fun * sd, sd), _rms(out * sd, sd))
    return judged


def _rms(error: FloatArray, sd: FloatArray) -> float:
    return float(np.sqrt(np.average(error**2, weights=sd**-2)))


def accelerometer_effects(stops: Stops) -> Mapping[str, tuple[Extra | None, int]]:
    """Effects of an accelerometer with their numbers of parameters, each in units of its own."""
    late = (stops.time_s - stops.time_s.mean()) / max(float(np.ptp(stops.time_s)), 1e-9)
    g = 9.8
    effects: dict[str, tuple[Extra | None, int]] = {
        "base": (None, 0),
        "quadratic": (lambda p, s: p * s**2 / g, 3),
        "cubic": (lambda p, s: p * s**3 / g**2, 3),
        "asymmetry": (lambda p, s: p * np.abs(s), 3),
        "cross_quadratic": (lambda p, s: _products(s / g) @ _square(p).swapaxes(-1, -2), 9),
        "bias_drift": (lambda p, s: late[:, None] * p, 3),
        "scale_drift": (lambda p, s: late[:, None] * p * s, 3),
    }
    for after in _steps(len(stops)):
        effects[f"bias_step {after}"] = (_step(np.arange(len(stops)) >= after), 3)
    if np.isfinite(stops.temperature).all():
        warm = stops.temperature - stops.temperature.mean()
        effects["temperature_bias"] = (lambda p, s: warm[:, None] * p, 3)
    return effects


def _step(after: BoolArray) -> Extra:
    return lambda p, s: after[:, None] * p


def _products(s: FloatArray) -> FloatArray:
    return s * np.roll(s, -1, axis=-1)


def _square(p: FloatArray) -> FloatArray:
    return p.reshape(*p.shape[:-2], 3, 3)


def _steps(n: int, most: int = 12) -> list[int]:
    """Before which stops a step is tried."""
    tried = np.linspace(STEP_MARGIN, n - STEP_MARGIN, most) if n > FEWEST_FOR_STEPS else ()
    return sorted({int(k) for k in tried})


# --- gyroscope at rest ---------------------------------------------------------------------------


def judge_gyroscope(stops: Stops) -> dict[str, Judged]:
    """A bias, and a bias with each effect, by stops left out; linear, each axis by itself."""
    n = len(stops)
    up = stops.force / np.linalg.norm(stops.force, axis=1, keepdims=True)
    late = (stops.time_s - stops.time_s.mean()) / max(float(np.ptp(stops.time_s)), 1e-9)
    designs = {"base": np.zeros((n, 0)), "g_sensitivity": up, "bias_drift": late[:, None]}
    for k in _steps(n, 40):
        designs[f"bias_step {k}"] = (np.arange(n) >= k).astype(float)[:, None]
    if np.isfinite(stops.temperature).all():
        designs["temperature_bias"] = (stops.temperature - stops.temperature.mean())[:, None]
    judged = {}
    for name, columns in designs.items():
        if n - 1 - columns.shape[1] < 2:
            continue
        errors = [_linear(columns, stops.rate[:, a], weights_of(stops.rate_sd[:, a]))
                  for a in range(3)]
        within, out = (np.concatenate([e[i] for e in errors]) for i in (0, 1))
        sd = np.concatenate([weights_of(stops.rate_sd[:, a]) for a in range(3)])
        judged[name] = Judged(3 * columns.shape[1], _rms(within, sd), _rms(out, sd))
    return judged


def _linear(columns: FloatArray, y: FloatArray, sd: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Residuals of a weighted regression with a constant, within and left out, each (n,)."""
    design = np.column_stack([np.ones(len(y)), columns]) / sd[:, None]
    hat = np.diag(design @ np.linalg.pinv(design))
    solution = np.linalg.lstsq(design, y / sd, rcond=None)[0]
    within = y - design @ solution * sd
    return within, within / np.maximum(1 - hat, 1e-6)


def best_step(judged: Mapping[str, Judged]) -> dict[str, Judged]:
    """The same with the best of the steps alone, under the name ``bias_step``."""
    steps = {name: each for name, each in judged.items() if name.startswith("bias_step")}
    rest = {name: each for name, each in judged.items() if name not in steps}
    if steps:
        rest["bias_step"] = min(steps.values(), key=lambda each: each.left_out)
    return rest
