"""Whether stated sds hold where something disturbs that no model has: six worlds, counted.

    python -m tests.bench.study_disturbed --seeds 60

22 poses of an accelerometer in random directions, half a minute apart. ``coarse`` and
``correlated`` are sessions of the simulated bench with a converter of four bits less and with noise
correlated over two seconds, in its 26 hand-laid poses; ``wander`` is a bias that wanders by 2 sds
of a pose, correlated over ten minutes, and counts against its own mean; ``bad pose`` is one pose
that is 12 sds off; ``all`` is both at once. Printed is the root mean square of (estimate -
truth)/sd of the parameters, by the fit alone (its noise, as the sds and the residual tell it) and
averaged over what may be missing.
"""

import argparse

import numpy as np

from calib.errors import CalibrationError
from tests.calib.diagnosis.disturbed import WORLDS, deviations


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=60)
    parser.add_argument("--first", type=int, default=61_000, help="the first seed")
    parser.add_argument("--worlds", nargs="*", choices=WORLDS, default=WORLDS)
    asked = parser.parse_args()
    print("world        refused  z rms by the fit alone  averaged  within 1, 2, 3 sd")
    for world in asked.worlds:
        z, refused = [], 0
        for seed in range(asked.first, asked.first + asked.seeds):
            try:
                z.append(deviations(world, seed))
            except CalibrationError:
                refused += 1
        scores = np.abs(np.array(z))
        alone, average = np.sqrt(np.mean(scores**2, axis=(0, 2)))
        within = ", ".join(f"{100 * np.mean(scores[:, 1] < k):.1f} %" for k in (1, 2, 3))
        print(f"{world:12s} {refused:7d}  {alone:22.2f}  {average:8.2f}  {within}", flush=True)


if __name__ == "__main__":
    main()
