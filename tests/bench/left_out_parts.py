"""Models chosen on some poses and judged on the others, and what such a choice gives by chance.

The error of a pose that took no part is counted in sds of its prediction with bias, scale and
misalignment: what the pose's own noise and the few poses beside it leave open. Of a sound base it
is one, however many poses there are, and no pose that alone holds a parameter up decides by itself.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from calib.diagnosis.diagnose import diagnose
from calib.diagnosis.hypotheses.listed import listed_hypotheses
from calib.diagnosis.search.refit import refit
from calib.effects.catalogue import STEP, find_effect
from calib.effects.effect import EFFECTS, Effect
from calib.errors import CalibrationError
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import extend, fit
from calib.fit.model import stack_columns
from calib.fit.rows.residuals import Equations
from calib.fit.validation.leave_one_out import compare
from calib.poses.conditions import Conditions
from calib.poses.imu_log import BoolArray, FloatArray
from calib.poses.pose_set import PoseSet

PARTS = 7  #: parts of the poses, each left out in turn
MOST_ADDED = 3  #: effects that the verdict may add to the poses of a part
FEWEST_DOF = 2  #: of the base without a part; with fewer nothing can be chosen


def single_effects(base: Fit) -> dict[str, Effect]:
    """Every listed effect that these poses can evaluate, by its name."""
    effects = {h.name: h.effect for h in listed_hypotheses(base)[0] if h.effect is not None}
    if np.isfinite(base.poses.time_s).all():
        effects[STEP] = EFFECTS[STEP].within(base.equations.at_reading)
    return effects


def best_single(base: Fit) -> tuple[str, Fit]:
    """The listed effect that alone lowers the leave-one-out error most; ``none`` and the base."""
    best, least, name = base, compare(base).loo_rms, "none"
    for each, effect in single_effects(base).items():
        joint = refit(base, [effect])
        if joint is not None and (error := compare(joint.fit).loo_rms) < least:
            best, least, name = joint.fit, error, each
    return name, best


def as_the_verdict_says(base: Fit) -> tuple[str, Fit]:
    """What is added while the verdict names something and the leave-one-out error falls."""
    now, names = base, []
    for _ in range(MOST_ADDED):
        said = diagnose(now)
        effects = single_effects(now) | {
            name: find_effect(name) for name in said.addable
            if find_effect(name).acts_on == "noise"}
        known = [name for name in (*said.addable, *said.names) if name in effects]
        if not known:
            break
        try:
            after = extend(now, [effects[known[0]]])
        except CalibrationError:
            break
        drawn = effects[known[0]].acts_on == "noise"
        if not drawn and not compare(after).predicts_better_than(compare(now)):
            break
        now, names = after, [*names, known[0]]
    return " + ".join(names) or "nothing", now


def errors_in(fitted: Fit, poses: PoseSet, out: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Whitened errors of the rows of poses ``out`` (n,) of the fit, and its own sds of them."""
    equations = Equations.of_sets(
        (poses,), fitted.model, fitted.equations.start.take(None)).take(0)
    rows = equations.rows(fitted.theta, fitted.eta, fitted.shapes)
    mine = np.flatnonzero(out[equations.row_pose])
    mine = mine[mine < equations.data_count]
    jacobian = rows.jacobian[mine]
    spread = np.sqrt(np.einsum("ri,ij,rj->r", jacobian, _whole_cov(fitted), jacobian))
    return rows.residual[mine], spread


def _whole_cov(fitted: Fit) -> FloatArray:
    """Covariance of all parameters along what the poses determine, stated sds being true."""
    root = np.sqrt(fitted.weight)
    jacobian = fitted.rows.jacobian @ fitted.directions * root[:, None]
    inside = np.linalg.pinv(jacobian.T @ jacobian)
    return np.asarray(fitted.directions @ inside @ fitted.directions.T)


@dataclass(frozen=True)
class Judged:
    """Root mean squares of the errors of poses left out, in sds of the base's prediction.

    ``singles`` are the effects that were chosen, part by part, ``named`` those of the verdict.
    """

    base: float
    single: float
    verdict: float
    singles: tuple[str, ...]
    named: tuple[str, ...]


def judge(base: Fit, seed: int = 0) -> Judged | None:
    """Choose on all parts but one, and judge on that one; None where the poses are too few."""
    poses, n = base.poses, len(base.poses)
    part = np.random.default_rng(seed).permutation(n) % PARTS
    errors: list[list[FloatArray]] = [[], [], []]
    names: list[tuple[str, str]] = []
    for k in range(PARTS):
        out = part == k
        try:
            inside = fit(poses.take(~out), base.model)
        except CalibrationError:
            return None
        if inside.dof < FEWEST_DOF:
            return None
        single, with_single = best_single(inside)
        verdict, with_verdict = as_the_verdict_says(inside)
        names.append((single, verdict))
        _, spread = errors_in(inside, poses, out)
        for into, fitted in zip(errors, (inside, with_single, with_verdict), strict=True):
            into.append(errors_in(fitted, poses, out)[0] / np.hypot(1.0, spread))
    rms = [float(np.sqrt(np.mean(np.concatenate(each) ** 2))) for each in errors]
    return Judged(*rms, *(tuple(each) for each in zip(*names, strict=True)))  # type: ignore[arg-type]


def elsewhere(fitted: Fit, other: Fit) -> float:
    """Error of a fit on the poses of ``other``, another session, in sds of both, rms.

    The bias is that of the other session: sensors turn on with a new one.
    """
    everyone = np.ones(len(other.poses), bool)
    error, spread = errors_in(fitted, other.poses, everyone)
    equations = Equations.of_sets(
        (other.poses,), fitted.model, fitted.equations.start.take(None)).take(0)
    rows = equations.rows(fitted.theta, fitted.eta, fitted.shapes)
    bias = rows.jacobian[: len(error), fitted.model.slices()["bias"]]
    sd = np.hypot(1.0, spread)
    bias, error = bias / sd[:, None], error / sd
    left = error - bias @ np.linalg.lstsq(bias, error, rcond=None)[0]
    return float(np.sqrt((left**2).sum() / max(len(left) - 3, 1)))


def sound_sessions(base: Fit, count: int, seed: int = 0) -> Iterator[Fit]:
    """Fits of sessions in which nothing is missing, with the poses, the sds and the model of one.

    Only for a model of bias, scale and misalignment: it is inverted as the matrix that it is.
    """
    poses, random = base.poses, np.random.default_rng(seed)
    unit = np.vstack([np.zeros(3), np.eye(3)])
    at = Conditions.of_vectors(unit)
    offset, *ends = unit - stack_columns(base.model.effects, at, {}) @ base.theta
    matrix = np.array(ends).T - offset[:, None]
    vector = base.rows.vector
    size = np.linalg.norm(vector, axis=1, keepdims=True)
    right = vector * poses.reference.magnitude[:, None] / size
    reading = (right - offset) @ np.linalg.inv(matrix).T
    for _ in range(count):
        noise = poses.sd * random.normal(size=poses.sd.shape)
        try:
            yield fit(replace(poses, reading=reading + noise), base.model)
        except CalibrationError:
            continue
