"""How long one diagnosis takes: 126 rows, every listed effect.

    python -m tests.bench.bench_diagnose

Medians of wall time for clean sessions, one hidden effect and two, where refits decide.
"""

from calib.diagnosis.diagnose import diagnose
from calib.diagnosis.hypotheses import weigh
from calib.diagnosis.ranking import log_posterior, rank
from calib.diagnosis.signature import Projector
from calib.effects.catalogue import BASE
from calib.effects.effect import EFFECTS
from calib.fit.model import Model
from calib.fit.solver import Fit, fit
from tests.bench.timing import median_ms
from tests.trials import DESIGNS, drawn, poses_of

HIDDEN = ((), ("quadratic",), ("g_sensitivity",), ("warm_up",), ("quadratic", "bias_drift"))
SIZE = 5.0
SEED = 1


def weigh_and_rank(found: Fit) -> None:
    """The part of a diagnosis that every fit needs: evidence of all hypotheses, their ranking."""
    projector = Projector(found)
    weighed = weigh(found, projector)
    rank(found, projector, weighed, log_posterior(weighed))


def main() -> None:
    """Print the table."""
    listed = sum("gyroscope" in effect.triads for effect in EFFECTS.values())
    print(f"{listed} listed effects; median ms of weighing and ranking, and of a whole diagnosis")
    for name in ("rich", "paper"):
        design = DESIGNS[name]()
        for names in HIDDEN:
            effects = [drawn(n, "gyroscope", SIZE, design, SEED) for n in names]
            poses = poses_of(design, SEED, "gyroscope", [e for e in effects if e is not None])
            found = fit(poses, Model.of(BASE))
            rows = found.equations.data_count
            ranked = median_ms(lambda f=found: weigh_and_rank(f), 15)  # type: ignore[misc]
            whole = median_ms(lambda f=found: diagnose(f), 15)  # type: ignore[misc]
            said = diagnose(found)
            print(
                f"{name:6s} {rows:4d} rows, hidden {' + '.join(names) or 'nothing':28s}: "
                f"{ranked:6.1f} {whole:6.1f}  {said.verdict} {'/'.join(said.group)}"
            )


if __name__ == "__main__":
    main()
