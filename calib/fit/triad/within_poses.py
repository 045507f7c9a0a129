"""Errors of the parameters by a course of the readings that all poses have in common.

Readings that settle after each start, ``A exp(-t/τ)`` of a bias, move the mean of every pose by
``d = A m``, m the mean of the exponential over a pose: the bias is that of a sensor which has not
settled. A gain or a plate that changes by D through every pose is off by ``d = D/2`` from what it
is at either end. The course of the poses (:mod:`calib.poses.averaging.common_course`) tells A for
each τ, and D, with sizes as they typically are (half-Cauchy) and every τ equally likely on a
logarithmic scale. With π the probability that a session has such a course, and B the Bayes factor
of each size and τ against none, the parameters may be off by

    π <B E[d² | the poses] - E[d²]> / (1 - π + π <B>)

averaged over sizes and τ: the poses say so much more than what is typical, which is not in the
data. Where the course ends within the poses it is how far; where it is a line, little bounds it
but the typical size.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri, stdtr

from calib.effects.effect import EFFECTS
from calib.fit.least_squares.result import Fit
from calib.fit.triad.correction import linear_form
from calib.fit.triad.determined import shift_by_rates
from calib.poses.averaging.common_course import CONTRASTS, CommonCourse, polynomials
from calib.poses.imu_log import AXES, FloatArray
from calib.poses.samples.batches import PARTS
from calib.poses.triad_kind import TRIAD_KINDS
from calib.rounding import two_digits

IN_A_SESSION = 1e-3
"""Probability that the poses of a session have such a course. A judgement: with ten times as much
two sound triads of 600 are told to settle, and courses are contained hardly more often."""

TYPICAL_CHANGE = 1e-3
"""Relative change of a plate's rate or a gain through a pose, where there is one. A judgement; the
distribution reaches a hundred times as far."""

LEAST_SHARE = 0.1
"""Share of a sd. Derived: what moves a parameter by less adds half a per cent to it."""

TAUS = np.geomspace(1.0, 1000.0, 25)
"""Time constants over the length of a part, from what is over within it to eighty poses.
Numerical."""

SIZES = np.tan(np.pi / 2 * np.linspace(0.05, 0.95, 10))
"""Quantiles of a half-Cauchy distribution in units of the typical size. Numerical."""

LEAST_RATIO = 1e-3
"""Ratio of a value to its sd at which both distributions are taken at their middle. Numerical."""

FROM_END_TO_END = float(CONTRASTS[0, 1] - CONTRASTS[0, 0]) * PARTS
"""Change of the line along a pose, per unit of its contrast. Definition."""


@dataclass(frozen=True, eq=False)
class CourseWithin:
    """A course that all poses have in common.

    Attributes
    ----------
    cause : str
        Its name in the budget of the sds.
    cov : array, shape (p, p)
        What the parameters may be off by, SI.
    text, remedy : str
        What the readings do, in sentences, and what to do about it.
    """

    cause: str
    cov: FloatArray
    text: str
    remedy: str


def courses_within(fit: Fit) -> Iterator[CourseWithin]:
    """Each course that the poses show more than chance and a typical size do.

    A bias or gain whose model follows the clock or a logged column has a course of its own.
    """
    courses, names = fit.poses.courses, fit.model.names
    if not courses or any("time" in each.needs or each.logged for each in fit.model.effects):
        return
    typical = _typical(fit)
    if "bias" in names and typical is not None:
        yield from _of_bias(fit, courses, typical)
    if "scale" in names:
        yield from _of_gain(fit, courses)


def _of_bias(
    fit: Fit, courses: Sequence[CommonCourse], typical: float
) -> Iterator[CourseWithin]:
    value, sd = (np.vstack([getattr(each, name) for each in courses])
                 for name in ("bias", "bias_sd"))
    poses = np.repeat([each.poses for each in courses], len(CONTRASTS))
    square = _square_off(value, _normal_sd(value, sd, poses), *_settling(courses), typical)
    where = fit.model.slices()["bias"]
    if (square <= LEAST_SHARE**2 * np.diag(fit.cov)[where]).all():
        return
    matrix, _ = linear_form(fit.model, fit.theta)
    cov = np.zeros((fit.model.size, fit.model.size))
    cov[where, where] = matrix @ np.diag(square) @ matrix.T
    kind = TRIAD_KINDS[fit.poses.triad]
    longest = max(courses, key=lambda each: each.duration_s)
    change = longest.bias[0] * FROM_END_TO_END * kind.errors_per_unit
    axes = ", ".join(f"{axis} {two_digits(each)}"
                     for axis, each in zip(AXES, change, strict=True))
    yield CourseWithin("bias, within the poses", cov, (
        f"In every pose of {two_digits(longest.duration_s)} s the readings change alike, whatever "
        f"the attitude ({axes} {kind.error_unit} from start to end): the sensor settles after "
        f"each start. How far from there it still was, these poses hardly tell; the sds of the "
        f"biases allow for it."), SETTLE)


def _of_gain(fit: Fit, courses: Sequence[CommonCourse]) -> Iterator[CourseWithin]:
    value, sd = (np.array([getattr(each, name)[0] for each in courses]) * FROM_END_TO_END
                 for name in ("gain", "gain_sd"))
    sd = _normal_sd(value, sd, np.array([each.poses for each in courses]))
    (square,) = _square_off(value[:, None], sd[:, None], np.ones((1, len(courses))),
                            np.array([0.5]), TYPICAL_CHANGE)
    shift = shift_by_rates(fit).sum(axis=1)
    if (square * shift**2 <= LEAST_SHARE**2 * np.diag(fit.cov)).all():
        return
    turns = fit.poses.triad == "gyroscope"
    what = "the plate slows, a cable winds, or the gain settles" if turns else "the gain settles"
    change = 100 * float(np.average(value, weights=sd**-2.0))
    yield CourseWithin("rate or gain, within the poses", square * np.outer(shift, shift), (
        f"In every pose the readings change alike by {two_digits(change)} % of their size from "
        f"start to end: {what}. Half of that is in the sds of the scales."),
        LOOSEN if turns else SETTLE)


SETTLE = ("Leave sensor and logger running for 20 minutes before the first pose and between the "
          "poses, and record these again")
LOOSEN = "Lay the cable loose, let plate and sensor run warm, and record these poses again"


def _typical(fit: Fit) -> float | None:
    """How large a warm-up of the bias of a low-cost sensor is, SI; None where nothing is quoted."""
    sizes = (each.si_for(fit.poses.triad) for each in EFFECTS["warm_up"].page.typical.values())
    return next((size for size in sizes if size is not None), None)


def _normal_sd(value: FloatArray, sd: FloatArray, poses: FloatArray) -> FloatArray:
    """The sds (c, ...) by which values are as unlikely in a normal as in Student's distribution."""
    ratio = np.maximum(np.abs(value) / sd, LEAST_RATIO)
    dof = (poses - 1).reshape(-1, *[1] * (value.ndim - 1))
    return np.asarray(sd * ratio / -ndtri(np.maximum(stdtr(dof, -ratio), np.finfo(float).tiny)))


def _settling(courses: Sequence[CommonCourse]) -> tuple[FloatArray, FloatArray]:
    """Contrasts (g, c) of ``exp(-t/τ)`` in the poses of all lengths, and its mean m (g,)."""
    length = np.array([each.duration_s for each in courses])
    share = TAUS[:, None] * np.median(length) / PARTS / length  # (g, lengths)
    fall = np.exp(-np.linspace(0.0, 1.0, PARTS + 1) / share[..., None])
    parts = PARTS * share[..., None] * -np.diff(fall)
    mean = np.average(parts.mean(axis=2), axis=1, weights=[each.poses for each in courses])
    return polynomials(parts).reshape(len(TAUS), -1), mean


def _square_off(
    value: FloatArray, sd: FloatArray, shape: FloatArray, m: FloatArray, typical: float
) -> FloatArray:
    """Squares of how far parameters may be off, (k,).

    Parameters
    ----------
    value, sd : array, shape (c, k)
        Contrasts.
    shape : array, shape (g, c)
        Of each possible course, per unit of its size.
    m : array, shape (g,)
        By how much it moves the mean, per unit of its size.
    typical : float
        Size.
    """
    prior = (SIZES * typical)[:, None, None] ** 2  # (s, 1, 1)
    info = np.einsum("gc,ck->gk", shape**2, sd**-2.0)
    precision = info + 1 / prior
    size = np.einsum("gc,ck->gk", shape, value / sd**2) / precision
    factor = 0.5 * (size**2 * precision - np.log(precision * prior)).sum(axis=2, keepdims=True)
    most = max(0.0, float(factor.max()))
    factor, nothing = np.exp(factor - most), np.exp(-most)
    beyond = m[:, None] ** 2 * (factor * (size**2 + 1 / precision) - nothing * prior)
    odds = (1 - IN_A_SESSION) * nothing + IN_A_SESSION * factor.mean()
    return np.asarray(np.maximum(IN_A_SESSION * beyond.mean(axis=(0, 1)) / odds, 0.0))
