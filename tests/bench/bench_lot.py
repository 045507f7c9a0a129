"""Many fits at once: a loop of scipy.optimize.least_squares, the solver set by set, and stacks.

    python -m tests.bench.bench_lot
    python -m tests.bench.bench_lot --sensors 10000 --sizes 60 125 250 500 1000
    python -m tests.bench.bench_lot --sensors 10000 --table /tmp/lot

Accelerometers of one make, each with gains, offsets, axes, attitudes and noise of its own
(``tests.world.lot``), 18 poses, nine parameters with their sds. SciPy and the solver set by set are
timed on a sample and scaled. The clock counts what this process computes, in one thread.
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from calib.effects.catalogue import BASE
from calib.fit.least_squares import solver
from calib.fit.least_squares.solver import fit, fit_sets
from calib.fit.model import Model
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from tests.lot_tables import lot_columns, write_design, write_lot
from tests.lots import pose_sets_of
from tests.world.designs import paper_design
from tests.world.imu import mpu6050
from tests.world.lot import LotPlan, draw_lot


def rows_of(poses: PoseSet) -> tuple[Callable[[FloatArray], FloatArray], ...]:
    """Residual and Jacobian of the nine parameters, as somebody writes them with NumPy alone."""
    y, m = poses.reading, poses.reference.magnitude
    sd = np.sqrt(((y / np.linalg.norm(y, axis=1, keepdims=True)) ** 2 * poses.sd**2).sum(axis=1))

    def corrected(x: FloatArray) -> FloatArray:
        s = y * (1 - x[3:6]) - x[:3]
        s[:, 0] -= x[8] * y[:, 1] + x[7] * y[:, 2]
        s[:, 1] -= x[6] * y[:, 2]
        return s

    def residual(x: FloatArray) -> FloatArray:
        return (np.sqrt((corrected(x) ** 2).sum(axis=1)) - m) / sd

    def jacobian(x: FloatArray) -> FloatArray:
        s = corrected(x)
        n = s / np.sqrt((s**2).sum(axis=1))[:, None] / sd[:, None]
        lean = np.stack([n[:, 1] * y[:, 2], n[:, 0] * y[:, 2], n[:, 0] * y[:, 1]], axis=1)
        return -np.hstack([n, n * y, lean])

    return residual, jacobian


def by_scipy(poses: PoseSet, exact: bool) -> None:
    """Estimate and covariance of one set, by differences or with the exact Jacobian."""
    residual, jacobian = rows_of(poses)
    at = least_squares(residual, np.zeros(9), jac=jacobian if exact else "2-point", x_scale="jac")
    np.linalg.inv(at.jac.T @ at.jac)


def seconds_each(task: Callable[[PoseSet], object], sample: list[PoseSet]) -> float:
    """What a task takes for one set of a sample, s."""
    task(sample[0])
    start = time.process_time()
    for poses in sample:
        task(poses)
    return (time.process_time() - start) / len(sample)


def stacked_seconds(sets: list[PoseSet], model: Model) -> tuple[float, int]:
    """What the stacks take, s, and how many sets they refuse."""
    start = time.process_time()
    refused = sum(len(fits.refusals) for fits in fit_sets(sets, model))
    return time.process_time() - start, refused


def write_table(folder: Path, sensors: int) -> None:
    """A lot with an effect of half an sd as a table, and the command that calibrates it."""
    lot = draw_lot(paper_design(mpu6050()), LotPlan(sensors, hidden="cubic", common_sd=0.5), 1)
    folder.mkdir(parents=True, exist_ok=True)
    write_lot(folder / "lot.parquet", lot_columns(lot))
    write_design(folder / "design.yaml", lot)
    print(f"/usr/bin/time -v pipeline fleet {folder}/lot.parquet --design {folder}/design.yaml "
          f"--output {folder}/out")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--sensors", type=int, default=10_000)
    parser.add_argument("--sample", type=int, default=200)
    parser.add_argument("--sizes", type=int, nargs="*", default=[])
    parser.add_argument("--table", type=Path, help="write a lot's table here, and time nothing")
    asked = parser.parse_args()
    if asked.table is not None:
        return write_table(asked.table, asked.sensors)
    lot = draw_lot(paper_design(mpu6050()), LotPlan(asked.sensors), 1)
    sets, model = pose_sets_of(lot), Model.of(BASE)
    stacked_seconds(sets[:500], model)
    stacked, refused = stacked_seconds(sets, model)
    sample = sets[: asked.sample]
    print(f"{len(sets)} accelerometers of {len(lot.time_s)} poses, nine parameters with sds")
    print(f"stacks                           {stacked:8.2f} s   {1e3 * stacked / len(sets):.4f} ms "
          f"each; {refused} refused")
    rivals: dict[str, Callable[[PoseSet], object]] = {
        "solver, set by set": lambda poses: fit(poses, model),
        "scipy least_squares, its own way": lambda poses: by_scipy(poses, exact=False),
        "scipy, exact Jacobian": lambda poses: by_scipy(poses, exact=True),
    }
    for name, task in rivals.items():
        each = seconds_each(task, sample)
        print(f"{name:32s} {each * len(sets):8.2f} s   {1e3 * each:.4f} ms each, "
              f"{each * len(sets) / stacked:.0f} times as long ({len(sample)} timed, scaled)")
    for size in asked.sizes:
        solver.SETS_AT_ONCE = size
        print(f"{size:5d} sets in one stack: {stacked_seconds(sets, model)[0]:.2f} s")


if __name__ == "__main__":
    main()
