"""Every number that the diagnosis decides by, with where it comes from.

``fact`` is a property of the world, ``derived`` follows from the others or from a definition, and
``tuned`` was chosen on ``tests.bench.study_diagnosis`` with seeds below 1000; what is reported of
the diagnosis is counted on other seeds.
"""

from dataclasses import dataclass, field
from typing import Any


def _constant(value: Any, origin: str) -> Any:
    return field(default=value, metadata={"origin": origin})


@dataclass(frozen=True)
class Constants:
    """Priors, thresholds and sizes of the search; the metadata of each say where it comes from."""

    # What is believed before the data are seen: odds of being in the model, against not.
    prior_nothing: float = _constant(0.5, "derived: a session is as likely sound as not")
    odds_listed: float = _constant(0.7, "tuned: shared by all listed effects of the table")
    odds_unknown: float = _constant(0.18, "tuned: shared by all unknown functions")
    odds_wander: float = _constant(0.1, "fact: bias instability is on every MEMS data sheet")

    # Sizes that an effect may have, root mean square over the rows in noise units.
    typical_size: float = _constant(
        8.0, "tuned: scale of the half-Cauchy prior of sizes, sd; by the log score of the stated "
        "probabilities on 300 sessions of the paper's design (seeds 31000 to 31299) 0.670 with 8, "
        "0.687 with 4, 0.684 with 16; 0.722 with all octaves alike"
    )
    bad_pose_size: float = _constant(4.0, "derived: a pose that is off by less is no outlier")

    # What these poses can see.
    alias_correlation: float = _constant(0.99, "tuned: least canonical correlation of one class")

    # The search.
    fewest_dof: int = _constant(
        2, "tuned: fewer left explain anything; of those evenings 0.06 fewer are named with 4, "
        "which leaves cross_quadratic no name, with 1 as many as with 2"
    )
    near: float = _constant(1.0, "tuned: log odds behind the best that adding a little can make up")
    negligible: float = _constant(12.0, "derived: a set behind by so much has no share to speak of")

    # The verdict.
    sure: float = _constant(0.8, "derived: odds of 4 to 1, from which something is named")
    least_offered: float = _constant(
        0.05, "derived: an open verdict lists what holds so much, and the sets that are believed "
        "hold the rest to one"
    )
    least_listed: float = _constant(
        0.01, "derived: odds of 100 to 1; what is less likely is not reported and rivals no name"
    )
    misfit_p_value: float = _constant(1e-3, "derived: one session in a thousand")
    told_apart: float = _constant(
        3.0, "derived: log of 20 to 1, from which one of two is believed and not the other"
    )
    limit_sd: float = _constant(1.96, "derived: two-sided 95 % of a normal distribution")


CONSTANTS = Constants()
