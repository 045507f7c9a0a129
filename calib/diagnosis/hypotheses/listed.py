"""Hypotheses, part one: everything that can be added to the model by its name.

Listed effects, biases that follow a logged column, the user's own effects, and what belongs to the
base but is not in the model. A hypothesis stands for one of them at one value of its shape
parameter. :mod:`calib.diagnosis.hypotheses.courses` has those of the catalogue that are weighed by
their course over the poses, :mod:`calib.diagnosis.hypotheses.unlisted` what has no name there.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.columns import causes
from calib.diagnosis.hypotheses.filmed import between_clips
from calib.effects.catalogue import (
    BASE,
    REFERENCE_DRIFT,
    SECOND_WARM_UP,
    STEP,
    WARM_UP,
    find_effect,
)
from calib.effects.column import column_effect
from calib.effects.effect import EFFECTS, Effect
from calib.effects.needs import why_not_finite
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.widened import MODES
from calib.fit.model import Model
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet

OTHERWISE = ("reading", "noise")
"""Places whose effects are no candidates: the base, and those that :mod:`..courses` weighs."""

LEAST_BEND = 0.1
"""Scatter of a square about a line, over the square of half the range, from which poses tell a
curve from a line. A judgement: of a column spread evenly it is 0.30, of two soaks whose room
wanders by a fiftieth of their distance 0.03."""

ANY_FUNCTION = "~"
"""Prefix of the covariate of an unknown function, which separates it from effects' names."""

BIAS = "bias"  #: what errs in a course of the bias
GAIN = "gain"  #: what errs in a course of the gain
OWN_AXIS = "error of each axis"  #: what errs in a function of what an axis senses
ATTITUDE = "attitude"  #: what a function is of, where it is of how the sensor lies
COVARIATES = {"time": "time_s", "plate": "spin_rad_s"}
"""What an effect is a function of, by what it needs besides the vector, if that has another name.
Definition."""

Kind = Literal["listed", "drawn", "unknown", "bad_pose"]
"""Effects whose sizes a model holds, those whose coefficients are drawn, and what has no name."""


@dataclass(frozen=True, eq=False)
class Course:
    """Errors with a course over the poses, of each axis by itself or of the vectors' length.

    Parameters
    ----------
    values : array, shape (n, k, 3) or (n, k, 1)
        The k courses on the three axes, each with a parameter of its own; or on the length. Of
        ``on_common`` (q, k, 1): on what is stated of the q common errors, in their sds.
    on_common : bool
    errs : str
        What of the reading has the course: ``bias``, ``gain``, ``error of each axis``; empty of the
        length and of errors of several kinds.
    """

    values: FloatArray
    on_common: bool = False
    errs: str = ""

    @classmethod
    def of_bias(cls, values: FloatArray) -> "Course":
        """A bias with the courses ``values`` (n, k), the same on every axis."""
        return cls(np.repeat(values[:, :, None], 3, axis=2), errs=BIAS)

    @classmethod
    def of_gain(cls, values: FloatArray, each_axis: FloatArray) -> "Course":
        """A gain with the courses ``values`` (n, k) on all of ``each_axis`` (n, 3)."""
        return cls(values[:, :, None] * each_axis[:, None, :], errs=GAIN)

    @classmethod
    def of_axis(cls, values: FloatArray) -> "Course":
        """Errors of each axis (n, k, 3) that are functions of what that axis senses."""
        return cls(values, errs=OWN_AXIS)

    @classmethod
    def of_size(cls, values: FloatArray) -> "Course":
        """The length of the vectors with the courses ``values`` (n, k)."""
        return cls(values[:, :, None])

    @classmethod
    def of_common(cls, values: FloatArray) -> "Course":
        """What is stated of the common errors, in their sds, ``values`` (q, k)."""
        return cls(values[:, :, None], on_common=True)

    @property
    def is_of_size(self) -> bool:
        """Whether the length of the vectors errs, not each axis."""
        return bool(self.values.shape[2] == 1)


def modes_about_mean(kernel: FloatArray) -> FloatArray:
    """The modes (n, m), no unit, of a course of covariance ``kernel`` (n, n) about its mean.

    Together they have unit variance; those of less than the share that a fit sees are left out.
    """
    about = kernel - kernel.mean(axis=0)
    about = about - about.mean(axis=1, keepdims=True)
    variance, modes = np.linalg.eigh(about)
    share, modes = variance[-MODES:] / np.trace(about), modes[:, -MODES:]
    strong = share > VISIBLE_SHARE**2
    return np.asarray(modes[:, strong] * np.sqrt(share[strong] * len(kernel)))


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One effect or fault that could be missing.

    Parameters
    ----------
    name : str
        Hypotheses of one name are one thing at other shapes, poses or times: the effect,
        ``bad_pose``, or for an unknown function ``follows`` behind
        ``ANY_FUNCTION``.
    kind : str
    log_prior : float
        Log odds of being in the model against not, before the data.
    effect : Effect or None
        What a joint refit adds; None where only the rows at hand can hold it.
    shape : float or None
        Value of its shape parameter.
    course : Course or None
        Errors of the vectors in closed form, where no effect is evaluated for them.
    detail : str
        The pose, the time or the form, in words.
    follows : str or None
        What an unknown function is a function of: a logged column, ``time_s``, ``spin_rad_s``,
        ``attitude`` or ``previous``; None for everything else.
    """

    name: str
    kind: Kind
    log_prior: float
    effect: Effect | None = None
    shape: float | None = None
    course: Course | None = None
    detail: str = ""
    follows: str | None = None

    @property
    def on_reference(self) -> bool:
        """Whether it is an error of the reference, not of the vectors."""
        return self.effect is not None and self.effect.acts_on == "reference"

    @property
    def in_catalogue(self) -> bool:
        """Whether it is an effect with a name."""
        return self.kind in ("listed", "drawn")

    @property
    def is_placed(self) -> bool:
        """Whether it happened once, at a pose or a time, so that a set may hold several."""
        return self.effect is not None and self.course is not None

    @property
    def is_course(self) -> bool:
        """Whether it is a course of the bias in time, of whatever form."""
        return self.follows == "time_s" or (
            self.in_catalogue and self.course is not None and not self.course.is_of_size)

    @property
    def covariate(self) -> str:
        """What it is a function of: a logged column, time, the pose before, else the attitude.

        Nothing of the base is, which every sensor has, and nothing that happened once.
        """
        if self.follows is not None or self.effect is None or self.is_placed or (
                self.effect.acts_on == "reading"):
            return self.follows or ""
        first = next(iter((*self.effect.logged, *self.effect.needs)), ATTITUDE)
        return COVARIATES.get(first, first)

    @property
    def subject(self) -> str:
        """The covariate of an unknown function, or ``name``."""
        return self.name if self.follows is None else self.follows


def candidate_effects(
    model: Model, poses: PoseSet, user_effects: Sequence[Effect] = (),
    covariates: Sequence[str] | None = None,
) -> Iterator[Effect]:
    """Effects that could be added to ``model``: listed, logged columns, the user's.

    These include bias, scale and misalignment if the model lacks them.

    Parameters
    ----------
    model : Model
    poses : PoseSet
        What it is fitted to.
    user_effects : sequence of Effect
        User-defined effects.
    covariates : sequence of str or None
        Logged columns that may cause an error; None leaves the choice to
        :func:`calib.diagnosis.hypotheses.columns.is_cause`.

    Yields
    ------
    Effect
        It acts on the triad of ``poses``; whether these can evaluate it is not checked.
    """
    # Without a true vector, a gain would be fitted to the errors of the readings themselves.
    base = BASE if poses.reference.magnitude.any() else BASE[:1]
    listed = [e for e in EFFECTS.values() if e.name in base or e.acts_on not in OTHERWISE]
    if WARM_UP in model.names:
        listed.append(find_effect(SECOND_WARM_UP))
    columns = [
        column_effect(name)
        for name in causes(poses, covariates)
        if name not in {e.names_column for e in EFFECTS.values()}
    ]
    inside = {*model.names, *(name for e in model.effects for name in e.contains)}
    for effect in (*listed, *columns, *user_effects):
        if effect.name == STEP or (effect.shape and not effect.shape.is_fitted
                                   and not bends(poses, effect)):
            continue
        excluded = covariates is not None and set(effect.logged) - {*covariates}
        if excluded and effect not in user_effects:
            continue
        if effect.name not in inside and poses.triad in effect.triads:
            yield effect


def bends(poses: PoseSet, curve: Effect) -> bool:
    """Whether ``poses`` (n) saw enough values of the column of ``curve`` to tell it from a line."""
    for name in curve.logged:
        values = poses.columns.get(name, np.full(len(poses), np.nan))
        half = 0.5 * float(np.ptp(values))
        if np.isfinite(half) and half > 0:
            x = (values - values.mean()) / half
            rest = x**2 - np.polyval(np.polyfit(x, x**2, 1), x)
            if float(np.sqrt(np.mean(rest**2))) < LEAST_BEND:
                return False
    return True


def listed_hypotheses(
    fit: Fit, user_effects: Sequence[Effect] = (), covariates: Sequence[str] | None = None
) -> tuple[Sequence[Hypothesis], dict[str, str]]:
    """Every effect that could be added, at each start of its shape, and why others cannot be."""
    at = fit.equations.at_reading
    effects = [e.within(at) for e in candidate_effects(
        fit.model, fit.poses, user_effects, covariates)]
    absent = {effect.name: why_not_finite(effect, at) for effect in effects
              if not np.isfinite(effect.evaluate(at)).all()}
    return _in_their_forms(fit, [each for each in effects if each.name not in absent]), absent


def _in_their_forms(fit: Fit, effects: Sequence[Effect]) -> Sequence[Hypothesis]:
    """``effects``, all equally likely, at each start of their shapes, with clips at any time."""
    each = float(np.log(CONSTANTS.odds_listed / max(len(effects), 1)))
    hypotheses = []
    for effect in effects:
        shapes: tuple[float | None, ...] = effect.shape.starts if effect.shape else (None,)
        prior = each - float(np.log(len(shapes)))
        forms = [effect]
        if effect.name == REFERENCE_DRIFT and (open_times := between_clips(fit, effect)):
            forms.insert(0, open_times)
            prior -= float(np.log(len(forms)))
        hypotheses += [Hypothesis(effect.name, "listed", prior, form, s)
                       for form in forms for s in shapes]
    return hypotheses


def held(hypothesis: Hypothesis, number: int) -> Effect:
    """The effect as a refit adds it, under a name that occurs once in a model."""
    assert hypothesis.effect is not None
    if not hypothesis.is_placed:
        return hypothesis.effect
    return replace(hypothesis.effect, name=f"{hypothesis.name} {number}")
