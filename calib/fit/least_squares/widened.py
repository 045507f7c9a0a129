"""Poses whose sds and common errors contain what a model of their effects adds to them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigh

from calib.effects.effect import Effect
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet

WANDERS = "wander of the bias "
"""Prefix of the names of the common errors that make up a wandering bias."""

FILMED = "time of the clips"
"""Name of the common error of rates that drift: that of all clips taken together. Definition."""

MODES = 32
"""Number of the strongest modes of a course, a limit of size; the rest is added to the sds."""


@dataclass(frozen=True)
class Drawn:
    """A drawn effect with its ``size`` ± ``sd``, in its unit, and its ``shape`` parameter."""

    size: float
    sd: float
    shape: float
    effect: Effect


def widened(poses: PoseSet, drawn: Sequence[Drawn]) -> PoseSet:
    """``poses`` (n) with drawn effects in their sds, as independent or as common errors."""
    sd, reference = poses.sd**2, poses.reference
    of_reference, modes = reference.sd**2, []
    for each in drawn:
        if each.size == 0:
            continue
        unit = each.effect.evaluate(poses.conditions(poses.reading))[:, :, 0]
        if each.effect.drawn == "as_noise":
            sd = sd + (each.size * unit * poses.sd) ** 2
        elif each.effect.drawn == "in_time":
            strong, rest = _courses(times_apart(poses), each.shape)
            modes.append(each.size * strong)
            sd = sd + each.size**2 * rest[:, None]
        elif each.effect.belongs_to == "bench":
            of_reference = of_reference + (each.size * unit[:, 0]) ** 2
        else:
            sd = sd + (each.size * unit) ** 2
    reference = replace(reference, sd=np.sqrt(of_reference))
    if modes:
        course = np.concatenate(modes, axis=1)  # (n, m)
        names = tuple(f"{WANDERS}{k + 1}" for k in range(3 * course.shape[1]))
        on_vector = np.einsum("ki,nm->nkim", np.eye(3), course).reshape(len(poses), 3, -1)
        before = np.zeros((len(poses), 3, reference.common.shape[1]))
        reference = replace(
            reference,
            common=np.hstack([reference.common, np.zeros((len(poses), len(names)))]),
            common_names=(*reference.common_names, *names),
            on_vector=np.concatenate([before, on_vector], axis=2))
    return replace(poses, sd=np.sqrt(sd), reference=reference, stated=poses)


def undated(poses: PoseSet, drift_per_s: float, relative_misfit: float = 0.0) -> PoseSet:
    """``poses`` with stated rates that were measured at any time while they turned.

    A rate that drifts by ``drift_per_s``, relative to itself, was then another one: the time has a
    uniform distribution (JCGM 100, 4.3.7). Clips of several settings were all taken at one time or
    each at its own: one error is common to all, another to the poses of each setting. What these
    left of the rates, ``relative_misfit``, hides how much they drift.
    """
    reference, (first, last) = poses.reference, poses.turning_s
    drawn, shared = reference.on_vector, poses.shares_rate
    sd = np.hypot(drift_per_s * (last - first) / np.sqrt(12), relative_misfit) * reference.magnitude
    of_setting = np.array([name in reference.of_setting for name in reference.common_names], bool)
    shown = of_setting & (reference.common != 0)
    each = np.where(shown & (of_setting.sum() > 1), sd[:, None], 0.0)
    reference = replace(
        reference, common=np.column_stack([
            np.hypot(reference.common, each), np.where(shared, sd, 0.0)]),
        common_names=(*reference.common_names, FILMED),
        on_vector=None if drawn is None else np.pad(drawn, ((0, 0), (0, 0), (0, 1))))
    return replace(poses, reference=reference, stated=poses.as_stated)


def _courses(apart_s: FloatArray, tau_s: float) -> tuple[FloatArray, FloatArray]:
    """The strongest modes (n, m) of a course of unit variance, and the variance (n,) they lack."""
    kernel = np.exp(-apart_s / tau_s)
    first = max(len(kernel) - MODES, 0)
    values, vectors = eigh(kernel, subset_by_index=(first, len(kernel) - 1))
    strong = vectors * np.sqrt(np.maximum(values, 0.0))
    return strong, np.maximum(1 - (strong**2).sum(axis=1), 0.0)


def times_apart(poses: PoseSet) -> FloatArray:
    """Times between each pair of poses, SI, (n, n); infinite in runs without a common clock.

    If not even the order within a run is known, all of them are infinite.
    """
    if np.isfinite(poses.time_s).all():
        return np.asarray(np.abs(poses.time_s[:, None] - poses.time_s))
    never = np.full((len(poses), len(poses)), np.inf)
    if poses.run_time_s is None or not np.isfinite(poses.run_time_s).all():
        return never
    run = np.array(poses.run)
    within = np.abs(poses.run_time_s[:, None] - poses.run_time_s)
    return np.asarray(np.where(run[:, None] == run, within, never))
