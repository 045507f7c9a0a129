"""Hypotheses, part two: effects that are weighed by their course over the poses.

Of the catalogue the steps of the bias, a bias that wanders and a plate whose rate scatters; beside
these a pose that has nothing to do with the others. What is drawn has as columns the strongest
modes of its covariance, of which one size is unknown: no model holds it but by that size
(:mod:`calib.effects.drawn`).
"""

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import Course, Hypothesis, modes_about_mean
from calib.effects.catalogue import further_step
from calib.effects.effect import EFFECTS, Effect, Page, per_axis
from calib.effects.steps import STEP_MARGIN
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.widened import times_apart
from calib.fit.noise_size import ODDS_RARE
from calib.poses.checks.pose_checks import LARGEST_RATE_CHANGE
from calib.poses.conditions import PLACE_COLUMN, Conditions
from calib.poses.imu_log import AXES, BoolArray, FloatArray
from calib.poses.pose_set import PoseSet
from calib.rounding import duration

STEPS_TRIED = 32  #: times of a step that are tried, evenly and in pauses; a limit of time
PAUSE = 2.0
"""Time between two poses over the usual one, from which it is a pause: something was done in it
besides laying the sensor, and a bias that steps does so there. A judgement."""
FROM_RUN_TO_RUN = "from run to run"  #: how the rate of the plate scatters between settings
WANDER_SPANS = (0.05, 0.2, 0.8, 3.2)
"""Correlation times of a wandering bias over the length of the session, four times apart. Derived:
from what moves from pose to pose to a random walk, which about its mean is what any slower one
is."""

NO_PAGE = Page(formula="", typical={}, source="", confounded="", separates="")


def by_clock(fit: Fit) -> tuple[Hypothesis, ...]:
    """All hypotheses that follow from the times of the poses."""
    return (*_steps(fit), *_bad_poses(fit), *_wanders(fit))


def _marked(name: str, marks: FloatArray) -> Effect:
    """A separate bias where ``marks`` (n,) is one; it exists only within the diagnosis."""

    def columns(at: Conditions) -> FloatArray:
        place = at.columns.get(PLACE_COLUMN, np.arange(len(marks))).astype(int)
        return per_axis(np.tile(marks[place][:, None], 3))

    return Effect(name, AXES, "{u}", columns, "", NO_PAGE, orthogonal=True)


def _steps(fit: Fit) -> list[Hypothesis]:
    """A bias that steps once, for every time between two poses, or ``STEPS_TRIED`` and each pause.
    """
    poses = fit.poses
    last = len(poses) - STEP_MARGIN
    if not np.isfinite(poses.time_s).all() or last <= STEP_MARGIN:
        return []
    order = np.argsort(poses.time_s, kind="stable")
    apart = np.diff(poses.time_s[order])
    longest, usual = 1 + np.argsort(-apart, kind="stable")[:STEPS_TRIED], np.median(apart)
    pauses = [k for k in longest if apart[k - 1] > PAUSE * usual and STEP_MARGIN <= k <= last]
    evenly = np.linspace(STEP_MARGIN, last, STEPS_TRIED).astype(int)
    tried = np.unique(np.concatenate([evenly, np.array(pauses, int)]))
    prior = float(np.log(ODDS_RARE / len(tried)))
    name, hypotheses = further_step(fit.model.names), []
    for k in tried:
        after = np.zeros(len(poses))
        after[order[k:]] = 1.0
        time_s = 0.5 * float(poses.time_s[order[k - 1]] + poses.time_s[order[k]])
        hypotheses.append(Hypothesis(
            name, "listed", prior, _marked(name, after), course=Course.of_bias(after[:, None]),
            detail=f"{time_s:.1f} s"))
    return hypotheses


def _bad_poses(fit: Fit) -> list[Hypothesis]:
    """A bad pose as a hypothesis, for every pose."""
    poses = fit.poses
    prior = float(np.log(ODDS_RARE / len(poses)))
    return [
        Hypothesis("bad_pose", "bad_pose", prior, _marked("bad_pose", mark),
                   course=Course.of_bias(mark[:, None]), detail=label)
        for label, mark in zip(poses.label, np.eye(len(poses)), strict=True)
    ]


def _wanders(fit: Fit) -> list[Hypothesis]:
    """A bias that wanders about its mean: an Ornstein-Uhlenbeck process, by its strongest modes.

    Where the runs have no common clock, each wanders on its own.
    """
    apart_s = times_apart(fit.poses)
    length_s = float(apart_s[np.isfinite(apart_s)].max(initial=0.0))
    if length_s == 0 or "bias_wander" in fit.model.names:
        return []
    prior = float(np.log(CONSTANTS.odds_wander / len(WANDER_SPANS)))
    hypotheses = []
    for span in WANDER_SPANS:
        modes = modes_about_mean(np.exp(-apart_s / (span * length_s)))
        hypotheses.append(Hypothesis(
            "bias_wander", "drawn", prior, course=Course.of_bias(modes),
            detail=f"correlated over about {duration(span * length_s)}"))
    return hypotheses


def scattering_rates(fit: Fit) -> list[Hypothesis]:
    """A plate whose rate scatters: from run to run, and from pose to pose beside poses at rest.

    A rate of its own for every pose hides any error of the sensor (:func:`scatters_too_much`).
    """
    poses, turning = fit.poses, ~fit.poses.reference.is_null
    if poses.triad not in EFFECTS["rate_scatter"].triads or not turning.any() or (
            "rate_scatter" in fit.model.names):
        return []
    courses = {FROM_RUN_TO_RUN: _by_run(poses, turning)}
    if poses.reference.is_null.any():
        shares = np.where(turning, poses.reference.magnitude, 0.0)
        courses["from pose to pose"] = Course.of_size(np.diag(shares)[:, turning])
    prior = float(np.log(ODDS_RARE / len(courses)))
    return [Hypothesis("rate_scatter", "drawn", prior, course=course, detail=detail)
            for detail, course in courses.items()]


def scatters_too_much(fit: Fit) -> bool:
    """Whether the plate's rate would have to scatter by more than a plate may change in a pose."""
    return fit.relative_misfit > LARGEST_RATE_CHANGE


def _by_run(poses: PoseSet, turning: BoolArray) -> Course:
    """A rate of its own for each run on the turning plate.

    Where each has one stated rate, that is wrong beyond its sd; else the length of the vectors is.
    A factor that all rates have in common is a gain of the sensor, and no scatter.
    """
    reference = poses.reference
    runs = dict.fromkeys(run for run, is_turning in zip(poses.run, turning, strict=True)
                         if is_turning)
    stated = [j for j, name in enumerate(reference.common_names)
              if name in reference.of_setting and reference.common[:, j].any()]
    if len(stated) == len(runs):
        sd = np.abs(reference.common[:, stated])
        in_sd = np.divide(reference.magnitude[:, None], sd, out=np.zeros_like(sd),
                          where=sd > 0).max(axis=0)
        apart = np.eye(len(stated)) - np.outer(in_sd, in_sd) / (in_sd @ in_sd)
        return Course.of_common(np.eye(len(reference.common_names))[:, stated] @ apart)
    return Course.of_size(np.array([[float(run == name) for name in runs] for run in poses.run]))
