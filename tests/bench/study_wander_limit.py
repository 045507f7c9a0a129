"""How often a bias that wanders could be named at all: by one who knows all of it but which it is.

    python -m tests.bench.study_wander_limit [--seeds 30] [--first 910000]

The hand-laid sessions of ``tests.bench.study_kinds`` with a bias that wanders by 5 noise units. The
correlation time and the size on every axis are known, and what may be there instead is four courses
alone, as likely and of the same rms about their mean: a line, a step, a warm-up, and noise of every
pose by itself. Printed is what the rows leave to a wander, by the restricted likelihood, beside
what the program says, which knows neither of them and has twenty rivals.
"""

import argparse
from collections.abc import Sequence

import numpy as np

from calib.diagnosis.finding import find
from calib.effects.catalogue import BASE
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.poses.imu_log import FloatArray
from tests.set_trials import design_of
from tests.trials import poses_of
from tests.world.sizes import draw_effect

NAMED = 0.8
WARM_UPS_S = (60.0, 150.0, 300.0)


def log_density(base: Fit, columns: Sequence[FloatArray]) -> float:
    """Restricted likelihood of the rows with a course of covariance Z Zᵀ more, its mean over Z."""
    jacobian = base.rows.jacobian @ base.directions
    values = []
    for z in columns:
        factor = np.linalg.cholesky(np.eye(len(z)) + z @ z.T)
        q, r = np.linalg.qr(np.linalg.solve(factor, jacobian))
        rest = np.linalg.solve(factor, base.rows.residual)
        rest = rest - q @ (q.T @ rest)
        values.append(-np.log(np.diag(factor)).sum() - np.log(np.abs(np.diag(r))).sum()
                      - 0.5 * rest @ rest)
    return float(np.logaddexp.reduce(values) - np.log(len(values)))


def of_a_wander(base: Fit, size: FloatArray, tau_s: float) -> float:
    """Probability of a wander of ``size`` (3,), SI, among the five."""
    time_s, equations = base.poses.time_s, base.equations
    n, directions = len(time_s), equations.directions(base.rows.vector)

    def rows(course: FloatArray) -> FloatArray:
        shown = np.concatenate([
            directions[:, [k]] * size[k] * course[equations.row_pose] for k in range(3)], axis=1)
        return np.vstack([shown, np.zeros((len(base.rows.residual) - len(shown), shown.shape[1]))])

    root = np.linalg.cholesky(np.exp(-np.abs(time_s[:, None] - time_s) / tau_s))
    rms = float(np.sqrt(((root - root.mean(axis=0)) ** 2).sum() / n))

    def alike(course: FloatArray) -> FloatArray:
        return rows(rms * ((course - course.mean()) / course.std())[:, None])

    since = time_s - time_s.min()
    density = np.array([
        log_density(base, [rows(root)]),
        log_density(base, [alike(since)]),
        log_density(base, [alike((since >= at).astype(float)) for at in np.sort(since)[2:-1]]),
        log_density(base, [alike(np.exp(-since / tau)) for tau in WARM_UPS_S]),
        log_density(base, [rows(rms * np.eye(n))]),
    ])
    return float(np.exp(density[0] - np.logaddexp.reduce(density)))


def main() -> None:
    """Print what could be named, and what is."""
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=30)
    parser.add_argument("--first", type=int, default=910_000)
    asked = parser.parse_args()
    sure, named = [], []
    for seed in range(asked.first, asked.first + asked.seeds):
        design = design_of("hand", seed)
        hidden = draw_effect("wander", "accelerometer", 5.0, design, seed)
        base = fit(poses_of(design, seed, "accelerometer", [hidden]), Model.of(BASE))
        known = of_a_wander(base, np.abs(np.ravel(hidden.size)),
                            float(hidden.detail["wander_tau_s"]))
        sure.append(known >= NAMED)
        named.append(find(base).verdict.name == "bias_wander")
    print(f"of {asked.seeds} a wander has {NAMED} and more in {sum(sure)} where all else is known; "
          f"the program names {sum(named)}, {sum(np.logical_and(sure, named))} of these")


if __name__ == "__main__":
    main()
