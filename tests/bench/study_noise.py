"""Whether the upper limits and the sds of `pipeline noise` hold: simulated logs at rest, by mixes.

    python -m tests.bench.study_noise --seeds 400

Every mix is white noise with or without 1/f noise and a random walk, some of them far below what
such a log can show. Printed for each coefficient that is there: the share of logs that show it, the
share of logs whose limit of 95 % holds it, and of those that show it the share within 1.96 sds, and
mean and spread of (value - truth)/sd. A limit that is nearly always right belongs to a coefficient
that is smaller than what noise alone may look like.
"""

import argparse

import numpy as np

from calib.noise.coefficients import axis_noise
from tests.calib.noise.simulated import noise

STEP_S = 0.1
COUNT = 20_000
NAMES = ("noise_density", "bias_instability", "random_walk")
MIXES = {
    "all three, well seen": (1e-4, 4e-5, 1e-5),
    "all three, faint": (1e-4, 2e-5, 2e-6),
    "flicker, faint": (1e-4, 1e-5, 0.0),
    "flicker, hidden": (1e-4, 4e-6, 0.0),
    "flicker, strong": (1e-5, 4e-5, 0.0),
    "walk, faint": (1e-4, 0.0, 1e-6),
    "walk, hidden": (1e-4, 0.0, 2e-7),
    "walk, strong": (1e-4, 0.0, 2e-5),
    "white alone": (1e-4, 0.0, 0.0),
}  #: N, B, K


def main() -> None:
    """Print a line for each coefficient of each mix."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    chosen = parser.parse_args()
    print(f"{'mix':22} {'coefficient':17} {'shown':>7} {'limit holds':>12} {'1.96 sd':>8} "
          f"{'pull':>6} {'spread':>7}")
    for mix, truths in MIXES.items():
        logs = (noise(np.random.default_rng(chosen.first + seed), COUNT, STEP_S, *truths)
                for seed in range(chosen.seeds))
        fits = [axis_noise(log, STEP_S).coefficients for log in logs]
        for name, truth in zip(NAMES, truths, strict=True):
            if not truth:
                continue
            holds = np.mean([truth <= fit[name].limit for fit in fits])
            pulls = np.array([(fit[name].value - truth) / fit[name].sd for fit in fits
                              if fit[name].value is not None])
            figures = ("" if len(pulls) < 0.1 * len(fits) else
                       f" {100 * np.mean(np.abs(pulls) < 1.96):6.1f} % {pulls.mean():+6.2f} "
                       f"{pulls.std():7.2f}")
            print(f"{mix:22} {name:17} {100 * len(pulls) / len(fits):5.0f} % "
                  f"{100 * holds:10.1f} %{figures}", flush=True)


if __name__ == "__main__":
    main()
