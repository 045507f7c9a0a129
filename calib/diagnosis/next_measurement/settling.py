"""How likely a block of poses names what has no size of its own: a step, a wander, a bad pose.

As in :mod:`calib.diagnosis.next_measurement.chance`, but by the hypotheses of the search. Each
that is open is in turn what there is, drawn anew in every simulated session along its columns, as
strong as the misfit that it takes now; it is weighed against nothing, noise and the others by the
table of the poses recorded and to come.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.columns import causes
from calib.diagnosis.hypotheses.courses import by_clock, scattering_rates
from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.hypotheses.unlisted import unknown_hypotheses
from calib.diagnosis.next_measurement.advice import Advice
from calib.diagnosis.next_measurement.chance import DRAWS, share_named
from calib.diagnosis.next_measurement.pose_blocks import hypothetical
from calib.diagnosis.search.posterior import Posterior
from calib.diagnosis.search.table_at import table_at
from calib.fit.least_squares.result import Fit
from calib.poses.imu_log import FloatArray

MOST_OF_EACH = 8  #: times, poses or shapes of one name, the likeliest; a limit of time


def settling_block(
    posterior: Posterior, names: Sequence[str], full_scale: float = np.inf
) -> Advice | None:
    """The block after which one of ``names`` is known most often, the shorter of those that do.

    Parameters
    ----------
    posterior : Posterior
    names : sequence of str
        Of the hypotheses that are open.
    full_scale : float
        Of the triad, SI.

    Returns
    -------
    Advice or None
        None where no block is to be had, or nothing of ``names`` has columns.
    """
    options = []
    for block, then in hypothetical(posterior.base, full_scale):
        chance = _chance(posterior, then, names)
        if chance is not None:
            options.append(Advice(block.code, block.instruction, 0.0, block.minutes, chance))
            if chance >= CONSTANTS.sure:
                break
    return max(options, default=None, key=lambda each: (each.chance or 0.0, -each.minutes))


def _chance(posterior: Posterior, then: Fit, names: Sequence[str]) -> float | None:
    """Share of simulated sessions in which what is there has a name at ``then``."""
    again = [*_at(posterior, then, names)]
    table = table_at(then, again)
    of = {name: [j for j, h in enumerate(again) if h.name == name and not table.is_blind(j)]
          for name in dict.fromkeys(h.name for h in again)}
    if not of:
        return None
    places = [*of.values()]

    def signals(i: int, random: np.random.Generator) -> FloatArray:
        x = table.rows[table.where(places[i][0])]
        size = _size(posterior, again[places[i][0]])
        return np.asarray(size * random.normal(size=(DRAWS, len(x))) @ x)

    return share_named(table.projector, table.noise,
                       [[table.signature(j) for j in some] for some in places], signals,
                       np.zeros((len(places), len(places)), bool))


def _at(posterior: Posterior, then: Fit, names: Sequence[str]) -> Iterator[Hypothesis]:
    """The likeliest hypotheses of ``names``, as they are over the poses of ``then``."""
    order = np.argsort(-posterior.log_factor)
    every = [posterior.hypotheses[j] for j in order]
    with_course = [*by_clock(then), *scattering_rates(then)]
    if any(h.follows is not None for h in every if h.name in names):
        with_course += unknown_hypotheses(then, causes(then.poses))
    course = {(h.name, h.detail): h for h in reversed(with_course)}
    for name in names:
        same = dict.fromkeys((h.name, h.detail, h.shape) for h in every if h.name == name)
        for _, detail, shape in [*same][:MOST_OF_EACH]:
            first = next(h for h in every if (h.name, h.detail, h.shape) == (name, detail, shape))
            if first.course is None:
                yield first
            elif (name, detail) in course:
                yield course[name, detail]


def _size(posterior: Posterior, hypothesis: Hypothesis) -> float:
    """Units of the table by which it takes the misfit that it takes in the poses recorded."""
    j = next(j for j in np.argsort(-posterior.log_factor)
             if posterior.hypotheses[j].name == hypothesis.name
             and posterior.hypotheses[j].detail == hypothesis.detail)
    seen = max(int(posterior.table.seen[j]), 1)
    squared = float((posterior.table.rows[posterior.table.where(int(j))] ** 2).sum())
    fall = max(float(posterior.drop[j]) - seen, seen)
    return float(np.sqrt(fall / squared)) if squared else 0.0

