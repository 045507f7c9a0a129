"""Whether the sds of the gains hold beside a common error and a misfit: gyros by the hundred.

    python -m tests.bench.study_common_errors --seeds 400

One speed, 26 poses. The rate is off by a draw of its sd (50 to 20000 ppm), which all poses share;
with a misfit every pose scatters by ten times its stated noise besides. Printed is the mean error
of the gain, its spread in its stated sds, and how often 95 % of them hold it. A gain that shrank
with the reference (Peelle's puzzle) would show as a mean error.
"""

import argparse
from dataclasses import replace

import numpy as np

from calib.fit.least_squares.solver import fit
from calib.fit.triad.calibration import calibrate_triad
from tests.calib.made_poses import MODEL, SLOW, SPECS, base_theta, made_poses, noisy

PPM = (50, 500, 5000, 20_000)
SCATTER = 10.0
"""Of the misfit, in stated sds of a pose mean."""


def scores(ppm: float, scatter: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Relative errors of the gains (3,), and those in their stated sds (3,)."""
    poses = noisy(made_poses("gyroscope", (SLOW,), seed=seed, corners=True, shared_sd=ppm * 1e-6),
                  seed)
    rng = np.random.default_rng([seed, 9])
    more = scatter * poses.sd * rng.standard_normal(poses.reading.shape)
    found = calibrate_triad(fit(replace(poses, reading=poses.reading + more), MODEL),
                            SPECS["gyroscope"])
    off = found.fit.theta[3:6] - base_theta(MODEL, "gyroscope")[3:6]
    return off, off / np.sqrt(np.diag(found.fit.cov))[3:6]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=400)
    asked = parser.parse_args()
    print("clock ppm  misfit sd  mean error ppm  spread in sds  within 1.96 sd")
    for scatter in (0.0, SCATTER):
        for ppm in PPM:
            drawn = [scores(ppm, scatter, seed) for seed in range(asked.seeds)]
            off = np.array([each[0] for each in drawn])
            z = np.array([each[1] for each in drawn])
            print(f"{ppm:9d}  {scatter:9g}  {1e6 * off.mean():14.0f}  "
                  f"{np.sqrt(np.mean(z**2)):13.2f}  {100 * np.mean(np.abs(z) < 1.96):12.1f} %")


if __name__ == "__main__":
    main()
