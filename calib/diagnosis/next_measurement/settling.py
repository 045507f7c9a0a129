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
from calib.diagnosis.next_measurement.chance import share_named
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
    sized = [*_at(posterior, then, names)]
    table = table_at(then, [h for h, _ in sized])
    of: dict[str, list[int]] = {h.name: [] for h, _ in sized}
    for j, (h, _) in enumerate(sized):
        of[h.name] += [] if table.is_blind(j) else [j]
    if not of:
        return None
    places = [*of.values()]

    def signals(i: int, count: int, random: np.random.Generator) -> FloatArray:
        x = table.rows[table.where(places[i][0])]
        _, size = sized[places[i][0]]
        return np.asarray(size * random.normal(size=(count, len(x))) @ x)

    return share_named(table.projector, table.noise,
                       [[table.signature(j) for j in some] for some in places], signals,
                       np.zeros((len(places), len(places)), bool))


def _at(
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
