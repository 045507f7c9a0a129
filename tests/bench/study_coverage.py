"""Whether the stated sds are honest: simulated sessions by the hundred, counted.

    python -m tests.bench.study_coverage paper --seeds 500
    python -m tests.bench.study_coverage rich --seeds 100

Every session is a fresh evening with another unit of the sensor: gains, offsets and axes drawn.
Printed is the spread of (estimate - truth)/sd of every parameter of both triads and of the stated
rate, and the largest difference between the two solvers: in rad, and relative for biases and
scales. A spread of 500 draws is itself known to 3 %.
"""

import argparse

import numpy as np

from calib.poses.imu_log import TRIADS
from tests.calib.fit.least_squares.coverage import GROUPS, draw
from tests.trials import DESIGNS


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("design", choices=[name for name in DESIGNS if name != "soak"])
    parser.add_argument("--seeds", type=int, default=500)
    asked = parser.parse_args()
    design = DESIGNS[asked.design]()
    found = [draw(design, seed) for seed in range(asked.seeds)]
    print(f"{asked.design}, {asked.seeds} sessions: spread (and mean) of (estimate - truth)/sd")
    for triad in TRIADS:
        z = np.array([each.deviations[triad] for each in found])
        for i, group in enumerate(GROUPS):
            part = z[:, 3 * i : 3 * i + 3]
            values = "  ".join(
                f"{axis} {np.sqrt(np.mean(v**2)):.3f} ({v.mean():+.3f})"
                for axis, v in zip("xyz", part.T, strict=True)
            )
            print(f"  {triad:14s} {group:22s} {values}")
    rates = np.concatenate([each.rates for each in found])
    print(f"  stated rate: {np.sqrt(np.mean(rates**2)):.3f} ({rates.mean():+.3f})")
    apart = max(each.solvers_apart for each in found)
    refused = sum(each.refused for each in found)
    print(f"  solvers apart by {apart:.1e} at most; the paper's iteration did not "
          f"converge from the data sheet in {refused} of {2 * len(found)} fits")


if __name__ == "__main__":
    main()
