r"""Effects whose coefficients are drawn: noise that the samples of a pose do not show.

Their coefficients have a Gaussian prior of which only the size is a parameter. Marginalised, an
effect with columns Z of size τ adds ``τ² Z Zᵀ`` to the covariance of the rows; the size is the
likeliest (:mod:`calib.fit.least_squares.drawn_sizes`). No reading of another log tells what was
drawn, so that nothing of it is corrected: it makes the sds of the parameters honest.
"""

from dataclasses import replace

import numpy as np

from calib.effects.effect import Effect, Page, Shape, ShapeValue, effect
from calib.effects.typical import between, quoted, typical
from calib.poses.conditions import RUN_COLUMN, Conditions
from calib.poses.imu_log import FloatArray


@effect(
    "size",
    acts_on="noise",
    drawn="as_noise",
    unit="1",
    page=Page(
        formula="sd_k → sd_k · √(1 + n²)",
        typical={"MPU-6050": typical(note="0 to 3, by how long the poses are"),
                 "MTi": typical(note="0 to 1")},
        source="what the poses' own samples leave out: their noise is measured within the pose",
        confounded="pose_scatter, where the sds of all poses are alike",
        separates="poses of different lengths",
    ),
)
def extra_noise(at: Conditions) -> FloatArray:
    """Noise that is larger than the samples of the poses show, by the same factor in all poses."""
    return np.ones((len(at), 3, 1))


@effect(
    "size",
    acts_on="noise",
    drawn="per_pose",
    unit="{u}",
    page=Page(
        formula="e_k = ε_k,  ε drawn anew in every pose with the sd σ",
        typical={"MPU-6050": typical(between(0.005, 0.05, "°/s"), between(0.5, 5, "mg")),
                 "MTi": typical(quoted(0.1, "mg"))},
        source="repeatability of a pose: mounting stress, a base that gives, turn-on bias",
        confounded="extra_noise, where the sds of all poses are alike; any effect not listed",
        separates="every pose laid twice, and some of them for twice as long",
    ),
)
def pose_scatter(at: Conditions) -> FloatArray:
    """Error that differs from lay to lay and stays as it is while the sensor lies."""
    return np.ones((len(at), 3, 1))


@effect(
    "size",
    acts_on="noise",
    drawn="per_pose",
    unit="1",
    only_for=("gyroscope",),
    needs=("plate",),
    belongs_to="bench",
    page=Page(
        formula="m → m · (1 + ε),  ε drawn anew in every turning pose with the sd σ",
        typical={"record player": typical(between(0.02, 0.2, "%"))},
        source="wow and drift of record players, AES6-2008",
        confounded="pose_scatter at one speed without poses at rest",
        separates="a clip with each pose, so that each has a rate of its own; poses at rest",
    ),
)
def rate_scatter(at: Conditions) -> FloatArray:
    """Rate of the plate that differs from pose to pose by more than its measured rate allows."""
    turning = np.isfinite(at.magnitude) & (at.magnitude > 0)
    sizes = np.where(turning, at.magnitude, 0.0)[:, None] * np.ones((1, 3))
    return np.asarray(sizes[:, :, None])


@effect(
    "size",
    acts_on="noise",
    drawn="in_time",
    unit="{u}",
    needs=("time",),
    belongs_to="session",
    page=Page(
        formula="e_k = σ w_k(t),  corr(w(t), w(t')) = exp(−|t − t'|/τ),  τ fitted",
        typical={"MPU-6050": typical(between(0.003, 0.03, "°/s"), between(0.2, 2, "mg")),
                 "MTi": typical(between(5, 30, "°/h"), quoted(0.04, "mg"))},
        source="IEEE Std 952 bias instability, as an Ornstein-Uhlenbeck process",
        confounded="bias_drift and warm_up where it is slow, pose_scatter where it is fast",
        separates="poses repeated throughout the session; a faster session leaves less of it",
    ),
    shape=Shape("tau_s", "s", (600.0, 150.0, 2400.0), (1.0, 1e5)),
)
def bias_wander(at: Conditions, tau_s: ShapeValue) -> FloatArray:
    """Bias that wanders at random, slowly enough that poses near in time share most of it."""
    return np.ones((len(at), 3, 1))


def in_one_run(drawn: Effect, run: str) -> Effect:
    """Effect ``drawn`` limited to the poses of one run: ``NAME:RUN``."""

    def columns(at: Conditions) -> FloatArray:
        member = at.columns.get(RUN_COLUMN + run, np.zeros(len(at)))
        return np.asarray(drawn.columns(at) * member[:, None, None])

    physics = f"{drawn.physics.rstrip('.')}, in the run '{run}' alone."
    return replace(drawn, name=f"{drawn.name}:{run}", columns=columns, physics=physics)
