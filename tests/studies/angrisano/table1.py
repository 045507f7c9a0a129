"""Table 1: the accelerometer in 18 poses, laid on a wedge and by hand, many times over.

The published sds are tested first: with the poses' geometry, each of sigma_alpha, sigma_b and
sigma_k says how uncertain a pose was, and the three must agree. Sessions are then made with poses
as uncertain as that.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from calib.effects.catalogue import BASE
from calib.fit.least_squares.angrisano import (
    corrected_vectors,
    data_sheet_start,
    fit_paper,
    jacobian,
)
from calib.fit.model import Model
from calib.fit.triad.calibration import calibrate_triad
from calib.poses.averaging.average_pose import average_pose
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet, pose_set
from calib.poses.runs.reference_runs import gravity_run
from pipeline.text.tables import Rows, aligned
from tests.studies.angrisano.bench import BenchTriad, laid_directions, leaning_axes
from tests.studies.angrisano.iteration import iterate_as_printed
from tests.studies.angrisano.published import (
    ACCELEROMETER,
    ACCELEROMETER_CERTIFICATE,
    GRAVITY_M_S2,
    POSE_ACCURACY_RAD,
    TABLE_1,
    PublishedSet,
)

SESSIONS = 40
POSE_S = 8.0

GROUPS = ("alpha", "b", "k⁻¹")
PARTS = {name: slice(3 * i, 3 * i + 3) for i, name in enumerate(GROUPS)}


def accelerometer() -> BenchTriad:
    """Offsets and gains of the certificate, axes that lean as the first set found.

    Axes apart by 90° - θ give α = -θ to first order: eq. (15) is for components along the axes,
    which readings are not.
    """
    offset, gain = ACCELEROMETER_CERTIFICATE
    axes = leaning_axes(-TABLE_1[0].misalignment_rad)
    return BenchTriad("accelerometer", ACCELEROMETER, axes, gain, offset)


def sds_per_unit(triad: BenchTriad, vectors: FloatArray) -> FloatArray:
    """Sds of alpha, b and k (9,) when every pose's magnitude has an sd of one SI unit."""
    truth = triad.truth()
    x = np.concatenate(
        [truth.misalignment_rad, truth.bias_counts, 1 / truth.scale_counts_per_unit]
    )
    counts = triad.readings(vectors)
    n = corrected_vectors(x, counts)
    along = n / np.linalg.norm(n, axis=1, keepdims=True)
    design = np.einsum("ni,nij->nj", along, jacobian(x, counts))
    size = np.linalg.norm(design, axis=0)
    inverse = np.linalg.inv(np.linalg.qr(design / size, mode="r")) / size[:, None]
    return np.asarray(np.sqrt((inverse**2).sum(axis=1)))


def implied_pose_sds(triad: BenchTriad, vectors: FloatArray, printed: PublishedSet) -> FloatArray:
    """The sd of a pose (SI) that sigma_alpha, sigma_b and sigma_k each imply, shape (3,)."""
    unit = sds_per_unit(triad, vectors).reshape(3, 3).mean(axis=1)
    stated = np.array([printed.sd_misalignment_rad, printed.sd_bias_counts, printed.sd_k])
    return np.asarray(stated / unit)


def still_poses(accuracy_rad: float, pose_sd_m_s2: float, seed: int) -> PoseSet:
    """One session: 18 still poses, averaged."""
    rng = np.random.default_rng([1, seed])
    triad = accelerometer()
    vectors = GRAVITY_M_S2 * laid_directions(accuracy_rad, rng)
    logs = triad.logs(vectors, POSE_S, pose_sd_m_s2, rng)
    means = [average_pose(log, {"accelerometer": ACCELEROMETER}) for log in logs]
    run = gravity_run("still", means, GRAVITY_M_S2, 0.0)
    return pose_set("accelerometer", [run], 0.0)


def counts_of(poses: PoseSet) -> FloatArray:
    """Mean readings of the poses in counts, shape (n, 3)."""
    return poses.reading / ACCELEROMETER.nominal_scale + ACCELEROMETER.nominal_bias_counts


@dataclass(frozen=True, eq=False)
class RepeatedSet:
    """One published set and its repetition in ``SESSIONS`` simulated sessions.

    ``implied_sd`` (3,) m/s²; ``truth`` (9,) alpha, b, k⁻¹; ``found`` and ``sd`` (s, 9);
    ``iterations`` (s,) as printed.
    """

    printed: PublishedSet
    accuracy_rad: float
    implied_sd: FloatArray
    truth: FloatArray
    found: FloatArray
    sd: FloatArray
    iterations: FloatArray

    @property
    def scatter(self) -> FloatArray:
        """Rms of the error over the sessions, (9,)."""
        return np.asarray(np.sqrt(((self.found - self.truth) ** 2).mean(axis=0)))


@lru_cache(maxsize=1)
def table_1() -> tuple[RepeatedSet, ...]:
    """Both sets, repeated."""
    return tuple(
        _repeat(printed, accuracy)
        for printed, accuracy in zip(TABLE_1, POSE_ACCURACY_RAD, strict=True)
    )


def _repeat(printed: PublishedSet, accuracy_rad: float) -> RepeatedSet:
    triad = accelerometer()
    laid = GRAVITY_M_S2 * laid_directions(accuracy_rad, np.random.default_rng([1, 0]))
    implied = implied_pose_sds(triad, laid, printed)
    found, sd, iterations = [], [], []
    for seed in range(SESSIONS):
        poses = still_poses(accuracy_rad, float(implied.mean()), seed)
        fit = fit_paper(poses, Model.of(BASE), ACCELEROMETER)
        parameters = calibrate_triad(fit, ACCELEROMETER).parameters
        found.append(
            np.concatenate(
                [
                    parameters.misalignment_rad,
                    parameters.bias_counts,
                    parameters.scale_counts_per_unit,
                ]
            )
        )
        sd.append(np.concatenate(parameters.sd))
        printed_way = iterate_as_printed(
            data_sheet_start(ACCELEROMETER), counts_of(poses), GRAVITY_M_S2
        )
        iterations.append(printed_way.count)
    truth = triad.truth()
    return RepeatedSet(
        printed,
        accuracy_rad,
        implied,
        np.concatenate([truth.misalignment_rad, truth.bias_counts, truth.scale_counts_per_unit]),
        np.array(found),
        np.array(sd),
        np.array(iterations),
    )


def table_1_lines() -> Iterator[str]:
    """The printed table beside its repetition."""
    yield f"Table 1: accelerometer, 18 poses, solver paper; {SESSIONS} simulated sessions each"
    for repeated in table_1():
        printed = repeated.printed
        yield ""
        yield f"{printed.name}, poses laid within {math.degrees(repeated.accuracy_rad):.0f}°"
        first, truth = repeated.found[0], repeated.truth
        sd_scale = printed.sd_k * printed.scale_counts_per_unit.mean() ** 2
        rows = [
            ["", "alpha x, y, z [rad]", "b [counts]", "k⁻¹ [counts/(m/s²)]"],
            ["published", *_three(_printed(printed))],
            ["simulated truth", *_three(truth)],
            ["found, first session", *_three(first)],
            [
                "published sd",
                f"{printed.sd_misalignment_rad:.5f}",
                f"{printed.sd_bias_counts:.2f}",
                f"{sd_scale:.3f}  (k: {printed.sd_k:.1e})",
            ],
            ["mean sd stated", *_one(repeated.sd.mean(axis=0))],
            ["rms error found", *_one(repeated.scatter)],
            [
                "sd of a pose that the published sd implies",
                *(f"{1e3 * sd:.2f} mm/s²" for sd in repeated.implied_sd),
            ],
        ]
        yield from aligned(rows)
        within = np.mean(np.abs(repeated.found - truth) < 1.96 * repeated.sd)
        few, many = int(repeated.iterations.min()), int(repeated.iterations.max())
        yield f"  within 1.96 sd of the truth: {100 * within:.1f} %"
        yield f"  iterations by the printed rule: {few} to {many} (published: 4 to 5)"
    yield ""
    yield from _agreement_lines()


def _agreement_lines() -> Iterator[str]:
    """Whether both published sets agree within their sds, in the units that may be meant."""
    first, second = TABLE_1
    apart = np.abs(_printed(first) - _printed(second))
    alpha_sd = math.hypot(first.sd_misalignment_rad, second.sd_misalignment_rad)
    bias_sd = math.hypot(first.sd_bias_counts, second.sd_bias_counts)
    scale_sd = math.hypot(first.sd_k, second.sd_k) * first.scale_counts_per_unit**2
    sigmas: Rows = [
        ["alpha, read in rad", *_sigmas(apart[PARTS["alpha"]] / alpha_sd)],
        ["alpha, read in °", *_sigmas(np.radians(apart[PARTS["alpha"]]) / alpha_sd)],
        ["b", *_sigmas(apart[PARTS["b"]] / bias_sd)],
        ["k⁻¹", *_sigmas(apart[PARTS["k⁻¹"]] / scale_sd)],
    ]
    yield "first less second published set, in sds of the difference (x, y, z)"
    yield from aligned(sigmas)


def _sigmas(values: FloatArray) -> list[str]:
    return [f"{value:.3f}" for value in values]


def _printed(printed: PublishedSet) -> FloatArray:
    return np.concatenate(
        [printed.misalignment_rad, printed.bias_counts, printed.scale_counts_per_unit]
    )


def _three(values: FloatArray) -> list[str]:
    formats = ("{: .4f}", "{:.1f}", "{:.2f}")
    return [
        "  ".join(form.format(value) for value in values[part])
        for form, part in zip(formats, PARTS.values(), strict=True)
    ]


def _one(values: FloatArray) -> list[str]:
    formats = ("{:.5f}", "{:.2f}", "{:.3f}")
    return [
        form.format(float(np.sqrt((values[part] ** 2).mean())))
        for form, part in zip(formats, PARTS.values(), strict=True)
    ]
