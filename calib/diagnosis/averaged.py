"""Covariance of the parameters, averaged over the sets that a search leaves credible.

Whether a bias wanders, a pose is bad or an effect is missing is not known but weighed. With P the
probability of a set, C its columns of unit size, b their sizes and V the variance of the noise,

    cov = Σ P (V cov_noise + A <b bᵀ> Aᵀ),    A = (JᵀJ)⁻¹ Jᵀ C
    <b bᵀ> = m mᵀ + V G,   G = (XᵀX + tau⁻²)⁻¹,   m = G Xᵀ r

with X what the model leaves of C and r the residual: what the parameters hold of it, as far as the
rows and its prior tell. It is exact for a linear model and has no level at which it sets in.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.diagnosis.hypotheses.listed import Course, Hypothesis
from calib.diagnosis.search.posterior import Posterior
from calib.diagnosis.search.table_at import whole_unit_columns
from calib.fit.least_squares.result import Fit
from calib.poses.imu_log import FloatArray


@dataclass(frozen=True, eq=False)
class Averaged:
    """Components of the sds of the parameters.

    Attributes
    ----------
    factor : float
        Of the variance of the noise.
    held : array, shape (p, p)
        Mean of the products, SI, of what theta holds of errors that the model lacks.
    unlisted : array, shape (p, p)
        The same of those that are no listed effect.
    """

    factor: float
    held: FloatArray
    unlisted: FloatArray


def averaged(posterior: Posterior) -> Averaged:
    """The averages over all credible sets of a search, SI.

    Parameters
    ----------
    posterior : Posterior

    Returns
    -------
    Averaged
    """
    fit, p = posterior.base, posterior.base.model.size
    total = posterior.nothing + posterior.noise
    factor = total * float(posterior.table.noise.expected_variance(fit.bounded_chi2))
    held, unlisted = np.zeros((2, p, p))
    some = [entry for entry in posterior.credible
            if entry.members and posterior.table.seen[list(entry.members)].all()]
    blocks = _blocks(posterior, sorted({j for entry in some for j in entry.members}))
    sizes = posterior.table.likeliest_sizes([entry.members for entry in some])
    for entry, taus in zip(some, sizes, strict=True):
        mass = posterior.mass(entry)
        variance, of_all, of_unlisted = _held(posterior, [blocks[j] for j in entry.members], taus)
        total += mass
        factor += mass * variance
        held += mass * of_all
        unlisted += mass * of_unlisted
    return Averaged(factor / total, held / total, unlisted / total)


@dataclass(frozen=True, eq=False)
class _Shown:
    """The columns of one hypothesis of unit size: their ``visible`` part (c, r), the part that
    theta takes up, ``absorbed`` (p, c), and whether it is a listed effect.
    """

    visible: FloatArray
    absorbed: FloatArray
    is_listed: bool


def _blocks(posterior: Posterior, which: Sequence[int]) -> dict[int, _Shown]:
    """The columns of the hypotheses ``which``, by their index."""
    fit, model = posterior.base, posterior.table.projector.model
    hypotheses = [_about_mean(posterior.hypotheses[j]) for j in which]
    columns = whole_unit_columns(fit, hypotheses, posterior.table.projector)
    return {j: _Shown(columns[i] - (columns[i] @ model) @ model.T, _absorbed(fit, columns[i]),
                      h.course is None)
            for i, (j, h) in enumerate(zip(which, hypotheses, strict=True))}


def _held(
    posterior: Posterior, members: Sequence[_Shown], sizes: FloatArray
) -> tuple[float, FloatArray, FloatArray]:
    """Variance of the noise under a set, and what the parameters hold of its members, (p, p).

    The latter for all members, of these ``sizes`` (k,), and for those that are not listed.
    """
    table, count = posterior.table, [len(each.visible) for each in members]
    tau = np.repeat(sizes, count)
    visible = np.concatenate([each.visible for each in members])
    inverse = np.linalg.inv(visible @ visible.T + np.diag(tau**-2.0))
    score = visible @ table.residual
    size = inverse @ score
    variance = float(
        table.noise.expected_variance(table.chi2 - float(score @ size), table.chi2))
    moment = np.outer(size, size) + variance * inverse
    absorbed = np.concatenate([each.absorbed for each in members], axis=1)
    rest = absorbed * ~np.repeat([each.is_listed for each in members], count)
    return variance, absorbed @ moment @ absorbed.T, rest @ moment @ rest.T


def _about_mean(h: Hypothesis) -> Hypothesis:
    """A course in time about its mean: the bias of a session is its own mean bias."""
    if h.course is None or not (h.in_catalogue and h.is_course):
        return h
    return replace(h, course=Course(h.course.values - h.course.values.mean(axis=0)))


def _absorbed(fit: Fit, columns: FloatArray) -> FloatArray:
    """Change of theta due to signals in the rows, whitened, (c, r), per unit of each: (p, c)."""
    root = np.sqrt(fit.weight)[:, None]
    jacobian = fit.rows.jacobian @ fit.directions * root
    solution = np.linalg.lstsq(jacobian, columns.T, rcond=None)[0]
    return np.asarray((fit.directions @ solution)[: fit.model.size])
