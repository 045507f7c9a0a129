"""How long a fit takes, beside scipy.optimize.least_squares on the same problem in the same run.

    python -m tests.bench.bench_fit

18 poses with covariance; and, where the measured data stand beside the project, still intervals
and both fits of the 51 175-row log of an Xsens MTi. Medians of wall time.
"""

from collections.abc import Callable

import numpy as np
from scipy.optimize import least_squares

from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.rows.residuals import Equations
from calib.fit.triad.calibration import calibrate_triad
from calib.poses.averaging.average_pose import average_pose
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, ImuLog
from calib.poses.pose_set import pose_set
from calib.poses.rests.static_intervals import find_still
from calib.poses.runs.reference_runs import gravity_run
from pipeline.logs.read import read_log
from tests.bench.timing import median_ms
from tests.fitting import pose_sets
from tests.paths import SHARED
from tests.world.designs import paper_design
from tests.world.session import simulate

XSENS = SHARED / "real" / "imu_tk_xsens"
GRAVITY = 9.81744
MTI = TriadSpec(50.0, 16, "offset-binary")


def plain_residual(equations: Equations) -> Callable[[FloatArray], FloatArray]:
    """The same whitened rows as a function that knows nothing but numpy."""
    y, sd = equations.poses.reading, equations.magnitude_sd
    m, common = equations.poses.reference.magnitude, equations.common

    def residual(x: FloatArray) -> FloatArray:
        bias, scale, (mx, my, mz), eta = x[:3], x[3:6], x[6:9], x[9:]
        s = y * (1 - scale) - bias
        s[:, 0] -= mz * y[:, 1] + my * y[:, 2]
        s[:, 1] -= mx * y[:, 2]
        rows = (np.sqrt((s**2).sum(axis=1)) - m - common @ eta) / sd
        return np.concatenate([rows, eta])

    return residual


def by_scipy(residual: Callable[[FloatArray], FloatArray], size: int) -> tuple[FloatArray, object]:
    """Solution and covariance by scipy's trust region from the data sheet, its usual way."""
    found = least_squares(residual, np.zeros(size), x_scale="jac")
    return found.x, np.linalg.inv(found.jac.T @ found.jac)


def xsens_log() -> ImuLog:
    """The accelerometer's log, as the product reads it."""
    return read_log(XSENS / "xsens_acc.mat.gz", ("time_s", "acc_x", "acc_y", "acc_z"))


def fit_long_log(log: ImuLog) -> tuple[int, float]:
    """Still intervals, means, fit; the number of poses and the residual's root mean square."""
    specs = {"accelerometer": MTI}
    means = [average_pose(pose, specs) for pose in find_still(log, specs).logs]
    poses = pose_set("accelerometer", [gravity_run("still", means, GRAVITY, 0.0)], 0.0)
    found = calibrate_triad(fit(poses, Model.of(BASE)), MTI)
    return len(poses), found.fit.residual_rms


def main() -> None:
    """Print the table."""
    accelerometer, gyroscope, specs = pose_sets(simulate(paper_design(), 1))
    model = Model.of(BASE)
    for poses, spec in ((accelerometer, specs[0]), (gyroscope, specs[1])):
        equations = Equations.of(poses, model)
        size = 9 + equations.common_count
        residual = plain_residual(equations)
        ours = median_ms(lambda p=poses: fit(p, model), 300)  # type: ignore[misc]
        whole = median_ms(lambda p=poses, s=spec: calibrate_triad(fit(p, model), s), 300)  # type: ignore[misc]
        theirs = median_ms(lambda r=residual, n=size: by_scipy(r, n), 100)  # type: ignore[misc]
        apart = np.abs(by_scipy(residual, size)[0][:9] - fit(poses, model).theta).max()
        print(
            f"{poses.triad}, {len(poses)} poses: fit with covariance {ours:.3f} ms, with the "
            f"paper's parameters {whole:.3f} ms; scipy.optimize.least_squares {theirs:.2f} ms; "
            f"solutions apart by {apart:.1e}"
        )
    if not XSENS.is_dir():
        print("the measured log is not beside the project: long log not timed")
        return
    log = xsens_log()
    poses_found, rms = fit_long_log(log)
    taken = median_ms(lambda: fit_long_log(log), 7)
    reading = median_ms(xsens_log, 5)
    numpys = median_ms(lambda: np.loadtxt(XSENS / "xsens_acc.mat.gz"), 5)
    print(
        f"{len(log.time_s)} rows: still intervals, means and fit {taken:.0f} ms; {poses_found} "
        f"poses, residual {1e3 * rms:.2f} mm/s²; reading the file {reading:.0f} ms, numpy.loadtxt "
        f"{numpys:.0f} ms"
    )


if __name__ == "__main__":
    main()
