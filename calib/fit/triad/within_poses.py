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
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtri, stdtr

from calib.effects.effect import EFFECTS
from calib.fit.least_squares.result import Fit
from calib.fit.model import Model
from calib.fit.triad.correction import linear_form
from calib.fit.triad.determined import shift_by_rates
from calib.poses.averaging.common_course import CONTRASTS, CommonCourse, polynomials
from calib.poses.imu_log import AXES, FloatArray, Triad
from calib.poses.pose_set import PoseSet
from calib.poses.samples.batches import PARTS
from calib.poses.triad_kind import TRIAD_KINDS
from calib.rounding import two_digits

IN_A_SESSION = 1e-3
"""Probability that the poses of a session have such a course. A judgement: half and twice as much
contain as many."""

TYPICAL_CHANGE = 1e-3
"""Relative change of a plate's rate or a gain through a pose, where there is one. A judgement; the
distribution reaches a hundred times as far."""

LEAST_SHARE = 0.1
"""Share of a stated sd. Derived: what moves a parameter by less adds half a per cent to it, and is
not listed."""

TAUS = np.geomspace(0.3, 600.0, 27)
"""Time constants, s: a third of one of electronics, ten minutes as of a usual warm-up. Numerical:
with an hour six of 600 sound triads are told to settle by a line that says little of it."""

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
    if _typical(fit.poses.triad) and _may_have_one(fit.poses, fit.model, "bias"):
        yield from _of_bias(fit, fit.poses.courses)
    if _may_have_one(fit.poses, fit.model, "scale"):
        yield from _of_gain(fit, fit.poses.courses)


def at_one_length(poses: PoseSet, model: Model) -> PoseSet:
    """The poses as if all had one length, since a bias that settles is another in longer ones.

    By the mean of the amplitudes that the course shows; without one the readings stay, and so do
    those of a table, whose poses have no length.
    """
    length = poses.duration_s
    if length is None or not (_typical(poses.triad) and _may_have_one(poses, model, "bias")):
        return poses
    logged = length > 0
    mean = _settling_means(length[logged])
    longer = mean - mean.mean(axis=1, keepdims=True)
    reading = poses.reading.copy()
    reading[logged] -= longer.T @ _of_settling(poses).mean_size
    return replace(poses, reading=reading)


def _may_have_one(poses: PoseSet, model: Model, base: str) -> bool:
    """Whether a course of bias or scale is not that of an effect of the model."""
    return bool(poses.courses) and base in model.names and not any(
        "time" in each.needs or each.logged for each in model.effects)


def _of_bias(fit: Fit, courses: Sequence[CommonCourse]) -> Iterator[CourseWithin]:
    length = np.repeat([each.duration_s for each in courses], [each.poses for each in courses])
    square = _of_settling(fit.poses).square_off(_settling_means(length).mean(axis=1))
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
    sizes = _Sizes.of(value[:, None], sd[:, None], np.ones((1, len(courses))), TYPICAL_CHANGE)
    (square,) = sizes.square_off(np.array([0.5]))
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


def _normal_sd(value: FloatArray, sd: FloatArray, poses: FloatArray) -> FloatArray:
    """The sds (c, ...) by which values are as unlikely in a normal as in Student's distribution."""
    ratio = np.maximum(np.abs(value) / sd, LEAST_RATIO)
    dof = (poses - 1).reshape(-1, *[1] * (value.ndim - 1))
    return np.asarray(sd * ratio / -ndtri(np.maximum(stdtr(dof, -ratio), np.finfo(float).tiny)))


def _of_settling(poses: PoseSet) -> "_Sizes":
    """How large ``exp(-t/τ)`` is in the readings."""
    courses = poses.courses
    value, sd = (np.vstack([getattr(each, name) for each in courses])
                 for name in ("bias", "bias_sd"))
    number = np.repeat([each.poses for each in courses], len(CONTRASTS))
    share = TAUS[:, None] / [each.duration_s for each in courses]
    parts = PARTS * share[..., None] * -np.diff(
        np.exp(-np.linspace(0.0, 1.0, PARTS + 1) / share[..., None]))
    shape = polynomials(parts).reshape(len(TAUS), -1)
    return _Sizes.of(value, _normal_sd(value, sd, number), shape, _typical(poses.triad))


def _typical(triad: Triad) -> float:
    """How far the bias of a low-cost sensor warms up, SI; 0 where nothing is quoted."""
    sizes = (each.si_for(triad) for each in EFFECTS["warm_up"].page.typical.values())
    return next((size for size in sizes if size is not None), 0.0)


def _settling_means(length_s: FloatArray) -> FloatArray:
    """Means (g, n) of ``exp(-t/τ)`` over n poses."""
    share = TAUS[:, None] / length_s
    return np.asarray(share * -np.expm1(-1 / share))


@dataclass(frozen=True, eq=False)
class _Sizes:
    """What the poses tell of the size of a course, for s typical sizes and g shapes.

    ``weight`` (s, g, 1) is the probability of each, ``size`` and ``variance`` (s, g, k) are those
    of its amplitudes, SI, and ``beforehand`` (s, 1, 1) the typical square of these with the
    probability that they would have if the poses told nothing.
    """

    weight: FloatArray
    size: FloatArray
    variance: FloatArray
    beforehand: FloatArray

    @classmethod
    def of(
        cls, value: FloatArray, sd: FloatArray, shape: FloatArray, typical: float
    ) -> "_Sizes":
        """Sizes by contrasts ``value`` (c, k) and ``shape`` (g, c), those per unit of size."""
        prior = (SIZES * typical)[:, None, None] ** 2
        precision = np.einsum("gc,ck->gk", shape**2, sd**-2.0) + 1 / prior
        size = np.einsum("gc,ck->gk", shape, value / sd**2) / precision
        factor = 0.5 * (size**2 * precision - np.log(precision * prior)).sum(axis=2, keepdims=True)
        most = max(0.0, float(factor.max()))
        factor, nothing = np.exp(factor - most), np.exp(-most)
        each = IN_A_SESSION / factor.size
        odds = (1 - IN_A_SESSION) * nothing + each * factor.sum()
        return cls(each * factor / odds, size, 1 / precision, each * nothing / odds * prior)

    @property
    def mean_size(self) -> FloatArray:
        """Mean amplitude (g, k) with each shape, times its probability."""
        return np.asarray((self.weight * self.size).sum(axis=0))

    def square_off(self, m: FloatArray) -> FloatArray:
        """Squares (k,) of how far parameters may be off, which a course of unit size moves by
        ``m`` (g,)."""
        beyond = self.weight * (self.size**2 + self.variance) - self.beforehand
        return np.asarray(np.maximum(np.einsum("sgk,g->k", beyond, m**2), 0.0))
