"""Hypotheses, part three: functions without a name in the catalogue.

Unknown functions of a logged column, time, the plate's rate, the attitude or the pose before; a
curve in a column and a bias that lags the temperature.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations_with_replacement

import numpy as np
from numpy.polynomial.legendre import legvander

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import (
    ANY_FUNCTION,
    ATTITUDE,
    Course,
    Hypothesis,
    bends,
    modes_about_mean,
)
from calib.effects.effect import EFFECTS
from calib.fit.least_squares.result import Fit
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import TEMPERATURE, FloatArray
from calib.poses.past import behind

SMOOTH = 0.3
"""Share of a covariate's range over which a function of it keeps half of its correlation. A
judgement: half a swing fits into it, and steeper functions cost what they take more."""

CURVED = "temperature_bias_curve"  #: the listed curve
AND_READING = "and what the axes sense"  #: how the errors of the axes follow a column besides
IN_A_CURVE = "in a curve"  #: how a bias or a gain follows a column by a line and a square
LAGS_S = (30.0, 45.0, 70.0, 100.0, 150.0, 220.0, 330.0, 500.0, 750.0, 1100.0, 1700.0, 2500.0,
          3800.0, 5600.0)
"""Lags of the internal temperature behind the logged one, half a minute to an hour and a half.
Derived: the log with neighbouring lags agrees to 0.99 and more. Half as many over the same range
change 1 of 55 verdicts, twice as many none (``tests.bench.diagnosis_thresholds``)."""

LIMITS = (0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64)
"""Readings, over the largest, from which an axis responds differently: a dead band, a limit; and
steps from the reading before, a backlash.
Numerical: any other is within a factor of 1.4 of one; poses hardly show smaller ones."""

#: axes whose components are multiplied
CUBIC = np.array([*combinations_with_replacement(range(3), 3)]).T
SQUARED = "g_squared_sensitivity"  #: the listed bias by squares of the specific force
#: axes of which the components, or their squares, are multiplied
PAIRS = np.array([*combinations_with_replacement(range(3), 2)]).T


def smooth_functions(covariate: FloatArray) -> FloatArray:
    """Functions of a covariate (n,) that, weighed equally, make any smooth one, (n, m), no unit.

    They are the modes of a Gaussian process about its mean with Matérn's covariance of order 3/2
    (Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, eq. 4.17).
    """
    apart = np.abs(covariate[:, None] - covariate) / np.ptp(covariate) * np.sqrt(3) / SMOOTH
    return modes_about_mean((1 + apart) * np.exp(-apart))


def line_and_square(covariate: FloatArray) -> FloatArray:
    """The first two Legendre polynomials of a covariate (n,) over its range, (n, 2), no unit.

    A square by itself would be a curve about one zero of the column, and no column has one.
    """
    half = 0.5 * np.ptp(covariate)
    return legvander((covariate - covariate.min()) / half - 1, 2)[:, 1:]


def seen_far_apart(fit: Fit, subject: str) -> bool:
    """Whether a function of ``subject`` may go its own way between two neighbouring values seen."""
    poses = fit.poses
    seen = {ATTITUDE: fit.rows.vector, "time_s": poses.time_s, **poses.columns}.get(subject)
    if seen is None:
        return False
    apart = np.diff(np.sort(seen, axis=0), axis=0).max(axis=0)
    return bool((apart > SMOOTH * np.ptp(seen, axis=0)).any())


def unknown_hypotheses(fit: Fit, columns: tuple[str, ...]) -> list[Hypothesis]:
    """Unknown functions: of ``columns``, time, the plate's rate, the attitude, the pose before."""
    forms = [(name, form) for name, form in _forms(fit, columns) if form]
    names = [name for name, _ in forms]
    each = np.log(CONSTANTS.odds_unknown / max(len(set(names)), 1))
    return [
        Hypothesis(ANY_FUNCTION + name, "unknown",
                   float(each - np.log(names.count(name) * len(form))),
                   course=course, detail=detail, follows=name)
        for name, form in forms
        for detail, course in form
    ]


Form = Sequence[tuple[str, Course]]
"""One form of dependence on a covariate, in words and as a course; with a lag at every lag."""


def _forms(fit: Fit, columns: tuple[str, ...]) -> Iterator[tuple[str, Form]]:
    """Covariates of unknown functions, and their forms."""
    poses, s = fit.poses, fit.equations.conditions(fit.rows.vector).vector
    length = max(float(np.linalg.norm(s, axis=1).max()), NO_LENGTH)
    each_axis = s / length
    covariates = {"time_s": poses.time_s, "spin_rad_s": poses.spin_rad_s}
    covariates |= {name: poses.columns[name] for name in columns}
    for name, values in covariates.items():
        if not np.isfinite(values).all() or np.ptp(values) == 0:
            continue
        shapes = smooth_functions(values)
        yield name, [("", Course.of_size(shapes))]
        yield name, [("", Course.of_bias(shapes))]
        yield name, [("", Course.of_gain(shapes, each_axis))]
        if _has_room(fit, by_both := _by_axes_and(values, each_axis)):
            yield name, [(AND_READING, by_both)]
        if name in columns and not (name == TEMPERATURE and bends(poses, EFFECTS[CURVED])):
            curve = line_and_square(values)
            yield name, [(IN_A_CURVE, Course.of_bias(curve))]
            yield name, [(IN_A_CURVE, Course.of_gain(curve, each_axis))]
    yield ATTITUDE, [("", Course.of_size(_attitude(fit)))]
    if np.ptp(each_axis, axis=0).all():
        yield ATTITUDE, [("", _by_own_axis(each_axis))]
        yield ATTITUDE, _within(each_axis)
        if _has_room(fit, by_others := _by_other_axes(each_axis)):
            yield ATTITUDE, [("", by_others)]
    if poses.triad in EFFECTS[SQUARED].triads and np.isfinite(poses.force).all():
        yield ATTITUDE, [("", _by_products_of_force(poses.force))]
    if np.isfinite(poses.time_s).all():
        if TEMPERATURE in columns and np.ptp(poses.columns[TEMPERATURE]) > 0:
            yield TEMPERATURE, _with_a_lag(poses.time_s, poses.columns[TEMPERATURE])
        before = fit.equations.at_start.previous / length
        if np.isfinite(before).all() and before.any():
            # One that saturates is ``hysteresis``, with a width of its own.
            yield "previous", [("", Course(np.stack([before, before**2], axis=1)))]
            yield "previous", _by_approach(each_axis - before)


def _has_room(fit: Fit, course: Course) -> bool:
    """Whether ``course`` leaves more of the rows than it takes; else it may be any noise."""
    return bool(2 * course.values[0].size < fit.dof)


def _with_a_lag(time_s: FloatArray, warmth: FloatArray) -> Form:
    """A bias that follows ``warmth`` (n,) with a lag."""
    late = {lag_s: behind(warmth, time_s, lag_s) for lag_s in LAGS_S}
    return [
        (f"with a lag of about {lag_s:.0f} s", Course.of_bias((each - each.mean())[:, None]))
        for lag_s, each in late.items() if np.ptp(each) > 0
    ]


def _attitude(fit: Fit) -> FloatArray:
    """Cubic and quartic functions of the direction: the first that the nine parameters lack.

    Shape (n, 16).
    """
    s = fit.rows.vector
    n = s / np.linalg.norm(s, axis=1, keepdims=True)
    cubic = n[:, CUBIC[0]] * n[:, CUBIC[1]] * n[:, CUBIC[2]]
    return np.concatenate([cubic, (n[:, PAIRS[0]] * n[:, PAIRS[1]]) ** 2], axis=1)


def _by_own_axis(each_axis: FloatArray) -> Course:
    """Errors of each axis that are any smooth function of what that axis senses (n, 3)."""
    functions = [smooth_functions(values) for values in each_axis.T]
    count = min(each.shape[1] for each in functions)
    return Course.of_axis(np.stack([each[:, -count:] for each in functions], axis=2))


def _by_other_axes(each_axis: FloatArray) -> Course:
    """Errors of each axis by the cube of what the two others sense.

    Of their squares a magnitude shows the products of two axes, ``cross_quadratic``.
    """
    return Course(np.stack([np.roll(each_axis**3, by, axis=1) for by in (1, 2)], axis=1))


def _by_axes_and(values: FloatArray, each_axis: FloatArray) -> Course:
    """Errors of each axis by the square and the cube of what it senses, by these times a line in
    ``values`` (n,), and by what every axis senses times that line.
    """
    line, bent = line_and_square(values)[:, :1], [each_axis**2, each_axis**3]
    every = [*(np.roll(each_axis, by, axis=1) for by in range(3)), *bent]
    return Course.of_axis(np.stack([*bent, *(line * each for each in every)], axis=1))


def _within(each_axis: FloatArray) -> Form:
    """Errors of each axis that grow with what it senses (n, 3) within a limit and not beyond.

    Beside the scale that is a dead band as well as a saturation, which no smooth function follows.
    """
    return [(f"as far as {limit:g} of its largest and no further, as with a dead band or a limit",
             Course.of_axis(np.clip(each_axis / limit, -1, 1)[:, None, :])) for limit in LIMITS]


def _by_products_of_force(force: FloatArray) -> Course:
    """A bias by every product of two components of the specific force (n, 3): of second order.

    IEEE Std 528 has all of them in the acceleration-squared-sensitive drift rate; ``SQUARED`` has
    of each axis its own square. On a stopped plate nothing else here follows the attitude.
    """
    up = force / float(np.linalg.norm(force, axis=1).max())
    return Course.of_bias(up[:, PAIRS[0]] * up[:, PAIRS[1]])


def _by_approach(step: FloatArray) -> Form:
    """Errors of each axis by the side from which it came, over its last ``step`` (n, 3), no unit.

    That is a backlash: it grows with the step up to its width and no further.
    """
    return [(f"by the side from which it comes, within {limit:g}",
             Course(np.clip(step / limit, -1, 1)[:, None, :])) for limit in LIMITS]
