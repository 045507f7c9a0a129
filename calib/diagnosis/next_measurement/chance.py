"""Probability that a block of poses gives a name to an open question, by simulation.

Each rival in turn is what there is: an effect of the size that it is believed to have, or what has
no size of its own (a step, a wander, a bad pose), drawn anew along its columns as strong as the
misfit that it takes now. Noise of unit sd is drawn over all rows, those recorded and those to come,
and nothing and the rivals, as likely as each other beforehand, are weighed by the evidence of the
search (:mod:`calib.diagnosis.search.evidence`). Named is what then has the probability of a name
while no rival is left in its class: none is probable, and what looks the same is refuted.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.columns import causes
from calib.diagnosis.hypotheses.courses import by_clock, scattering_rates
from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.hypotheses.signature import Projector, Signature, are_aliases, whole_columns
from calib.diagnosis.hypotheses.unlisted import unknown_hypotheses
from calib.diagnosis.next_measurement.pose_blocks import CLIPS
from calib.diagnosis.search.evidence import block_log_densities
from calib.diagnosis.search.posterior import Posterior
from calib.diagnosis.search.table_at import table_at
from calib.effects.effect import Effect
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.unknown_sd import noise_of
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import FloatArray

DRAWS = 200  #: simulated sessions of all rivals; numerical: a chance is known to 3.5 %
BLIND_SIGNAL_SD = 5.0
"""Strength at which an effect that left no trace yet is judged, noise units over the rows.
Derived: from there on an effect is seen in nearly every session."""

MOST_OF_EACH = 4  #: times, poses or shapes of one name, the likeliest; a limit of time


@dataclass(frozen=True, eq=False)
class Rival:
    """An effect with its assumed size.

    Attributes
    ----------
    effect : Effect
    size : array, shape (k,), or None
        Its parameters, SI; None where these poses are blind to it.
    shape : float or None
        Its shape parameter, where it has one.
    """

    effect: Effect
    size: FloatArray | None
    shape: float | None = None

    def columns(self, fit: Fit, shape: float | None = None) -> FloatArray:
        """Whitened columns (d, k); a pose that is filmed has the rate that the plate has."""
        columns = whole_columns(fit, self.effect, self.shape if shape is None else shape)
        if self.effect.acts_on == "reference":
            run = np.array(fit.poses.run)[fit.equations.row_pose]
            columns = np.where(run[:, None] == CLIPS.code, 0.0, columns)
        return columns

    def at(self, then: Fit, projector: Projector) -> "RivalSignal":
        """The rival over the rows of ``then``, at every shape that could replace another.

        A slow warm-up is a drift. Without a size it goes any way, ``BLIND_SIGNAL_SD`` strong.
        """
        shape, columns = self.effect.shape, self.columns(then)
        shapes = (None,) if shape is None else (*shape.starts, shape.bounds[1])
        if self.size is None:
            norm = np.maximum(np.sqrt((columns**2).sum(axis=0)), NO_LENGTH)
            strength = BLIND_SIGNAL_SD * np.sqrt(len(columns) / columns.shape[1])
            random, fixed = strength * columns / norm, np.zeros(len(columns))
        else:
            random, fixed = np.zeros((len(columns), 0)), columns @ self.size
        return RivalSignal(
            [projector.signature(self.effect.name, self.columns(then, each)) for each in shapes],
            fixed, random)


@dataclass(frozen=True, eq=False)
class RivalSignal:
    """What one rival may leave in d rows.

    ``shapes``, each as likely, are what it is weighed by; it leaves ``fixed`` (d,) and, drawn anew
    in each session, normal multiples of the columns ``random`` (d, k), all in sds.
    """

    shapes: Sequence[Signature]
    fixed: FloatArray
    random: FloatArray


def chance_of_a_name(then: Fit, rivals: Sequence[Rival]) -> float | None:
    """Share of simulated sessions in which the true rival gets a name.

    None where the poses do not have what an effect follows.

    Parameters
    ----------
    then : Fit
        The fit as it would stand with the block recorded.
    rivals : sequence of Rival
        At least one, each as likely to be what there is.
    """
    if not all(np.isfinite(rival.columns(then)).all() for rival in rivals):
        return None
    projector = Projector(then)
    return share_named(then, projector, [rival.at(then, projector) for rival in rivals])


def chance_of_hypotheses(posterior: Posterior, then: Fit, names: Sequence[str]) -> float | None:
    """The same for the hypotheses ``names`` of a search; None where none of them has columns."""
    sized = [*_later(posterior, then, names)]
    table = table_at(then, [h for h, _ in sized])
    drawn = []
    for name in dict.fromkeys(h.name for h, _ in sized):
        places = [j for j, (h, _) in enumerate(sized) if h.name == name and not table.is_blind(j)]
        random = np.zeros((len(table.residual), 0))
        if places:
            random = sized[places[0]][1] * table.rows[table.where(places[0])].T
        shapes = [table.signature(j) for j in places]
        drawn.append(RivalSignal(shapes, np.zeros(len(random)), random))
    return share_named(then, table.projector, drawn) if drawn else None


def share_named(then: Fit, projector: Projector, rivals: Sequence[RivalSignal]) -> float:
    """Share of simulated sessions of ``then`` in which the true one of ``rivals`` gets a name."""
    random, noise = np.random.default_rng(0), noise_of(then, projector.dof)
    there = [i for i, rival in enumerate(rivals) if rival.shapes]
    if not there:
        return 0.0
    count = -(-DRAWS // len(there))
    rows = random.normal(size=(len(there), count, len(projector.residual)))
    for mine, i in zip(rows, there, strict=True):
        d, k = rivals[i].random.shape
        mine[:, :d] += rivals[i].fixed + random.normal(size=(count, k)) @ rivals[i].random.T
    rows = rows.reshape(-1, rows.shape[2])
    rows -= (rows @ projector.model) @ projector.model.T
    chi2 = (rows**2).sum(axis=1)
    density = np.full((len(rivals) + 1, len(rows)), -np.inf)
    density[-1] = np.logaddexp(*noise.log_density(chi2, 0.0, chi2))
    for i in there:
        shapes = rivals[i].shapes
        density[i] = np.logaddexp.reduce([
            block_log_densities(each.strength[None], rows @ each.basis, chi2, noise)
            if each.seen else np.full(len(rows), -np.inf) for each in shapes]) - np.log(len(shapes))
    probability = density - np.logaddexp.reduce(density)
    named = 0.0
    for place, i in enumerate(there):
        mine = slice(place * count, (place + 1) * count)
        alike = [[any(are_aliases(x, y) for x in rivals[i].shapes for y in other.shapes)]
                 for other in rivals]
        refuted = probability[:-1, mine] < np.log(CONSTANTS.least_listed)
        behind = density[:-1, mine] < density[i, mine] - CONSTANTS.negligible
        refuted &= behind | ~np.array(alike)
        is_named = (probability[i, mine] >= np.log(CONSTANTS.sure)) & np.delete(
            refuted, i, axis=0).all(axis=0)
        named += float(np.mean(is_named))
    return named / len(rivals)


def _later(
    posterior: Posterior, then: Fit, names: Sequence[str]
) -> Iterator[tuple[Hypothesis, float]]:
    """The likeliest hypotheses of ``names`` over the poses of ``then``, and their sizes.

    These are the units of the table by which they take what they take of the misfit now.
    """
    order = np.argsort(-posterior.log_factor).tolist()
    with_course = [*by_clock(then), *scattering_rates(then)]
    if any(h.follows is not None for h in posterior.hypotheses if h.name in names):
        with_course += unknown_hypotheses(then, causes(then.poses))
    course = {(h.name, h.detail): h for h in reversed(with_course)}
    for name in names:
        same: dict[tuple[str, float | None], int] = {}
        for j in order:
            h = posterior.hypotheses[j]
            if h.name == name:
                same.setdefault((h.detail, h.shape), j)
        for j in [*same.values()][:MOST_OF_EACH]:
            h = posterior.hypotheses[j]
            later = h if h.course is None else course.get((name, h.detail))
            if later is not None:
                seen, squared = max(int(posterior.table.seen[j]), 1), float(
                    (posterior.table.rows[posterior.table.where(j)] ** 2).sum())
                fall = max(float(posterior.drop[j]) - seen, seen)
                yield later, float(np.sqrt(fall / squared)) if squared else 0.0
