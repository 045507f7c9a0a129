"""The poses of one triad, ready to be fitted: readings, their sds, references and covariates."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from calib.errors import Undetermined
from calib.poses.averaging import BATCHES, PoseMean
from calib.poses.conditions import Conditions
from calib.poses.imu_log import AXES, FloatArray, IntArray, Triad
from calib.poses.reference import Reference, join_references

OWN_DOF = BATCHES - 1
POOLED_DOF = 2 * OWN_DOF
"""How many degrees of freedom the other poses' scatter counts for in the sd of one pose."""

LARGEST_TYPICAL = 10.0
"""Poses noisier than this many times the typical variance were disturbed; they say nothing of the
sensor's correlation."""

SIMILAR_LENGTH = 1.3
"""Runs whose poses differ by less than this factor in length share one correlation."""

NOISE_DOF_PER_POSE = 2.0
"""Degrees of freedom that a pose adds to the estimate ``2 v3 - v6`` over three axes."""

MEDIAN_OF_CHI2_5 = 4.3515
"""Median of chi-square with OWN_DOF = 5, to turn a median of variances into a variance."""


@dataclass(frozen=True, eq=False)
class PoseSet:
    """n poses of one triad.

    Parameters
    ----------
    triad : str
        ``accelerometer`` or ``gyroscope``.
    label, run : tuple of str, length n
        What messages call each pose, and the run it belongs to.
    reading, sd : array, shape (n, 3)
        Mean nominal reading (data sheet only) and its sd, SI.
    force : array, shape (n, 3)
        Calibrated specific force of the same pose in m/s²; NaN where not logged.
    vibration : array, shape (n, 3)
        Variance of the accelerometer's samples within the pose, (m/s²)².
    spin_rad_s : array, shape (n,)
        Plate rate, positive counter-clockwise seen from above; 0 when stopped.
    time_s : array, shape (n,)
        Mid time since the session began; NaN when the logs' clocks do not tell the order.
    expected : array, shape (n, 3)
        What a null pose should read (the Earth's rate where it is known), SI; 0 otherwise.
    reference : Reference
        Magnitudes and their sds.
    columns : mapping of name to array, shape (n,)
        Pose means of the logged columns.
    """

    triad: Triad
    label: tuple[str, ...]
    run: tuple[str, ...]
    reading: FloatArray
    sd: FloatArray
    force: FloatArray
    vibration: FloatArray
    spin_rad_s: FloatArray
    time_s: FloatArray
    expected: FloatArray
    reference: Reference
    columns: Mapping[str, FloatArray] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.label)

    @property
    def noise_dof(self) -> float:
        """Degrees of freedom behind ``sd``: how well the noise itself is known."""
        return NOISE_DOF_PER_POSE * len(self)

    @property
    def before(self) -> IntArray:
        """Index of the pose recorded before each pose, -1 for the first, shape (n,)."""
        order = np.argsort(self.time_s, kind="stable")
        before = np.full(len(self), -1)
        before[order[1:]] = order[:-1]
        return before

    def conditions(self, vector: FloatArray, pushed: FloatArray | None = None) -> Conditions:
        """What effects are evaluated on, when the triad's vectors are ``vector`` (n, 3).

        ``pushed`` (n, 3) is what each axis itself felt, for the memory of the pose before;
        ``vector`` where it is not given.
        """
        before = self.before
        remembers = (before >= 0) & ~self.reference.is_null[before]  # rest leaves no memory
        felt = vector if pushed is None else pushed
        previous = np.where(remembers[:, None], felt[before], 0.0)
        return Conditions(
            vector=vector,
            magnitude=self.reference.magnitude,
            force=self.force,
            spin_rad_s=self.spin_rad_s,
            time_s=self.time_s,
            previous=previous if np.isfinite(self.time_s).all() else np.full_like(vector, np.nan),
            vibration=self.vibration,
            columns=self.columns,
        )


def pooled_sd(means: Sequence[PoseMean], triad: Triad) -> FloatArray:
    """Sd of each pose mean by its batches, (n, 3), steadied by those of the run's other poses.

    A pose's own estimate has 5 degrees of freedom, too few to weight by. The typical variance of
    the run, scaled to the length of the pose, is mixed in with twice that weight; being a median,
    it does not follow the few poses that were disturbed.
    """
    own = np.array([getattr(mean, triad).variance for mean in means])
    duration = np.array([mean.duration_s for mean in means])[:, None]
    typical = np.median(own * duration, axis=0) * OWN_DOF / MEDIAN_OF_CHI2_5 / duration
    mixed = (OWN_DOF * own + POOLED_DOF * typical) / (OWN_DOF + POOLED_DOF)
    return np.asarray(np.sqrt(mixed))


def correlation_factor(runs: Sequence[Sequence[PoseMean]], triad: Triad) -> float:
    """By how much the variance of a pose mean exceeds what its BATCHES batches say.

    Where samples stay correlated over a time short against the pose, batches of length L have
    ``V(L) = A/L - B/L²``, and cutting a pose in 6 and in 3 gives estimates v6 and v3 of the
    variance of its mean that fall short by 6 and 3 times the same amount, so that
    ``V = 2 v3 - v6``. The ratio belongs to the sensor and the length of the pose: it is taken over
    all ``runs``, whose poses are alike in length. The last factor is Student's: an sd known with
    few degrees of freedom is wider than it says.
    """
    fine, coarse = 0.0, 0.0
    for means in runs:
        v6 = np.array([getattr(mean, triad).variance for mean in means])
        v3 = np.array([getattr(mean, triad).coarse_variance for mean in means])
        typical = np.maximum(np.median(v6, axis=0), 1e-300)
        disturbed = np.maximum(v6, v3) > LARGEST_TYPICAL * typical
        fine += float(np.where(disturbed, 0.0, v6 / typical).sum())
        coarse += float(np.where(disturbed, 0.0, v3 / typical).sum())
    dof = NOISE_DOF_PER_POSE * sum(len(means) for means in runs)
    student = dof / max(dof - 2, 1.0)
    return student * max(1.0, 2 * coarse / fine - 1) if fine > 0 else 1.0


def correlated_sd(runs: Sequence[Sequence[PoseMean]], triad: Triad) -> FloatArray:
    """Sd of every pose mean of all runs, one after another, correlation included, (n, 3)."""
    length = [float(np.median([mean.duration_s for mean in means])) for means in runs]
    parts = []
    for means, own in zip(runs, length, strict=True):
        alike = [
            other
            for other, its in zip(runs, length, strict=True)
            if 1 / SIMILAR_LENGTH < its / own < SIMILAR_LENGTH
        ]
        parts.append(pooled_sd(means, triad) * np.sqrt(correlation_factor(alike, triad)))
    return np.concatenate(parts)


def check_alive(means: Sequence[PoseMean], triad: Triad, run: str) -> None:
    """Refuse a run in which an axis gave the very same value all the time."""
    spread = np.max([getattr(mean, triad).scatter for mean in means], axis=0)
    values = np.array([getattr(mean, triad).mean for mean in means])
    stuck = (spread == 0) & (np.ptp(values, axis=0) == 0)
    if len(means) > 1 and stuck.any():
        axis = AXES[int(np.argmax(stuck))]
        raise Undetermined(
            f"{run}: {triad} {axis} is stuck: it gives the same value in every sample of all "
            f"{len(means)} poses. Check the wiring, the register settings, or whether the column "
            f"was logged twice."
        )


@dataclass(frozen=True, eq=False)
class Run:
    """Poses recorded under one reference.

    ``spin_rad_s`` (n,) signed plate rate, 0 where stopped; ``expected`` (n, 3) what null poses
    read.
    """

    name: str
    means: Sequence[PoseMean]
    reference: Reference
    spin_rad_s: FloatArray
    expected: FloatArray


def pose_set(
    triad: Triad,
    runs: Sequence[Run],
    origin_s: float,
    correct_force: Callable[[Conditions], FloatArray] | None = None,
) -> PoseSet:
    """All runs of one triad as one set, to be fitted jointly.

    ``correct_force`` is the calibration of the accelerometer, by which its nominal readings become
    the specific force that effects on the gyro depend on; without it they stand as they are.
    """
    for run in runs:
        check_alive(run.means, triad, run.name)
    means = [mean for run in runs for mean in run.means]
    time_s = np.array([mean.time_s for mean in means]) - origin_s
    half = np.array([mean.duration_s for mean in means]) / 2
    order = np.argsort(time_s)
    overlap = (time_s - half)[order][1:] < (time_s + half)[order][:-1] - 1e-6
    if overlap.any():  # every file starts its own clock: the order of the poses is not known
        time_s = np.full(len(means), np.nan)
    names = sorted(set.intersection(*(set(mean.columns) for mean in means)))
    poses = PoseSet(
        triad=triad,
        label=tuple(mean.label for mean in means),
        run=tuple(run.name for run in runs for _ in run.means),
        reading=np.array([getattr(mean, triad).mean for mean in means]),
        sd=correlated_sd([run.means for run in runs], triad),
        force=np.array([mean.accelerometer.mean for mean in means]),
        vibration=np.array([mean.accelerometer.scatter for mean in means]),
        spin_rad_s=np.concatenate([run.spin_rad_s for run in runs]),
        time_s=time_s,
        expected=np.concatenate([run.expected for run in runs]),
        reference=join_references([run.reference for run in runs]),
        columns={name: np.array([mean.columns[name] for mean in means]) for name in names},
    )
    if correct_force is None or not np.isfinite(poses.force).all():
        return poses
    return replace(poses, force=correct_force(poses.conditions(poses.force)))
