"""The evidence of every candidate at many fits: :mod:`calib.diagnosis.population.evidence` stacked.

Effects are row by row by law, so that one call evaluates them on the poses of all sets; what is
done with the columns is what is done for one fit, with a leading axis.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from calib.diagnosis.hypotheses.listed import effects_beside
from calib.diagnosis.population.evidence import trials_of
from calib.diagnosis.population.lot import LotEvidence
from calib.diagnosis.population.stacked_conditions import StackedConditions
from calib.effects.effect import Effect
from calib.effects.variation import about_mean
from calib.fit.batch.fit_many import FittedStack, ManyFits
from calib.fit.column_scaling import NORM_FLOOR
from calib.fit.least_squares.identifiability import ROUNDING, VISIBLE_SHARE
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet


def evidence_many(
    fits: ManyFits, sets: Sequence[PoseSet], names: Sequence[str]
) -> Iterator[LotEvidence]:
    """The evidence of every candidate at every fit.

    Parameters
    ----------
    fits : ManyFits
    sets : sequence of PoseSet
        Those that were fitted, all of one triad and with the same logged columns.
    names : sequence of str
        Which sensor each is of.

    Yields
    ------
    LotEvidence
        Of one stack of fits; refused sets are in none.
    """
    for stack in fits.stacks:
        if len(stack):
            of_stack = [sets[i] for i in stack.index]
            yield _of_stack(stack, of_stack, fits, tuple(names[i] for i in stack.index))


def _of_stack(
    stack: FittedStack, sets: Sequence[PoseSet], fits: ManyFits, names: tuple[str, ...]
) -> LotEvidence:
    at = StackedConditions.of(stack, sets, fits.model)
    basis, _ = np.linalg.qr(stack.rows.jacobian)
    residual = stack.rows.residual[..., None]
    residual = residual - basis @ (np.swapaxes(basis, 1, 2) @ residual)
    trials, visible = [], [np.zeros((*stack.rows.residual.shape, 0))]
    for effect in effects_beside(fits.model, sets[0]):
        if effect.in_square:
            continue
        for trial in trials_of(effect, sets[0].triad):
            columns = _columns(stack, at, effect, trial.shape, fits)
            visible.append(_visible(columns, basis, stack.equations.stack.data_count))
            trials.append(trial)
    x = np.concatenate(visible, axis=2)
    information = np.swapaxes(x, 1, 2) @ x
    return LotEvidence(
        sensors=names,
        trials=tuple(trials),
        score=(np.swapaxes(x, 1, 2) @ residual)[..., 0],
        information=information,
        whole=np.einsum("skk->sk", information).copy(),
        chi2=(residual[..., 0] ** 2).sum(axis=1),
        dof=np.full(len(stack), float(stack.dof)),
        noise_dof=np.array([poses.noise_dof for poses in sets]),
    )


def _columns(
    stack: FittedStack, at: StackedConditions, effect: Effect, shape: float | None, fits: ManyFits
) -> FloatArray:
    """Whitened columns (S, d, k) of an effect; zero where a set cannot evaluate it."""
    equations, vector = stack.equations, stack.rows.vector
    sets, n, _ = vector.shape
    k = equations.stack.turning
    if effect.acts_on == "reference":
        varying = about_mean(effect, fits.model.names, sets)
        flat = varying.evaluate(at.reading, shape).reshape(sets, n, -1)[:, :k]
        rows = np.zeros((sets, equations.stack.data_count, flat.shape[2]))
        rows[:, :k] = flat / equations.magnitude_sd[..., None]
    else:
        vectors = _vectors(at, effect, shape, sets, fits.model.names)
        rows = equations.whitened(vectors, vector)
        sds = np.concatenate([equations.magnitude_sd, equations.null_sd.reshape(sets, -1)], axis=1)
        whole = np.sqrt((vectors**2).sum(axis=(1, 2))) / np.median(sds, axis=1)[:, None]
        small = np.sqrt((rows**2).sum(axis=1)) < ROUNDING * whole
        rows = np.where(small[:, None, :], 0.0, rows)
    complete = np.asarray(np.isfinite(rows).all(axis=(1, 2)))
    return np.asarray(np.where(complete[:, None, None], rows, 0.0))


def _vectors(
    at: StackedConditions, effect: Effect, shape: float | None, sets: int, fitted: Sequence[str]
) -> FloatArray:
    """Errors (S, n, 3, k) of an effect on the reading or the sensor."""
    where = at.vector if effect.orthogonal else at.sensed
    if effect.acts_on == "reading":
        where = at.reading
    flat = about_mean(effect, fitted, sets).evaluate(where, shape)
    vectors = flat.reshape(sets, len(flat) // sets, 3, -1)
    if effect.orthogonal or effect.acts_on == "reading":
        return vectors
    return np.asarray(at.to_orthogonal[:, None] @ vectors)


def _visible(columns: FloatArray, basis: FloatArray, data_count: int) -> FloatArray:
    """What of whitened columns (S, d, k) the poses can see beside the model, (S, r, k)."""
    sets, d, k = columns.shape
    full = np.zeros((sets, basis.shape[1], k))
    full[:, :d] = columns
    norm = np.sqrt(np.einsum("srk,srk->sk", full, full))
    used = norm > NORM_FLOOR * np.maximum(norm.max(axis=1, keepdims=True), NO_LENGTH)
    unit = np.where(used[:, None, :], full / np.where(used, norm, 1.0)[:, None, :], 0.0)
    rest = unit - basis @ (np.swapaxes(basis, 1, 2) @ unit)
    values, vectors = np.linalg.eigh(np.swapaxes(rest, 1, 2) @ rest)
    seen = vectors * (values > VISIBLE_SHARE**2)[:, None, :]
    return np.asarray(rest @ (seen @ np.swapaxes(seen, 1, 2)) * np.where(used, norm, 0.0)[:, None])
