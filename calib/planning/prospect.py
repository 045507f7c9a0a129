"""Expected results of poses before they are recorded: sds, conditioning, blind effects, next pose.

Ideal readings of the planned poses are fitted by the same code that will fit the real ones, with
the sds that real ones would have. The covariance does not depend on the readings' errors, so the
sds of the parameters are those to be obtained; poses that would be refused are refused here.

D-efficiency compares the information per pose, ``det(JᵀJ)^(1/p) / n``, with that of the 18 wedge
poses of Angrisano et al. at the first setting of the plan: 1 is as good, 0 is singular.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.diagnosis.hypotheses.listed import candidate_effects
from calib.diagnosis.hypotheses.signature import Projector, Signature, are_aliases, effect_columns
from calib.diagnosis.next_measurement.ideal_poses import PlannedRun, ideal_poses
from calib.diagnosis.next_measurement.pose_blocks import POSE_S
from calib.effects.effect import Effect
from calib.effects.needs import unavailable
from calib.fit.least_squares.identifiability import rows_about_zero, scaled_condition
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from calib.fit.linear import unit_columns
from calib.fit.model import Model
from calib.fit.parameters import triad_parameters
from calib.fit.rows.residuals import Equations
from calib.numbers import NO_LENGTH
from calib.poses.attitudes import natural_directions
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.pose_set import PoseSet

WEDGE = natural_directions(corners=False)

WEAK_PRIOR = 1e-9
"""Share of the information on a parameter, so that undetermined plans can be compared. Numerical:
as small as the singular values that count as zero (``RANK_TOLERANCE``)."""


@dataclass(frozen=True, eq=False)
class Prospect:
    """Expected results of a plan.

    Attributes
    ----------
    fit : Fit
        Of the planned poses.
    sd : array, shape (3, 3)
        Expected sds of misalignment (rad), bias (SI) and scale (relative), each x, y, z.
    dof : int
        Rows beyond the parameters.
    condition : float
        Largest over smallest singular value of the unit columns of the model; 1 is the best.
    d_efficiency : float
        As this module says; 1 is that of the 18 wedge poses.
    blind : tuple of str
        Effects that these poses cannot see.
    partly : dict of str to (int, int)
        Number of an effect's parameters that they see, and of all its parameters.
    aliases : tuple of tuple of str
        Groups that look the same.
    absent : dict of str to str
        Why an effect cannot be judged at all.
    """

    fit: Fit
    sd: FloatArray
    dof: int
    condition: float
    d_efficiency: float
    blind: tuple[str, ...]
    partly: dict[str, tuple[int, int]]
    aliases: tuple[tuple[str, ...], ...]
    absent: dict[str, str]


def prospect_of(
    poses: PoseSet,
    model: Model,
    spec: TriadSpec,
    user_effects: Sequence[Effect] = (),
    covariates: Sequence[str] | None = None,
) -> Prospect:
    """Judge a plan.

    Parameters
    ----------
    poses : PoseSet
        Ideal poses, or recorded ones.
    model : Model
        The model to be fitted.
    spec : TriadSpec
        The data sheet.
    user_effects : sequence of Effect
        User-defined effects.
    covariates : sequence of str, optional
        Logged columns that may cause an error; without it those whose names say so.

    Raises
    ------
    Undetermined
        The poses would be too few, or not determine the model; the message says what is missing.
    FitFailed
        The fit of the poses did not converge.
    Contradiction
        By the fit of recorded poses: their readings or references contradict each other.
    """
    fitted = fit(poses, model)
    projector = Projector(fitted)
    signatures, absent = [], {}
    partly = {}
    for effect in candidate_effects(fitted.model, fitted.poses, user_effects, covariates):
        reason = unavailable(effect, poses.conditions(poses.reading))
        if reason is not None:
            absent[effect.name] = reason
            continue
        signature = projector.signature(effect.name, effect_columns(fitted, effect))
        signatures.append(signature)
        if 0 < signature.seen < len(effect.parameters):
            partly[effect.name] = (signature.seen, len(effect.parameters))
    parameters = triad_parameters(model, fitted.theta, fitted.cov, spec)
    misalignment, bias, scale_sd = parameters.sd
    scale = parameters.scale_counts_per_unit
    return Prospect(
        fit=fitted,
        sd=np.array([misalignment, bias / scale, scale_sd / scale]),
        dof=fitted.dof,
        condition=float(scaled_condition(
            rows_about_zero(fitted.equations, fitted.rows) @ fitted.basis)[0]),
        d_efficiency=d_efficiency(fitted),
        blind=tuple(signature.name for signature in signatures if signature.is_blind),
        partly=partly,
        aliases=alias_groups(signatures),
        absent=absent,
    )


def alias_groups(signatures: Sequence[Signature]) -> tuple[tuple[str, ...], ...]:
    """Effects that cannot be told apart in these poses, in groups of two or more."""
    groups: list[list[Signature]] = []
    for signature in signatures:
        if signature.is_blind:
            continue
        alike = next((group for group in groups if are_aliases(group[0], signature)), None)
        if alike is None:
            groups.append([signature])
        else:
            alike.append(signature)
    return tuple(tuple(s.name for s in group) for group in groups if len(group) > 1)


def _information(rows: FloatArray, poses: int) -> float:
    """``det(JᵀJ)^(1/p) / n`` of the whitened rows (d, p) of n poses."""
    singular = np.linalg.svd(rows, compute_uv=False)
    return float(np.exp(2 * np.log(np.maximum(singular, NO_LENGTH)).mean()) / poses)


def d_efficiency(fitted: Fit) -> float:
    """Information per pose, compared with that of the 18 wedge poses at the first setting.

    It is that of bias, scale and misalignment: effects that follow a logged column do not depend on
    the attitudes.
    """
    ideal = Equations.of(_wedge_poses(fitted), fitted.model)
    eta = np.zeros(ideal.common_count)
    p = fitted.model.size
    wedge_rows = ideal.rows(np.zeros(p), eta, fitted.shapes).jacobian[: ideal.data_count, :p]
    base = fitted.equations.terms.reading.index
    basis = fitted.basis if len(base) == p else np.eye(p)[:, base]
    rows = rows_about_zero(fitted.equations, fitted.rows)
    return (_information(rows @ basis, len(fitted.poses))
            / _information(wedge_rows @ basis, len(WEDGE)))


def _wedge_poses(fitted: Fit) -> PoseSet:
    """The 18 wedge poses at the first setting of the plate, with the sds of its poses."""
    poses = fitted.poses
    turning = np.flatnonzero(~poses.reference.is_null)
    first = poses.run[turning[0]] if turning.size else poses.run[0]
    like = np.array([run == first for run in poses.run])
    at = int(np.flatnonzero(like)[0])
    matrix = fitted.equations.start.matrix  # from the data sheet's units to true ones
    typical_sd = np.sqrt(np.median(poses.sd[like] ** 2, axis=0) @ (matrix**2).T)
    n = len(WEDGE)
    run = PlannedRun(
        "wedge", WEDGE, float(poses.reference.magnitude[at]), float(poses.spin_rad_s[at]),
        typical_sd, 0.0, (), float(np.linalg.norm(poses.force[at])), np.arange(n, dtype=float),
        np.tile(poses.vibration[at], (n, 1)),
        {name: np.full(n, values[at]) for name, values in poses.columns.items()})
    return replace(ideal_poses(poses.triad, [run]), reference=poses.reference.take(np.full(n, at)))


@dataclass(frozen=True, eq=False)
class BestPose:
    """One more pose.

    Attributes
    ----------
    run : str
        Its plate setting.
    up : array, shape (3,)
        Unit vector of the side that faces up.
    shrinks : float
        Factor by which the geometric mean of the sds of all parameters falls, 0 to 1.
    minutes : float
        Its duration.
    """

    run: str
    up: FloatArray
    shrinks: float
    minutes: float = 1.0


def best_pose(
    triad: Triad, runs: Sequence[PlannedRun], model: Model,
    recorded: Sequence[int] | None = None, minutes: Sequence[float] | None = None,
) -> BestPose | None:
    """The pose that adds the most information per minute (D-optimal).

    Parameters
    ----------
    triad : str
        ``accelerometer`` or ``gyroscope``.
    runs : sequence of PlannedRun
        The plan, at least one run.
    model : Model
        The model to be fitted.
    recorded : sequence of int, optional
        How many poses of each run are there, the first ones of it; the next one is then the best of
        the others. By default all are there, and the next is any natural direction.
    minutes : sequence of float, optional
        For a pose of each run; by default equal.

    Returns
    -------
    BestPose or None
        None where all are recorded.
    """
    more = natural_directions() if recorded is None else np.zeros((0, 3))
    later = POSE_S * np.arange(1, len(more) + 1)
    planned = [
        run.turned(np.vstack([run.up, more]), np.append(run.time_s, run.time_s.max() + later))
        for run in runs]
    there = [len(run.up) for run in runs] if recorded is None else recorded
    ups = np.concatenate([run.up for run in planned])
    runs_of = np.repeat(np.arange(len(runs)), [len(run.up) for run in planned])
    at_hand = np.concatenate([np.arange(len(run.up)) < count
                              for run, count in zip(planned, there, strict=True)])
    candidates = np.flatnonzero(~at_hand)
    if not len(candidates):
        return None
    equations = Equations.of(ideal_poses(triad, planned), model)
    eta = np.zeros(equations.common_count)
    jacobian = equations.rows(np.zeros(model.size), eta, {}).jacobian
    pose = np.append(equations.row_pose, np.full(len(eta), -1))  # the prior rows belong to no pose
    unit, norm = unit_columns(jacobian[np.where(pose < 0, True, at_hand[pose])])
    cov = np.linalg.inv(unit.T @ unit + WEAK_PRIOR * np.eye(len(norm)))
    takes = np.ones(len(runs)) if minutes is None else np.asarray(minutes)
    gains = []
    for candidate in candidates:
        rows = jacobian[pose == candidate] / norm
        gains.append(np.linalg.slogdet(np.eye(len(rows)) + rows @ cov @ rows.T)[1])
    best = int(np.argmax(np.array(gains) / takes[runs_of[candidates]]))
    k = int(candidates[best])
    return BestPose(runs[runs_of[k]].name, ups[k], float(np.exp(-gains[best] / 2 / model.size)),
                    float(takes[runs_of[k]]))
