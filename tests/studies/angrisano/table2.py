"""Table 2: from how far the iteration still converges, and the default solver beside it.

All three parameters of a kind are moved together from the start of eq. (12), as the publication
did, in steps outwards until the iteration first misses the solution.

Two iterations are tried: the one printed, whose stop rule without the bars, on the residual of the
linear system, can end it before it has arrived, and the product's solver ``paper``. The default
solver starts from the readings' own ellipsoid. What stands for its start is the data sheet's
conversion of the readings: they are handed to it converted with the moved values.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from calib.effects.catalogue import BASE
from calib.errors import Undetermined
from calib.fit.least_squares.angrisano import data_sheet_start, fit_paper, iterations_from
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.parameters import alignment, triad_parameters
from calib.fit.rows.residuals import Equations
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from pipeline.text.tables import aligned
from tests.studies.angrisano.iteration import Iterations, iterate_as_printed
from tests.studies.angrisano.published import (
    ACCELEROMETER,
    GRAVITY_M_S2,
    POSE_ACCURACY_RAD,
    TABLE_2,
)
from tests.studies.angrisano.table1 import counts_of, still_poses

POSE_SD_M_S2 = 0.0027
"""What the published sds of the first set imply (table 1)."""

KINDS = tuple(TABLE_2)
STEP = {"misalignment": math.radians(1.0), "bias": 125.0, "scale": 2.5e-5}
STEP_UP = {**STEP, "scale": 1e-3}
FURTHEST = {
    "misalignment": (math.radians(-80.0), math.radians(80.0)),
    "bias": (-30000.0, 30000.0),
    "scale": (-0.0015, 0.06),
}
"""Where the search ends: the scale's start stays positive, the bias's within the converter."""

RIGHT_SD = 10.0
"""Within so many sds of the minimum, the solution counts as right: nearer than one can see in a
figure, further than a stop rule of 0.0005 leaves it."""

Converges = Callable[[FloatArray], bool]


@dataclass(frozen=True, eq=False)
class StartStudy:
    """One session and its solution, from which starts are moved away.

    ``counts`` (18, 3); ``solution`` and ``sd`` (9,) in alpha, b, k.
    """

    poses: PoseSet
    counts: FloatArray
    solution: FloatArray
    sd: FloatArray

    def start(self, kind: str, shift: float) -> FloatArray:
        """Eq. (12) with all three parameters of ``kind`` moved by ``shift``, (9,)."""
        start = data_sheet_start(ACCELEROMETER)
        first = 3 * KINDS.index(kind)
        start[first : first + 3] += shift
        return start

    def is_right(self, x: FloatArray) -> bool:
        """Whether X is the solution."""
        return bool((np.abs(x - self.solution) < RIGHT_SD * self.sd).all())

    def as_printed(self, start: FloatArray, absolute: bool = False) -> Iterations:
        """The published iteration; overflow is how divergence looks."""
        with np.errstate(over="ignore", invalid="ignore"):
            return iterate_as_printed(start, self.counts, GRAVITY_M_S2, absolute=absolute)


@lru_cache(maxsize=1)
def start_study() -> StartStudy:
    """The session of the first set, laid within 1°."""
    poses = still_poses(POSE_ACCURACY_RAD[0], POSE_SD_M_S2, 0)
    found = fit_paper(poses, Model.of(BASE), ACCELEROMETER)
    parameters = triad_parameters(found.model, found.theta, found.cov, ACCELEROMETER)
    k = 1 / parameters.scale_counts_per_unit
    sd_alpha, sd_bias, sd_scale = parameters.sd
    return StartStudy(
        poses,
        counts_of(poses),
        np.concatenate([parameters.misalignment_rad, parameters.bias_counts, k]),
        np.concatenate([sd_alpha, sd_bias, sd_scale * k**2]),
    )


def printed_converges(study: StartStudy) -> Converges:
    """The published iteration, stop rule as printed."""

    def converges(start: FloatArray) -> bool:
        found = study.as_printed(start)
        return found.stopped and study.is_right(found.x[-1])

    return converges


def mended_converges(study: StartStudy) -> Converges:
    """The product's solver ``paper``."""
    equations = Equations.of(study.poses, Model.of(BASE))

    def converges(start: FloatArray) -> bool:
        with np.errstate(over="ignore", invalid="ignore"):
            steps, stopped = iterations_from(start, equations, study.counts)
        return stopped and study.is_right(steps[-1].x)

    return converges


def default_converges(study: StartStudy) -> Converges:
    """The default solver on readings that were converted with the start as the data sheet.

    It does not diverge; but it judges afterwards whether the poses determine the model, and with a
    false origin that is wrong by several g it refuses, since seen from there they hardly do.
    """

    def converges(start: FloatArray) -> bool:
        conversion = alignment(start[:3]) * start[6:]  # T K of the start
        reading = (study.counts - start[3:6]) @ conversion.T
        sd = study.poses.sd / ACCELEROMETER.nominal_scale * start[6:]
        poses = replace(study.poses, reading=reading, sd=sd)
        try:
            found = fit(poses, Model.of(BASE))
        except Undetermined:
            return False
        bias, scale, (x, y, z) = found.theta.reshape(3, 3)
        form = np.diag(1 - scale) - np.array([[0, z, y], [0, 0, x], [0, 0, 0]])
        upper = form @ conversion
        k = np.diag(upper)
        t = upper / k
        b = start[3:6] + np.linalg.solve(upper, bias)
        return study.is_right(np.concatenate([[t[1, 2], t[0, 2], t[0, 1]], b, k]))

    return converges


def interval(study: StartStudy, kind: str, converges: Converges) -> tuple[float, float]:
    """The last shifts that still converge on the way out, down and up."""
    lowest, highest = FURTHEST[kind]
    ends = []
    for step, end in ((-STEP[kind], lowest), (STEP_UP[kind], highest)):
        shift = 0.0
        while abs(shift + step) <= abs(end) + 1e-12 and converges(study.start(kind, shift + step)):
            shift += step
        ends.append(shift)
    return ends[0], ends[1]


@lru_cache(maxsize=1)
def table_2() -> dict[str, dict[str, tuple[float, float]]]:
    """Interval by iteration and kind, in rad, counts, m/s² per count."""
    study = start_study()
    solvers = {
        "as printed": printed_converges(study),
        "solver paper": mended_converges(study),
        "solver default": default_converges(study),
    }
    return {
        name: {kind: interval(study, kind, converges) for kind in KINDS}
        for name, converges in solvers.items()
    }


def table_2_lines() -> Iterator[str]:
    """The published intervals beside those found."""
    yield "Table 2: convergence intervals about the data sheet's start"
    found = {"published": TABLE_2, **table_2(), "searched": FURTHEST}
    heading = ["", "alpha [°]", "b [counts]", "k [(m/s²)/count]"]
    yield from aligned([heading, *(_row(name, ends) for name, ends in found.items())])
    yield "  beyond its interval the default solver refuses; it gives no other answer"
    study = start_study()
    printed = study.as_printed(data_sheet_start(ACCELEROMETER))
    yield f"  iterations from the data sheet's start, as printed: {printed.count}"


def _row(name: str, found: dict[str, tuple[float, float]]) -> list[str]:
    low, high = (math.degrees(end) for end in found["misalignment"])
    bias, scale = found["bias"], found["scale"]
    return [
        name,
        f"[{low:+.0f}, {high:+.0f}]",
        f"[{bias[0]:+.0f}, {bias[1]:+.0f}]",
        f"[{scale[0]:+.5f}, {scale[1]:+.3f}]",
    ]
