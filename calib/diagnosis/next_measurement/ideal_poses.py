"""Readings of a perfect sensor in planned poses, with the sds that real readings would have."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from calib.fit.rows.initial_estimate import Start
from calib.poses.averaging.mean_noise import NOISE_DOF_PER_POSE, noise_sd
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.pose_set import PoseSet
from calib.poses.reference import CommonError, constant_reference, join_references
from calib.poses.runs.ideal_ring import ideal_ring, up_round_axis
from calib.poses.runs.pose_run import known_attitudes
from calib.poses.runs.ring import Ring, rings_of


@dataclass(frozen=True, eq=False)
class PlannedRun:
    """Poses at one setting of the plate, to be recorded or recorded already.

    Parameters
    ----------
    name : str
    up : array, shape (n, 3)
        Side of the sensor that faces up in each pose.
    magnitude : float
        Gravity in m/s², the plate's rate in rad/s, or 0 for a gyro at rest.
    spin_rad_s : float
        The plate's rate, positive counter-clockwise seen from above.
    sd : array, shape (3,)
        Of the mean of a pose, SI.
    reference_sd : float
        Uncertainty of each pose's reference that is independent of the others, SI.
    common : tuple of CommonError
        What the references have in common.
    force_m_s2 : float
        Gravity where the accelerometer is logged too, NaN where it is not.
    time_s : array, shape (n,)
        Times of the poses, s since the session began.
    vibration : array, shape (n, 3), or None
        Variance of the accelerometer within the poses, (m/s²)²; none by default.
    columns : mapping of name to array, shape (n,)
        The logged columns.
    tilt_rad : float
        Angle of the axis of the turning poses to gravity; ``up`` then points along that axis.
    attitude_sd_rad : float or None
        Expected sd of the attitude of the case; None where it will not be known.
    """

    name: str
    up: FloatArray
    magnitude: float
    spin_rad_s: float
    sd: FloatArray
    reference_sd: float
    common: tuple[CommonError, ...]
    force_m_s2: float
    time_s: FloatArray
    vibration: FloatArray | None = None
    columns: Mapping[str, FloatArray] = field(default_factory=dict)
    tilt_rad: float = 0.0
    attitude_sd_rad: float | None = None

    def turned(self, up: FloatArray, time_s: FloatArray) -> "PlannedRun":
        """Other poses at the same setting, with the same vibration and columns.

        Parameters
        ----------
        up : array, shape (n, 3)
            Unit vectors, the direction that faces up.
        time_s : array, shape (n,)
            When each is taken, s since the session began.
        """
        n = len(up)
        return replace(
            self, up=up, time_s=time_s,
            vibration=None if self.vibration is None else np.resize(self.vibration, (n, 3)),
            columns={name: np.resize(values, n) for name, values in self.columns.items()},
        )


def one_second_sd(runs: Sequence[Sequence[PoseMean]], triad: Triad) -> FloatArray:
    """Sd of a mean over one second, from recorded poses; that of a mean over T falls as 1/√T.

    Correlation of the samples is included, as in the sds of the poses themselves.

    Parameters
    ----------
    runs : sequence of sequence of PoseMean
        The poses of each run.
    triad : str
        ``accelerometer`` or ``gyroscope``.

    Returns
    -------
    array, shape (3,)
        Median over the poses, m/s² or rad/s.
    """
    sd = noise_sd(runs, triad)
    duration_s = np.array([mean.duration_s for means in runs for mean in means])
    density = sd**2 * duration_s[:, None]
    return np.asarray(np.sqrt(np.median(density, axis=0)))


def expected_widening(poses: int) -> float:
    """Student's factor by which sds estimated from this many poses will be stated wider.

    Parameters
    ----------
    poses : int
        Number of poses.

    Returns
    -------
    float
        Sd of Student's t, ``sqrt(dof / (dof - 2))``, with the noise's degrees of freedom.
    """
    dof = NOISE_DOF_PER_POSE * poses
    return float(np.sqrt(dof / max(dof - 2, 1.0)))


def ideal_poses(
    triad: Triad, runs: Sequence[PlannedRun], sensor: Start | None = None
) -> PoseSet:
    """Readings of a sensor without errors in the planned poses.

    Parameters
    ----------
    triad : str
        ``accelerometer`` or ``gyroscope``.
    runs : sequence of PlannedRun
        Their sds are in the nominal units of the readings.
    sensor : Start or None
        Its gains and offsets by recorded poses; without them those of its data sheet.

    Returns
    -------
    PoseSet
        With the logged columns that all runs have.
    """
    def joined(rows: list[FloatArray]) -> FloatArray:
        return np.concatenate(rows)

    def ring_of(run: PlannedRun, mean: FloatArray) -> Ring | None:
        if not run.tilt_rad or not np.isfinite(run.force_m_s2):
            return None
        gravity = run.force_m_s2 * up_round_axis(run.up, run.tilt_rad)
        goes_round = triad == "accelerometer"
        reading = readings_of(gravity.reshape(-1, 3), sensor).reshape(gravity.shape)
        return ideal_ring(run.up, run.tilt_rad, run.force_m_s2, reading if goes_round else mean,
                          np.tile(run.sd, (len(run.up), 1)), of_gravity=goes_round)

    sense = [np.sign(run.spin_rad_s) if triad == "gyroscope" else 1.0 for run in runs]
    zeros = joined([np.zeros_like(run.up) for run in runs])
    shared = set.intersection(*(set(run.columns) for run in runs))
    readings = [readings_of(sign * run.magnitude * run.up, sensor)
                for run, sign in zip(runs, sense, strict=True)]
    up, up_sd_rad = known_attitudes([
        (len(run.up), None if run.attitude_sd_rad is None else run.up, run.attitude_sd_rad or 0.0)
        for run in runs])
    return PoseSet(
        triad=triad,
        label=tuple(f"{run.name} {i + 1}" for run in runs for i in range(len(run.up))),
        run=tuple(run.name for run in runs for _ in run.up),
        reading=joined(readings),
        sd=joined([np.tile(run.sd, (len(run.up), 1)) for run in runs]),
        force=joined([run.force_m_s2 * np.cos(run.tilt_rad) * run.up for run in runs]),
        vibration=joined([np.zeros_like(run.up) if run.vibration is None else run.vibration
                          for run in runs]),
        spin_rad_s=joined([np.full(len(run.up), run.spin_rad_s) for run in runs]),
        time_s=joined([run.time_s for run in runs]),
        expected=zeros,
        reference=join_references([
            constant_reference(len(run.up), run.magnitude, run.common, run.reference_sd)
            for run in runs
        ]),
        columns={name: joined([run.columns[name] for run in runs]) for name in sorted(shared)},
        up=up, up_sd_rad=up_sd_rad,
        ring=rings_of([(ring_of(run, mean), len(run.up))
                       for run, mean in zip(runs, readings, strict=True)]),
    )


def readings_of(vectors: FloatArray, sensor: Start | None) -> FloatArray:
    """Nominal readings y (n, 3), SI, of true vectors s, from ``s = M y + c``."""
    if sensor is None:
        return vectors
    return np.asarray(np.linalg.solve(sensor.matrix, (vectors - sensor.offset).T).T)
