"""How long one diagnosis takes: 126 rows, every listed effect.

    OPENBLAS_NUM_THREADS=1 python -m tests.bench.bench_diagnose

Medians of wall time for sessions with no hidden effect, one, two and three, beside one fit of the
same rows: a diagnosis is a search through refits, and its time over that of a fit is what it costs.
"""

from functools import partial

from calib.diagnosis.diagnose import diagnose
from calib.effects.catalogue import BASE
from calib.effects.effect import EFFECTS
from calib.fit.model import Model
from calib.fit.solver import fit
from tests.bench.timing import median_ms
from tests.trials import DESIGNS, drawn, poses_of

HIDDEN = (
    (),
    ("quadratic",),
    ("g_sensitivity",),
    ("warm_up",),
    ("quadratic", "bias_drift"),
    ("g_sensitivity", "cubic", "temperature_bias"),
)
SIZE = 5.0
SEED = 2


def main() -> None:
    """Print the table."""
    listed = sum("gyroscope" in effect.triads for effect in EFFECTS.values())
    print(f"{listed} listed effects; median ms of one fit, of a whole diagnosis, ratio")
    for name in ("rich", "paper"):
        design = DESIGNS[name]()
        for names in HIDDEN:
            effects = [drawn(n, "gyroscope", SIZE, design, SEED) for n in names]
            poses = poses_of(design, SEED, "gyroscope", [e for e in effects if e is not None])
            base = fit(poses, Model.of(BASE))
            rows = base.equations.data_count
            whole = median_ms(partial(diagnose, base), 15)
            one = median_ms(partial(fit, poses, Model.of(BASE)), 15)
            said = diagnose(base)
            hidden = " + ".join(names) or "nothing"
            print(
                f"{name:6s} {rows:4d} rows, hidden {hidden:42s}: {one:5.1f} {whole:6.1f} "
                f"{whole / one:5.0f} x  {said.verdict} {'/'.join(said.group)}"
            )


if __name__ == "__main__":
    main()
