"""Probability that a block of poses gives a name to an open question, by simulation.

Each rival in turn is what there is, of the size that it is believed to have. Noise of unit sd is
drawn over all rows, those recorded and those to come, and nothing and the rivals, as likely as
each other beforehand, are weighed by the evidence of the search
(:mod:`calib.diagnosis.search.evidence`). Named is what then has the probability of a name while no
rival is left in its class: none is probable, and what looks the same is refuted.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.signature import (
    Projector,
    Signature,
    are_aliases,
    whole_columns,
)
from calib.diagnosis.next_measurement.pose_blocks import CLIPS
from calib.diagnosis.search.evidence import block_log_densities
from calib.effects.effect import Effect
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.unknown_sd import noise_of
from calib.fit.noise_size import Noise
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import BoolArray, FloatArray

DRAWS = 400  #: simulated sessions of all rivals; numerical: a chance is known to 2.5 %
BLIND_SIGNAL_SD = 5.0
"""Strength at which an effect that left no trace yet is judged, noise units over the rows.
Derived: from there on an effect is seen in nearly every session."""


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

    def columns(self, fit: Fit) -> FloatArray:
        """Whitened columns (d, k); a pose that is filmed has the rate that the plate has."""
        columns = whole_columns(fit, self.effect, self.shape)
        if self.effect.acts_on == "reference":
            run = np.array(fit.poses.run)[fit.equations.row_pose]
            columns = np.where(run[:, None] == CLIPS.code, 0.0, columns)
        return columns

    @property
    def in_all_shapes(self) -> "list[Rival]":
        """The rival with every shape that could replace another: a slow warm-up is a drift."""
        shape = self.effect.shape
        if shape is None:
            return [self]
        return [replace(self, shape=value) for value in (*shape.starts, shape.bounds[1])]


def chance_of_a_name(then: Fit, rivals: Sequence[Rival]) -> float:
    """Share of simulated sessions in which the true rival gets a name.

    Parameters
    ----------
    then : Fit
        The fit as it would stand with the block recorded.
    rivals : sequence of Rival
        At least one, each as likely to be what there is.
    """
    projector = Projector(then)
    shapes = [[projector.signature(each.effect.name, each.columns(then))
               for each in rival.in_all_shapes] for rival in rivals]

    def signals(i: int, count: int, random: np.random.Generator) -> FloatArray:
        full = np.zeros((count, len(projector.residual)))
        full[:, : then.equations.data_count] = _signals(rivals[i], then, count, random)
        return full

    return share_named(projector, noise_of(then, projector.dof), shapes, signals,
                       np.array([[any(are_aliases(x, y) for x in a for y in b) for b in shapes]
                                 for a in shapes]))


def share_named(
    projector: Projector,
    noise: Noise,
    shapes: Sequence[Sequence[Signature]],
    signals: Callable[[int, int, np.random.Generator], FloatArray],
    look_alike: BoolArray,
) -> float:
    """Share of simulated sessions in which the true rival gets a name.

    Parameters
    ----------
    projector : Projector
    noise : Noise
    shapes : sequence of sequence of Signature
        What each of k rivals may leave, each of its shapes as likely; one without any is never
        there.
    signals : callable
        What rival i leaves in the whitened rows of so many sessions, (count, r), drawn at random.
    look_alike : array of bool, shape (k, k)
        Rivals that leave the same: one is refuted before another has the name.
    """
    random = np.random.default_rng(0)
    there = [i for i, signatures in enumerate(shapes) if signatures]
    if not there:
        return 0.0
    count = -(-DRAWS // len(there))
    rows = np.concatenate([random.normal(size=(count, len(projector.residual)))
                           + signals(i, count, random) for i in there])
    rows -= (rows @ projector.model) @ projector.model.T
    chi2 = (rows**2).sum(axis=1)
    density = np.full((len(shapes) + 1, len(rows)), -np.inf)
    density[-1] = np.logaddexp(*noise.log_density(chi2, 0.0, chi2))
    for i in there:
        density[i] = np.logaddexp.reduce([
            _density(each, rows, chi2, noise) for each in shapes[i]]) - np.log(len(shapes[i]))
    probability = density - np.logaddexp.reduce(density)
    named = 0.0
    for place, i in enumerate(there):
        mine = slice(place * count, (place + 1) * count)
        others = np.arange(len(shapes)) != i
        refuted = probability[:-1, mine] < np.log(CONSTANTS.least_listed)
        behind = density[:-1, mine] < density[i, mine] - CONSTANTS.negligible
        refuted &= behind | ~look_alike[i, :, None]
        is_named = (probability[i, mine] >= np.log(CONSTANTS.sure)) & refuted[others].all(axis=0)
        named += float(np.mean(is_named))
    return named / len(shapes)


def random_signals(columns: FloatArray, count: int, random: np.random.Generator) -> FloatArray:
    """Signals (count, d), in sds, of an effect of unknown size, of ``BLIND_SIGNAL_SD`` rms.

    ``columns`` (d, k) are its own, each parameter as strong as the next.
    """
    norm = np.maximum(np.sqrt((columns**2).sum(axis=0)), NO_LENGTH)
    way = random.normal(size=(count, columns.shape[1])) / np.sqrt(columns.shape[1])
    unit: FloatArray = columns / norm * np.sqrt(len(columns)) * BLIND_SIGNAL_SD
    return np.asarray(way @ unit.T)


def _signals(rival: Rival, then: Fit, count: int, random: np.random.Generator) -> FloatArray:
    """Signals of a rival in the data rows of every simulated session, (count, d)."""
    columns = rival.columns(then)
    if rival.size is None:
        return random_signals(columns, count, random)
    return np.tile(columns @ rival.size, (count, 1))


def _density(
    signature: Signature, rows: FloatArray, chi2: FloatArray, noise: Noise
) -> FloatArray:
    """Log densities (draws,) of residuals ``rows`` (draws, r) under an effect."""
    if signature.is_blind:
        return np.full(len(rows), -np.inf)
    return block_log_densities(signature.strength[None], rows @ signature.basis, chi2, noise)
