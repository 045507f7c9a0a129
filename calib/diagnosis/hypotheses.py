"""Everything that could be missing: the hypotheses that a diagnosis weighs.

Listed effects with their own columns; errors of unknown form that follow a logged column, time,
the plate's rate or the attitude; a jump, one bad pose, and noise larger than stated.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np

from calib.diagnosis.evidence import (
    LISTED_TOLERANCE,
    UNKNOWN_TOLERANCE,
    log_evidences,
    log_mean_exp,
    scatter_evidence,
    signature_evidence,
)
from calib.diagnosis.signature import Projector, Signature, effect_columns, project_on_rows
from calib.effects.effect import EFFECTS, Effect, column_effect
from calib.fit.leave_one_out import pose_blocks
from calib.fit.model import unavailable
from calib.fit.result import Fit
from calib.poses.imu_log import FloatArray

TIME_WAVES, COLUMN_WAVES = 8, 5
JUMPS_TRIED = 16
LEAST_LEFT = 1e-6
"""Floor of what a pose keeps for itself after the fit; one that keeps nothing shows nothing."""
JUMP_MARGIN = 3
OWN_EFFECT_OF = {"temperature_c": "temperature_bias"}
"""Logged columns whose linear effect on the bias has a name of its own."""


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A hypothesis with its evidence against "nothing is missing".

    ``kind``: listed, unknown, jump, bad_pose or noise. ``shape`` is the best of the shape values
    tried. ``detail`` names the pose of a jump or a bad pose. ``after`` is the joint refit with the
    effect added, where one was made.
    """

    name: str
    kind: str
    log_evidence: float
    signature: Signature | None = None
    effect: Effect | None = None
    shape: float | None = None
    detail: str = ""
    after: Fit | None = None


def candidate_effects(fit: Fit, own: Sequence[Effect] = ()) -> Iterator[Effect]:
    """Effects that could be added to the model of ``fit``: listed, logged columns, the user's."""
    in_model = set(fit.model.names)
    listed = [e for e in EFFECTS.values() if e.acts_on != "reading"]
    columns = [column_effect(name) for name in fit.poses.columns if name not in OWN_EFFECT_OF]
    for effect in (*listed, *columns, *own):
        if effect.name not in in_model and fit.poses.triad in effect.triads:
            yield effect


def listed_hypothesis(fit: Fit, projector: Projector, effect: Effect) -> Hypothesis:
    """The evidence for one listed effect, averaged over the starts of its shape parameter."""
    shapes: tuple[float | None, ...] = effect.shape.starts if effect.shape else (None,)
    tried = [
        (shape, projector.signature(effect.name, effect_columns(fit, effect, shape)))
        for shape in shapes
    ]
    seen = [(shape, signature) for shape, signature in tried if not signature.is_blind]
    if not seen:
        return Hypothesis(effect.name, "listed", -np.inf, tried[0][1], effect)
    evidence = [
        signature_evidence(signature, projector.residual, projector.dof, LISTED_TOLERANCE)
        for _, signature in seen
    ]
    shape, signature = seen[int(np.argmax(evidence))]
    return Hypothesis(effect.name, "listed", log_mean_exp(evidence), signature, effect, shape)


def waves(covariate: FloatArray, count: int) -> FloatArray:
    """Smooth unknown functions of a covariate, (n, count): cosines of its rank, damped."""
    rank = np.argsort(np.argsort(covariate, kind="stable"), kind="stable") / len(covariate)
    k = np.arange(1, count + 1)
    return np.asarray(np.cos(np.pi * rank[:, None] * k) * np.exp(-k / (0.8 * count)))


def _unknown_columns(fit: Fit) -> Iterator[tuple[str, FloatArray]]:
    """Columns (d, k) of unknown functions: of each covariate, on the size and on the bias."""
    poses, s = fit.poses, fit.rows.vector
    covariates = {"time_s": poses.time_s, "spin_rad_s": poses.spin_rad_s, **poses.columns}
    for name, values in covariates.items():
        if not np.isfinite(values).all() or np.ptp(values) == 0:
            continue
        shapes = waves(values, TIME_WAVES if name == "time_s" else COLUMN_WAVES)
        size = s[:, :, None] / np.linalg.norm(s, axis=1)[:, None, None] * shapes[:, None, :]
        size[fit.equations.null] = 0.0
        yield name, project_on_rows(fit, size)
        bias = np.einsum("ij,nk->nijk", np.eye(3), shapes).reshape(len(s), 3, -1)
        yield name, project_on_rows(fit, bias)
    yield "attitude", _attitude_columns(fit)


def _attitude_columns(fit: Fit) -> FloatArray:
    """Cubic and quartic functions of the direction: the first that the nine parameters lack."""
    s = fit.rows.vector
    n = s / np.linalg.norm(s, axis=1, keepdims=True)
    products = [n[:, list(c)].prod(axis=1) for c in combinations_with_replacement(range(3), 3)]
    products += [(n[:, i] * n[:, j]) ** 2 for i, j in combinations_with_replacement(range(3), 2)]
    size = n[:, :, None] * np.stack(products, axis=1)[:, None, :]
    size[fit.equations.null] = 0.0
    return project_on_rows(fit, size)


def unknown_hypotheses(fit: Fit, projector: Projector) -> list[Hypothesis]:
    """One hypothesis per covariate, the better of its two forms."""
    best: dict[str, Hypothesis] = {}
    for name, columns in _unknown_columns(fit):
        signature = projector.signature(name, columns)
        if signature.is_blind:
            continue
        evidence = signature_evidence(
            signature, projector.residual, projector.dof, UNKNOWN_TOLERANCE
        )
        if name not in best or evidence > best[name].log_evidence:
            best[name] = Hypothesis(name, "unknown", evidence, signature)
    return list(best.values())


def jump_hypothesis(fit: Fit, projector: Projector) -> Hypothesis | None:
    """A bias that jumps once, averaged over when."""
    poses = fit.poses
    if not np.isfinite(poses.time_s).all() or len(poses) < 2 * JUMP_MARGIN + 1:
        return None
    order = np.argsort(poses.time_s, kind="stable")
    last = len(poses) - JUMP_MARGIN
    tried = np.unique(np.linspace(JUMP_MARGIN, last, JUMPS_TRIED).astype(int))
    found: list[tuple[float, int, Signature]] = []
    for k in tried:
        after = np.zeros(len(poses))
        after[order[k:]] = 1.0
        columns = project_on_rows(fit, after[:, None, None] * np.eye(3))
        signature = projector.signature("jump", columns)
        if not signature.is_blind:
            evidence = signature_evidence(
                signature, projector.residual, projector.dof, LISTED_TOLERANCE
            )
            found.append((evidence, int(k), signature))
    if not found:
        return None
    _, k, signature = max(found, key=lambda item: item[0])
    evidence = log_mean_exp([item[0] for item in found])
    return Hypothesis("jump", "jump", evidence, signature, detail=poses.label[order[k]])


def bad_pose_hypothesis(fit: Fit, projector: Projector) -> Hypothesis | None:
    """One pose that has nothing to do with the others, averaged over which."""
    residual, pose = projector.residual, fit.equations.row_pose
    chi2 = float(residual @ residual)
    found: list[tuple[float, int]] = []
    for rows, block in pose_blocks(projector.model, pose):
        values, vectors = np.linalg.eigh(block)
        left = np.sqrt(np.maximum(values, LEAST_LEFT))
        amplitude = np.einsum("mji,mj->mi", vectors, residual[rows]) / left
        strength = left * np.sqrt(projector.data_count / rows.shape[1])
        each = log_evidences(strength, amplitude, chi2)
        found += [(float(e), int(pose[r])) for e, r in zip(each, rows[:, 0], strict=True)]
    if not found:
        return None
    _, k = max(found)
    evidence = log_mean_exp([item[0] for item in found])
    return Hypothesis("bad_pose", "bad_pose", evidence, detail=fit.poses.label[k])


def noise_hypothesis(projector: Projector) -> Hypothesis:
    """Noise larger than stated, the same for every row."""
    chi2 = float(projector.residual @ projector.residual)
    return Hypothesis("noise", "noise", scatter_evidence(chi2, projector.dof))


@dataclass(frozen=True, eq=False)
class Weighed:
    """All hypotheses of one fit; ``unavailable`` says why an effect could not be evaluated."""

    listed: tuple[Hypothesis, ...]
    unknown: tuple[Hypothesis, ...]
    general: tuple[Hypothesis, ...]
    blind: tuple[str, ...]
    unavailable: dict[str, str]


def weigh(fit: Fit, projector: Projector, own: Sequence[Effect] = ()) -> Weighed:
    """Weigh every hypothesis against "nothing is missing"."""
    listed, blind, absent = [], [], {}
    for effect in candidate_effects(fit, own):
        reason = unavailable(effect, fit.poses)
        if reason is not None:
            absent[effect.name] = reason
            continue
        hypothesis = listed_hypothesis(fit, projector, effect)
        if hypothesis.signature is not None and hypothesis.signature.is_blind:
            blind.append(effect.name)
        else:
            listed.append(hypothesis)
    general = [
        jump_hypothesis(fit, projector),
        bad_pose_hypothesis(fit, projector),
        noise_hypothesis(projector),
    ]
    return Weighed(
        tuple(listed),
        tuple(unknown_hypotheses(fit, projector)),
        tuple(h for h in general if h is not None),
        tuple(blind),
        absent,
    )
