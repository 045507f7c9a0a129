"""What could be missing, part two: what no model can hold by a name.

Unknown functions of a logged column, time, the plate's rate, the attitude or the pose before; a
curve in a column and a bias that lags the temperature; a bias that steps or wanders; bad poses;
a plate whose rate scatters from pose to pose.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations_with_replacement

import numpy as np
from scipy.linalg import eigh
from scipy.stats import rankdata

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import Course, Hypothesis, bends
from calib.effects.catalogue import further_step
from calib.effects.effect import EFFECTS, Effect, Page, per_axis
from calib.effects.steps import STEP_MARGIN
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.widened import times_apart
from calib.poses.checks.pose_checks import LARGEST_RATE_CHANGE
from calib.poses.conditions import Conditions
from calib.poses.imu_log import AXES, TEMPERATURE, BoolArray, FloatArray

TIME_WAVES, COLUMN_WAVES = 8, 5
"""Half cosines over the range. A judgement: of 24 development sessions of
``tests.bench.diagnosis_thresholds --first 31000 --trials 24`` half as many of either change 2
verdicts, twice as many in time none, in a column 2; 19 of 24 effects are named, with 10 in a column
20, and none is wrong."""

STEPS_TRIED = 32  #: times of a step that are tried; a limit of time
DAMPING = 0.8
"""Exponent of the number of waves: amplitudes of nature fall with the frequency. A judgement."""

FROM_RUN_TO_RUN = "from run to run"  #: how the rate of the plate scatters between settings
CURVED = "temperature_bias_curve"  #: the listed curve
IN_A_CURVE = "in a curve"  #: how a bias follows a column by its square
LAGS_S = (30.0, 45.0, 70.0, 100.0, 150.0, 220.0, 330.0, 500.0, 750.0, 1100.0, 1700.0, 2500.0,
          3800.0, 5600.0)
"""How far the temperature within may lag that of the log, half a minute to an hour and a half.
Derived: the log with neighbouring lags agrees to 0.99 and more. Half as many over the same range
change 1 of 55 verdicts, twice as many none (``tests.bench.diagnosis_thresholds``)."""
WANDER_MODES = 10
"""The strongest of a course, a limit of size. Of 26 poses they hold 68, 88 and 93 % of the variance
at the three spans below; half as many 44, 75 and 86 %, twice as many 92, 97 and 98 %."""
WANDER_SPANS = (0.05, 0.2, 0.8)
"""Correlation times of a wandering bias over the length of the session. Derived: from what moves
from pose to pose to what is a drift, four times apart."""

#: axes whose components are multiplied
CUBIC = np.array([*combinations_with_replacement(range(3), 3)]).T
#: axes of which the squares of the components are multiplied
QUARTIC = np.array([*combinations_with_replacement(range(3), 2)]).T

NO_PAGE = Page(formula="", typical={}, source="", confounded="", separates="")
MEMORY = 0.3
"""Share of the magnitude by which the pose before saturates what an axis remembers. A
judgement: the first start of the width of ``hysteresis``."""


def waves(covariate: FloatArray, count: int) -> FloatArray:
    """Smooth functions of a covariate, (n, count), no unit: cosines of its rank, damped.

    Equal values have equal ranks, and the sign of the covariate changes signs of functions only.
    """
    rank, k = (rankdata(covariate) - 0.5) / len(covariate), np.arange(1, count + 1)
    return np.asarray(np.cos(np.pi * rank[:, None] * k) * np.exp(-k / (DAMPING * count)))


def lagging(time_s: FloatArray, values: FloatArray, lags_s: Sequence[float]) -> FloatArray:
    """``values`` (n,) with first-order lags, settled at the first pose, (n, lags), any unit."""
    order = np.argsort(time_s, kind="stable")
    t, v, lag = time_s[order], values[order], np.array(lags_s)
    step = np.maximum(np.diff(t), 1e-9)
    slope = np.diff(v) / step
    keep, behind = np.exp(-step[:, None] / lag), slope[:, None] * lag
    out = np.empty((len(v), len(lag)))
    out[order[0]] = off = v[0]
    for i in range(1, len(v)):
        # ``off`` is what it was at the pose before.
        off = v[i] - behind[i - 1] + keep[i - 1] * (off - v[i - 1] + behind[i - 1])
        out[order[i]] = off
    return out


def unknown_hypotheses(fit: Fit, columns: tuple[str, ...]) -> list[Hypothesis]:
    """Unknown functions: of ``columns``, time, the plate's rate, the attitude, the pose before."""
    forms = [(name, form) for name, form in _forms(fit, columns) if form]
    names = [name for name, _ in forms]
    each = np.log(CONSTANTS.odds_unknown / max(len(set(names)), 1))
    return [
        Hypothesis(f"~{name}", "unknown", float(each - np.log(names.count(name) * len(form))),
                   course=course, detail=detail, follows=name)
        for name, form in forms
        for detail, course in form
    ]


Form = Sequence[tuple[str, Course]]
"""One way to follow a covariate, in words and as a course; with a lag at every lag."""


def _forms(fit: Fit, columns: tuple[str, ...]) -> Iterator[tuple[str, Form]]:
    """What unknown functions are functions of, and how."""
    poses = fit.poses
    covariates = {"time_s": poses.time_s, "spin_rad_s": poses.spin_rad_s}
    covariates |= {name: poses.columns[name] for name in columns}
    for name, values in covariates.items():
        if not np.isfinite(values).all() or np.ptp(values) == 0:
            continue
        shapes = waves(values, TIME_WAVES if name == "time_s" else COLUMN_WAVES)
        yield name, [("", Course.of_size(shapes))]
        yield name, [("", Course.of_bias(shapes))]
        if name in columns and not (name == TEMPERATURE and bends(poses, EFFECTS[CURVED])):
            curve = ((values - values.mean()) / np.ptp(values)) ** 2
            yield name, [(IN_A_CURVE, Course.of_bias(curve[:, None]))]
    yield "attitude", [("", Course.of_size(_attitude(fit)))]
    if np.isfinite(poses.time_s).all():
        if TEMPERATURE in columns and np.ptp(poses.columns[TEMPERATURE]) > 0:
            yield TEMPERATURE, _with_a_lag(poses.time_s, poses.columns[TEMPERATURE])
        previous = _previous(fit)
        if previous.any():
            yield "previous", [("", Course(previous))]


def _with_a_lag(time_s: FloatArray, warmth: FloatArray) -> Form:
    """A bias that follows ``warmth`` (n,) late."""
    late = lagging(time_s, warmth, LAGS_S)
    return [
        (f"with a lag of about {lag_s:.0f} s",
         Course.of_bias((each - each.mean())[:, None]))
        for lag_s, each in zip(LAGS_S, late.T, strict=True) if np.ptp(each) > 0
    ]


def _attitude(fit: Fit) -> FloatArray:
    """Cubic and quartic functions of the direction: the first that the nine parameters lack.

    Shape (n, 16).
    """
    s = fit.rows.vector
    n = s / np.linalg.norm(s, axis=1, keepdims=True)
    cubic = n[:, CUBIC[0]] * n[:, CUBIC[1]] * n[:, CUBIC[2]]
    return np.concatenate([cubic, (n[:, QUARTIC[0]] * n[:, QUARTIC[1]]) ** 2], axis=1)


def _previous(fit: Fit) -> FloatArray:
    """What an axis may remember of the pose before: its value, saturated or squared, (n, 3, 3)."""
    previous = fit.equations.at_start.previous
    largest = float(np.abs(previous).max()) if np.isfinite(previous).all() else 0.0
    if largest == 0.0:
        return np.zeros((len(previous), 0, 3))
    share = previous / largest
    return np.stack([share, np.tanh(share / MEMORY), share**2], axis=1)


def _internal(name: str, marks: FloatArray) -> Effect:
    """A bias of its own where ``marks`` (n,) is one; it lives no longer than the diagnosis."""

    def columns(at: Conditions) -> FloatArray:
        return per_axis(np.tile(marks[:, None], 3))

    return Effect(name, AXES, "{u}", columns, "", NO_PAGE, orthogonal=True)


def step_hypotheses(fit: Fit) -> list[Hypothesis]:
    """A bias that steps once, for every time between two poses, or ``STEPS_TRIED`` of them."""
    poses = fit.poses
    last = len(poses) - STEP_MARGIN
    if not np.isfinite(poses.time_s).all() or last <= STEP_MARGIN:
        return []
    order = np.argsort(poses.time_s, kind="stable")
    tried = np.unique(np.linspace(STEP_MARGIN, last, STEPS_TRIED).astype(int))
    prior = float(np.log(CONSTANTS.odds_rare / len(tried)))
    name, hypotheses = further_step(fit.model.names), []
    for k in tried:
        after = np.zeros(len(poses))
        after[order[k:]] = 1.0
        time_s = 0.5 * float(poses.time_s[order[k - 1]] + poses.time_s[order[k]])
        hypotheses.append(
            Hypothesis(name, "jump", prior, _internal(name, after),
                       course=Course.of_bias(after[:, None]),
                       detail=f"{time_s:.1f} s")
        )
    return hypotheses


def bad_pose_hypotheses(fit: Fit) -> list[Hypothesis]:
    """Every pose as one that has nothing to do with the others."""
    poses = fit.poses
    prior = float(np.log(CONSTANTS.odds_rare / len(poses)))
    return [
        Hypothesis("bad_pose", "bad_pose", prior, _internal("bad_pose", mark),
                   course=Course.of_bias(mark[:, None]), detail=label)
        for label, mark in zip(poses.label, np.eye(len(poses)), strict=True)
    ]


def wander_hypotheses(fit: Fit) -> list[Hypothesis]:
    """A bias that wanders: an Ornstein-Uhlenbeck process, by its strongest modes.

    Where the runs have no common clock, each wanders on its own.
    """
    apart_s = times_apart(fit.poses)
    length_s = float(apart_s[np.isfinite(apart_s)].max(initial=0.0))
    if length_s == 0 or "bias_wander" in fit.model.names:
        return []
    prior = float(np.log(CONSTANTS.odds_wander / len(WANDER_SPANS)))
    kernel = np.exp(-apart_s / length_s)
    courses = 1 if np.isfinite(apart_s).all() else len(set(fit.poses.run))
    strongest = (max(len(kernel) - courses * WANDER_MODES, 0), len(kernel) - 1)
    hypotheses = []
    for span in WANDER_SPANS:
        tau_s = span * length_s
        values, modes = eigh(kernel ** (1 / span), subset_by_index=strongest)
        strong = modes * np.sqrt(np.maximum(values, 0.0))
        hypotheses.append(
            Hypothesis("bias_wander", "wander", prior, course=Course.of_bias(strong),
                       detail=f"correlated over about {tau_s:.0f} s")
        )
    return hypotheses


def plate_hypotheses(fit: Fit) -> list[Hypothesis]:
    """A plate whose rate scatters: from run to run, and from pose to pose beside poses at rest.

    One that would scatter by more than a plate may change within a pose does not turn steadily, and
    is none to calibrate with: a rate of its own for every pose would hide any error of the sensor.
    """
    poses, turning = fit.poses, ~fit.poses.reference.is_null
    if poses.triad != "gyroscope" or not turning.any() or "rate_scatter" in fit.model.names:
        return []
    if _scatter_needed(fit) > LARGEST_RATE_CHANGE:
        return []
    size = np.where(turning, 1.0, 0.0)
    marks = [(FROM_RUN_TO_RUN, _by_run(poses.run, turning))]
    if fit.poses.reference.is_null.any():
        marks.append(("from pose to pose", np.diag(size)[:, turning]))
    prior = float(np.log(CONSTANTS.odds_rare / len(marks)))
    return [
        Hypothesis("rate_scatter", "plate_rate", prior, course=Course.of_size(shapes),
                   detail=detail)
        for detail, shapes in marks
        if shapes.shape[1] > 0
    ]


def _scatter_needed(fit: Fit) -> float:
    """Scatter of the plate's rate that would explain the turning poses, relative, rms."""
    equations = fit.equations
    n = equations.magnitude
    off = fit.rows.residual[: len(n)] * equations.magnitude_sd
    return float(np.sqrt(np.mean((off / fit.poses.reference.magnitude[n]) ** 2)))


def _by_run(runs: tuple[str, ...], turning: BoolArray) -> FloatArray:
    """One column for each run on the turning plate, (n, runs)."""
    names = dict.fromkeys(run for run, is_turning in zip(runs, turning, strict=True) if is_turning)
    return np.array([[float(run == name) for name in names] for run in runs])
