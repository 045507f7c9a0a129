"""The poses of one triad, ready to be fitted: readings, their sds, references and covariates."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from calib.poses.averaging.common_course import CommonCourse
from calib.poses.averaging.mean_noise import (
    NOISE_DOF_PER_POSE,
    common_courses,
    pose_mean_sd,
    sd_dof,
    too_short,
)
from calib.poses.averaging.pose_mean import on_one_clock
from calib.poses.averaging.sway import shaken
from calib.poses.conditions import OTHER_TRIAD, RUN_COLUMN, Conditions
from calib.poses.imu_log import BoolArray, FloatArray, IntArray, Triad
from calib.poses.reference import Reference, join_references
from calib.poses.rows import RowIndex, Rows, joined
from calib.poses.runs.pose_run import PoseRun, check_alive, known_attitudes
from calib.poses.runs.ring import Ring, joined_rings, rings_of


@dataclass(frozen=True, eq=False)
class PoseSet(Rows):
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
        Mid time since the session began; NaN when the logs' clocks do not show the order.
    expected : array, shape (n, 3)
        What a null pose should read (the Earth's rate where it is known), SI; 0 otherwise.
    reference : Reference
        Magnitudes and their sds.
    columns : mapping of name to array, shape (n,)
        Pose means of the logged columns.
    notes : tuple of str
        Why some of the sds may not hold.
    other_reading : array, shape (n, 3), or None
        Mean nominal reading of the other triad, NaN where not logged. Ideal poses have None: what
        the other triad reads follows from the plate and from gravity.
    run_time_s : array, shape (n,), or None
        Mid time on the clock of the pose's own run; NaN in runs whose logs do not show the order,
        None for ideal poses.
    up, up_sd_rad : array, shapes (n, 3) and (n,), or None
        The vertical in the axes of the case, where it is known how that lay, and the sd of each of
        its two angles; NaN in other poses, None where none was laid so.
    sd_dof : float or None
        Degrees of freedom behind ``sd`` where it does not come from the poses' own samples.
    ring : Ring or None
        What poses on a leaning plate read all round one turn; None where none does.
    duration_s : array, shape (n,), or None
        How long each pose was logged; 0 for means of a table, None for ideal poses.
    courses : tuple of CommonCourse
        What the poses of each length have in common within them.
    stated : PoseSet or None
        The poses with their sds as they were stated, where these contain what is drawn
        (:mod:`calib.fit.least_squares.widened`).
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
    notes: tuple[str, ...] = ()
    other_reading: FloatArray | None = None
    run_time_s: FloatArray | None = None
    up: FloatArray | None = None
    up_sd_rad: FloatArray | None = None
    sd_dof: float | None = None
    ring: Ring | None = None
    duration_s: FloatArray | None = None
    courses: tuple[CommonCourse, ...] = ()
    stated: "PoseSet | None" = None

    def __len__(self) -> int:
        return len(self.label)

    def take(self, rows: RowIndex) -> "PoseSet":
        """These poses alone, in this order; a pose may be taken more than once."""
        index = np.arange(len(self))[rows]
        return replace(
            Rows.take(replace(self, ring=None, stated=None), index),
            label=tuple(self.label[i] for i in index),
            run=tuple(self.run[i] for i in index),
            ring=self.ring and self.ring.of_poses(index, len(self)),
        )

    def concat(self, other: "PoseSet") -> "PoseSet":
        """These poses followed by those of ``other``, with the columns that both have.

        Common errors of the same name are the same error.
        """
        return replace(
            joined([self, other]),
            label=self.label + other.label,
            run=self.run + other.run,
            reference=join_references([self.reference, other.reference]),
            notes=tuple(dict.fromkeys((*self.notes, *other.notes))),
            stated=None,
            ring=joined_rings(self.ring, other.ring and other.ring.behind(len(self))),
        )

    @property
    def as_stated(self) -> "PoseSet":
        """The poses with their sds as they were stated."""
        return self.stated or self

    @property
    def noise_dof(self) -> float:
        """Degrees of freedom behind ``sd``: the uncertainty of the noise itself."""
        if self.sd_dof is not None:
            return self.sd_dof
        return NOISE_DOF_PER_POSE * len(self)

    @property
    def before(self) -> IntArray:
        """Index of the pose recorded before each pose, -1 for the first, shape (n,)."""
        order = np.argsort(self.time_s, kind="stable")
        before = np.full(len(self), -1)
        before[order[1:]] = order[:-1]
        return before

    @cached_property
    def shares_rate(self) -> BoolArray:
        """Whether a turning pose has no rate of its own, by a clip taken with it, (n,)."""
        reference = self.reference
        of_setting = [name in reference.of_setting for name in reference.common_names]
        in_common = (reference.sd == 0) | reference.common[:, of_setting].any(axis=1)
        return np.asarray(~reference.is_null & in_common)

    @cached_property
    def turning_s(self) -> tuple[float, float]:
        """Times of the first and the last pose of a common rate, s; NaN where they are not known.
        """
        turning = self.time_s[self.shares_rate]
        return (float(turning.min()), float(turning.max())) if len(turning) else (0.0, 0.0)

    def conditions(self, vector: FloatArray, sensed: FloatArray | None = None) -> Conditions:
        """Conditions at which effects are evaluated.

        Parameters
        ----------
        vector : array, shape (n, 3)
            The triad's vectors, SI.
        sensed : array, shape (n, 3), optional
            What each axis sensed, for the memory of the pose before; by default ``vector``.
        """
        before = self.before
        remembers = (before >= 0) & ~self.reference.is_null[before]  # rest leaves no memory
        sensed = vector if sensed is None else sensed
        previous = np.where(remembers[:, None], sensed[before], 0.0)
        return Conditions(
            vector=vector,
            magnitude=(self.ring.whole if self.ring else np.asarray)(self.reference.magnitude),
            force=self.force,
            spin_rad_s=self.spin_rad_s,
            time_s=self.time_s,
            since_middle_s=np.where(self.shares_rate, self.time_s - sum(self.turning_s) / 2, 0.0),
            previous=previous if np.isfinite(self.time_s).all() else np.full_like(vector, np.nan),
            vibration=self.vibration,
            columns={**self.columns, **self._unlogged(vector)},
        )

    def accelerometer_conditions(self, force: FloatArray) -> Conditions:
        """Conditions of effects on the accelerometer in poses of the gyro.

        ``force`` (n, 3) are its nominal readings; the other triad is then the gyro.
        """
        at = self.conditions(force)
        other = dict(zip(OTHER_TRIAD, self.reading.T, strict=True))
        return replace(at, columns={**at.columns, **other})

    def _unlogged(self, vector: FloatArray) -> dict[str, FloatArray]:
        """The other triad's reading and the run of each pose, each (n,)."""
        other = self.other_reading
        if other is None and self.triad == "gyroscope":
            other = self.force
        elif other is None:
            length = np.linalg.norm(vector, axis=1, keepdims=True)
            other = self.spin_rad_s[:, None] * vector / np.where(length > 0, length, 1.0)
        return {**dict(zip(OTHER_TRIAD, other.T, strict=True)), **self._members}

    @cached_property
    def _members(self) -> dict[str, FloatArray]:
        run = np.array(self.run)
        return {RUN_COLUMN + name: (run == name).astype(float) for name in dict.fromkeys(run)}


def pose_set(
    triad: Triad,
    runs: Sequence[PoseRun],
    origin_s: float,
    correct_force: Callable[[Conditions], FloatArray] | None = None,
) -> PoseSet:
    """All runs of one triad as one set, to be fitted jointly.

    Parameters
    ----------
    triad : str
        ``accelerometer`` or ``gyroscope``.
    runs : sequence of PoseRun
    origin_s : float
        When the session began, on the clock of the logs; the poses' times count from there.
    correct_force : callable, optional
        The calibration of the accelerometer, from conditions with its nominal readings (n, 3) to
        the specific force (n, 3) in m/s², on which effects on the gyroscope depend. Without it
        the nominal readings stand.

    Returns
    -------
    PoseSet
        The n poses of all runs, in their order, with the logged columns that all of them have.

    Raises
    ------
    Undetermined
        An axis gives the very same value in all poses.
    FitFailed
        By ``correct_force``: its effects are larger than the readings.
    """
    means = [mean for run in runs for mean in run.means]
    check_alive(means, triad, " and ".join(run.name for run in runs))
    time_s = on_one_clock(means) - origin_s
    names = sorted(set.intersection(*(set(mean.columns) for mean in means)))
    other = "gyroscope" if triad == "accelerometer" else "accelerometer"
    up, up_sd_rad = known_attitudes([(len(run.means), run.up, run.up_sd_rad) for run in runs])
    poses = PoseSet(
        triad=triad,
        label=tuple(mean.label for mean in means),
        run=tuple(run.name for run in runs for _ in run.means),
        reading=np.array([mean.of(triad).mean for mean in means]),
        sd=_mean_sd(runs, triad),
        force=np.array([mean.accelerometer.mean for mean in means]),
        vibration=np.array([mean.accelerometer.scatter for mean in means]),
        spin_rad_s=np.concatenate([run.spin_rad_s for run in runs]),
        time_s=time_s,
        expected=np.concatenate([run.expected for run in runs]),
        reference=join_references([run.reference for run in runs]),
        columns={name: np.array([mean.columns[name] for mean in means]) for name in names},
        notes=_notes(runs, triad),
        other_reading=np.array([mean.of(other).mean for mean in means]),
        run_time_s=np.concatenate([on_one_clock(run.means) for run in runs]),
        up=up, up_sd_rad=up_sd_rad,
        sd_dof=sd_dof([run.means for run in runs if not run.is_stated], triad),
        ring=rings_of([(run.ring, len(run.means)) for run in runs]),
        duration_s=np.array([mean.duration_s for mean in means]),
        courses=common_courses([run.means for run in runs if not run.is_stated], triad),
    )
    if correct_force is None or not np.isfinite(poses.force).all():
        return poses
    at = poses.accelerometer_conditions(poses.force)
    return replace(poses, force=correct_force(at),
                   ring=poses.ring and poses.ring.evaluated(at, correct_force, poses.run))


def _notes(runs: Sequence[PoseRun], triad: Triad) -> tuple[str, ...]:
    """Reasons why the sds of the means may not hold, and the poses that were not at rest."""
    logged = [run for run in runs if not run.is_stated]
    notes = [too_short(run.means, triad, run.name) for run in logged]
    if triad == "accelerometer":
        notes += [shaken(run.means, run.name) for run in logged]
    return tuple(note for note in notes if note)


def _mean_sd(runs: Sequence[PoseRun], triad: Triad) -> FloatArray:
    """Sds (n, 3) of the means of all runs: from their samples, or as a table states them."""
    logged = [run.means for run in runs if not run.is_stated]
    of_logged = iter(pose_mean_sd(logged, triad) if logged else ())
    stated = {id(mean): np.sqrt(mean.of(triad).variance)
              for run in runs if run.is_stated for mean in run.means}
    return np.array([stated[id(mean)] if id(mean) in stated else next(of_logged)
                     for run in runs for mean in run.means])
