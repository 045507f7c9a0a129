"""Covariance of the parameters, averaged over the sets that a search leaves credible.

Whether a bias wanders, a pose is bad or an effect is missing is not known but weighed. With P the
probability of a set, C its columns of unit size, b their sizes and V the variance of the noise,

    cov = Σ P (V cov_noise + A <b bᵀ> Aᵀ),    A = (JᵀJ)⁻¹ Jᵀ C
    <b bᵀ> = m mᵀ + V G,   G = (XᵀX + tau⁻²)⁻¹,   m = G Xᵀ r

with X what the model leaves of C and r the residual: what the parameters hold of it, as far as the
rows and its prior tell. It is exact for a linear model and has no level at which it sets in.

What of C b the rows show, spread over the degrees of freedom, is what new rows err by if it goes on
in them in whatever form.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.diagnosis.hypotheses.listed import Course, Hypothesis
from calib.diagnosis.hypotheses.signature import at_expected_readings
from calib.diagnosis.search.posterior import Posterior
from calib.diagnosis.search.table_at import whole_unit_columns
from calib.effects.effect import Effect
from calib.fit.least_squares.result import Fit
from calib.poses.imu_log import FloatArray


@dataclass(frozen=True, eq=False)
class GoesOn:
    """An effect that may be missing and that other readings of the sensor may have too.

    Attributes
    ----------
    effect : Effect or None
        None of an unknown function, and of a bias with a course in time.
    shape : float or None
        Value of its shape parameter.
    moment : array, shape (k, k)
        Mean of the products of its parameters, SI, times its probability.
    shown : float
        Variance of what the poses' rows show of it, waves aside, in variances of a row, times its
        probability; as large as before the fit took up a part.
    """

    effect: Effect | None
    shape: float | None
    moment: FloatArray
    shown: float


@dataclass(frozen=True, eq=False)
class Averaged:
    """Components of the sds of the parameters, and of the error of other readings.

    Attributes
    ----------
    factor : float
        Of the variance of the noise.
    held : array, shape (p, p)
        Mean of the products, SI, of what theta holds of errors that the model lacks.
    unlisted : array, shape (p, p)
        The same of those that are no listed effect.
    going_on : tuple of GoesOn
    """

    factor: float
    held: FloatArray
    unlisted: FloatArray
    going_on: tuple[GoesOn, ...]


def averaged(posterior: Posterior) -> Averaged:
    """The averages over all credible sets of a search, SI.

    Parameters
    ----------
    posterior : Posterior

    Returns
    -------
    Averaged
    """
    fit = posterior.base
    total = posterior.nothing + posterior.noise
    factor = total * float(posterior.table.noise.expected_variance(fit.bounded_chi2))
    some = [entry for entry in posterior.credible
            if entry.members and posterior.table.seen[list(entry.members)].all()]
    blocks = _columns_of(posterior, sorted({j for entry in some for j in entry.members}))
    moments = {j: np.zeros((len(block.visible),) * 2) for j, block in blocks.items()}
    held, unlisted = np.zeros((2, fit.model.size, fit.model.size))
    sizes = posterior.table.likeliest_sizes([entry.members for entry in some])
    for entry, taus in zip(some, sizes, strict=True):
        mass, members = posterior.mass(entry), [blocks[j] for j in entry.members]
        variance, moment = _moment(posterior, members, taus)
        total += mass
        factor += mass * variance
        absorbed = np.concatenate([each.absorbed for each in members], axis=1)
        owner = np.repeat(np.arange(len(members)), [len(each.visible) for each in members])
        rest = absorbed * ~np.array([each.is_listed for each in members])[owner]
        held += mass * absorbed @ moment @ absorbed.T
        unlisted += mass * rest @ moment @ rest.T
        for i, j in enumerate(entry.members):
            moments[j] += mass * moment[np.ix_(owner == i, owner == i)]
    return Averaged(factor / total, held / total, unlisted / total, tuple(
        blocks[j].goes_on(fit, moment / total) for j, moment in moments.items()
        if blocks[j].may_go_on))


@dataclass(frozen=True, eq=False)
class _Columns:
    """The c columns of one hypothesis of unit size.

    Their ``visible`` part (c, r), the part that theta takes up, ``absorbed`` (p, c), and ``unit``
    (c,), what of each parameter, SI, is one.
    """

    hypothesis: Hypothesis
    visible: FloatArray
    absorbed: FloatArray
    unit: FloatArray

    @property
    def is_listed(self) -> bool:
        """Whether it is an effect that a formula tells of any reading."""
        return self.hypothesis.course is None

    @property
    def may_go_on(self) -> bool:
        """Whether other readings of the sensor may have it too."""
        h = self.hypothesis
        return self.is_listed or h.kind == "unknown" or (h.in_catalogue and h.is_course)

    def goes_on(self, fit: Fit, moment: FloatArray) -> GoesOn:
        """What goes on, with ``moment`` (c, c) of its parameters."""
        equations = fit.equations
        rows = equations.data_count - (equations.waves.count if equations.waves else 0)
        visible = self.visible[:, :rows]
        shown = float(np.mean(((moment @ visible) * visible).sum(axis=0)))
        shown *= equations.data_count / max(fit.dof, 1)
        effect = self.hypothesis.effect if self.is_listed else None
        return GoesOn(effect, self.hypothesis.shape, moment * np.outer(self.unit, self.unit), shown)


def _columns_of(posterior: Posterior, which: Sequence[int]) -> dict[int, _Columns]:
    """The columns of the hypotheses ``which``, by their index."""
    fit, model = at_expected_readings(posterior.base), posterior.table.projector.model
    shapes = _fitted_shapes(posterior)
    hypotheses = [replace(_about_mean(h), shape=shapes.get(j, h.shape))
                  for j, h in ((j, posterior.hypotheses[j]) for j in which)]
    columns = whole_unit_columns(fit, hypotheses, posterior.table.projector)
    return {j: _Columns(h, of_unit - (of_unit @ model) @ model.T, _absorbed(fit, of_unit), unit)
            for j, h, (of_unit, unit) in zip(
                which, hypotheses, (columns[i] for i in range(len(which))), strict=True)}


def _fitted_shapes(posterior: Posterior) -> dict[int, float]:
    """Shape parameters as the most probable refit with each hypothesis has them."""
    shapes: dict[int, float] = {}
    for entry in posterior.ordered:
        if entry.refit is not None:
            of_names = entry.refit.fit.shapes
            shapes |= {j: of_names[name] for j in entry.members
                       if j not in shapes and (name := posterior.hypotheses[j].name) in of_names}
    return shapes


def _moment(
    posterior: Posterior, members: Sequence[_Columns], sizes: FloatArray
) -> tuple[float, FloatArray]:
    """Variance of the noise under a set, and mean of the products of the sizes of its columns.

    The latter (c, c) for members of these ``sizes`` (k,).
    """
    table = posterior.table
    tau = np.repeat(sizes, [len(each.visible) for each in members])
    visible = np.concatenate([each.visible for each in members])
    inverse = np.linalg.inv(visible @ visible.T + np.diag(tau**-2.0))
    score = visible @ table.residual
    size = inverse @ score
    variance = float(
        table.noise.expected_variance(table.chi2 - float(score @ size), table.chi2))
    return variance, np.outer(size, size) + variance * inverse


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
