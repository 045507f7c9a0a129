"""Readings of poses on a leaning plate over one turn, and the known quantities.

While the plate turns, gravity rotates in the sensor's axes and a pose passes through a ring of
attitudes. The ring is the mean and the waves once and twice per turn
(:mod:`calib.poses.samples.in_step`), evaluated at ``ANGLES`` angles: an effect defined for poses is
defined for its points, and its waves are their harmonics.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.numbers import NO_LENGTH
from calib.poses.averaging.pose_mean import PoseMean, TriadMean
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray, IntArray, Triad
from calib.poses.rows import RowIndex, Rows, joined
from calib.poses.samples.in_step import HARMONICS, Waves

ANGLES = 8
"""Number of angles in one turn. Derived: an effect of third order in gravity makes waves up to
three times per turn, and eight points separate the first from all up to the sixth."""

LEAST_TILT_RAD = float(np.radians(1.5))
"""Derived: 18 poses of 20 s of an MPU-6050 then show an element of its g-sensitivity to 0.1 °/s per
g, its typical size (``python -m tests.bench.study_tilt``). A plate that is more level says nothing
of it, and its waves are left alone."""

OUT_OF_ROUND = 0.15
"""Share of the wave: gravity goes round in a circle but for the gains, which data sheets state to a
few per cent; what does not is a case that rocks or a cable that tugs. A judgement."""

DISTURBED = 4.0
"""Multiple of the typical noise of a run: a noisier pose was disturbed and keeps its own. Derived:
by chance one axis in 2500 is (chi-square with eight degrees of freedom)."""

DIRECTION_SD_RAD = 0.03
"""Sd of the tilt, and of each angle between the frames, by an accelerometer that is not calibrated
yet. Derived: gains and biases of a few per cent; wide enough that the rows alone decide."""

ROUND = 2 * np.pi * np.arange(ANGLES) / ANGLES  #: rad; definition
TO_WAVES = np.stack([f(h * ROUND) for h in HARMONICS for f in (np.cos, np.sin)]) * 2 / ANGLES
"""From the points of a ring to the amplitudes of cosine and sine once per turn and of cosine and
sine twice per turn, (4, k). Definition."""
TO_WAVE = TO_WAVES[:2]  #: the amplitudes once per turn, (2, k); definition


@dataclass(frozen=True, eq=False)
class Ring(Rows):
    """The rings of w poses of a set.

    Attributes
    ----------
    place : array of int, shape (w,)
        Which poses of the set.
    reading : array, shape (w, k, 3)
        Nominal, SI, at the angles ``ROUND``.
    force : array, shape (w, k, 3)
        Calibrated specific force there, m/s².
    sd : array, shape (w, 2, 3)
        Of the amplitudes once and twice per turn of the reading, nominal SI; NaN of those twice per
        turn that make no rows.
    tilt_rad : array, shape (w,)
        Of the axis of the plate against gravity, that of the run.
    gravity_m_s2 : array, shape (w,)
        What goes round in an accelerometer, NaN of a gyroscope.
    room_rad_s : array, shape (w,)
        Sd of each horizontal component of what is fixed in the room and turns: the Earth.
    vertical_rad_s : array, shape (w,)
        Vertical part of the Earth's rate, as far as it is known.
    force_sd : array, shape (w,)
        Of the amplitudes of the specific force, m/s².
    axis : array, shape (w, 3)
        Unit vector about which gravity goes round, up, by the calibrated accelerometer; NaN where
        it is not calibrated.
    axis_moved : array, shape (w, 3, a)
        By how much an sd of each of its a errors moves the axis.
    wow : array, shape (w, 4)
        Cosine and sine once per turn and twice per turn of the rate of the plate, relative to it;
        0 where no gyroscope shows it.
    """

    place: IntArray
    reading: FloatArray
    force: FloatArray
    sd: FloatArray
    tilt_rad: FloatArray
    gravity_m_s2: FloatArray
    room_rad_s: FloatArray
    vertical_rad_s: FloatArray
    force_sd: FloatArray
    axis: FloatArray
    axis_moved: FloatArray
    wow: FloatArray

    @property
    def twice(self) -> IntArray:
        """Indices of the rings that have rows of the waves twice per turn, (v,)."""
        return np.flatnonzero(np.isfinite(self.sd[:, 1]).all(axis=1))

    def of_poses(self, rows: RowIndex, count: int) -> "Ring | None":
        """The rings of some poses of a set of ``count``, in their new order."""
        index = np.arange(count)[rows]
        where = np.full(count, -1)
        where[self.place] = np.arange(len(self.place))
        kept = where[index]
        return self._of(kept[kept >= 0], np.flatnonzero(kept >= 0))

    def only(self, which: IntArray) -> "Ring | None":
        """Some of the w rings, in their poses."""
        return self._of(which, self.place[which])

    def _of(self, which: IntArray, place: IntArray) -> "Ring | None":
        return replace(self.take(which), place=place) if len(which) else None

    def whole(self, magnitude: FloatArray) -> FloatArray:
        """Reference magnitudes (n,) of the set, all of gravity where it rotates, SI."""
        of_all = magnitude.copy()
        goes_round = np.isfinite(self.gravity_m_s2)
        of_all[self.place[goes_round]] = self.gravity_m_s2[goes_round]
        return of_all

    def evaluated(
        self, at: Conditions, correct: Callable[[Conditions], FloatArray], run: Sequence[str]
    ) -> "Ring":
        """The same rings with the nominal specific force corrected, and the tilt of each run by it.

        Parameters
        ----------
        at : Conditions
            Of the accelerometer in the poses of the set.
        correct : callable
            The calibration of the accelerometer.
        run : sequence of str
            Of the poses of the set.
        """
        points = at.take(np.repeat(self.place, ANGLES))
        force = correct(points.with_vector(self.force.reshape(-1, 3))).reshape(self.force.shape)
        tilt, _ = leans_of(force)
        runs = np.array(run)[self.place]
        tilt = np.array([tilt[runs == name].mean() for name in runs])
        return replace(self, force=force, tilt_rad=tilt)

    def behind(self, count: int) -> "Ring":
        """The same rings with ``count`` poses before those of the set."""
        return replace(self, place=self.place + count)

    def _moved_by(self, errors: int) -> "Ring":
        """The same rings, their axes moved by as many ``errors``, by those that are new not at all.
        """
        new = np.zeros((*self.axis.shape, errors - self.axis_moved.shape[2]))
        return replace(self, axis_moved=np.concatenate([self.axis_moved, new], axis=2))


def joined_rings(first: Ring | None, other: Ring | None) -> Ring | None:
    """The rings of two sets one after another; ``place`` of both as they then stand.

    An axis that no accelerometer gave, as in a planned pose, is moved by no error of it.
    """
    if first is None or other is None:
        return first or other
    errors = max(first.axis_moved.shape[2], other.axis_moved.shape[2])
    return joined([each._moved_by(errors) for each in (first, other)])


def rings_of(parts: Sequence[tuple[Ring | None, int]]) -> Ring | None:
    """The rings of runs, each with its number of poses, one after another."""
    whole, before = None, 0
    for ring, poses in parts:
        whole = joined_rings(whole, ring and ring.behind(before))
        before += poses
    return whole


def leans_of(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Tilt of the axis about which gravity rotates, and the mean force across it.

    Parameters
    ----------
    points : array, shape (w, k, 3)
        Calibrated specific force at the angles ``ROUND``, m/s².

    Returns
    -------
    tilt, across : array, shape (w,)
        rad, m/s².
    """
    mean = points.mean(axis=1)
    wave = np.tensordot(points, TO_WAVE, axes=(1, 1)).transpose(0, 2, 1)  # (w, 2, 3)
    axis = np.cross(wave[:, 0], wave[:, 1])
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    along = (mean * axis).sum(axis=1, keepdims=True)
    across = np.linalg.norm(mean - along * axis, axis=1)
    return np.arctan2(np.sqrt((wave**2).sum(axis=(1, 2)) / 2), np.abs(along[:, 0])), across


def tilt_of_run(means: Sequence[PoseMean]) -> float | None:
    """Tilt of the plate's axis against gravity, by the nominal accelerometer.

    Parameters
    ----------
    means : sequence of PoseMean
        Of one run.

    Returns
    -------
    float or None
        rad, the median over the poses; None where their accelerometers do not show it.
    """
    tilts = [_tilt(mean.accelerometer.mean, mean.accelerometer.waves)
             for mean in means if mean.accelerometer.waves is not None]
    return float(np.median(tilts)) if tilts else None


def _tilt(mean: FloatArray, waves: Waves) -> float:
    across = np.sqrt((waves.amplitude[0] ** 2).sum() / 2)
    return float(np.arctan2(across, np.linalg.norm(mean)))


def _is_round(waves: Waves) -> bool:
    """Whether gravity rotates in a circle: equal cosine and sine, orthogonal to each other."""
    cosine, sine = waves.amplitude[0]
    square = (cosine @ cosine + sine @ sine) / 2
    return bool(abs(cosine @ cosine - sine @ sine) < 2 * OUT_OF_ROUND * square
                and abs(cosine @ sine) < OUT_OF_ROUND * square)


def is_leaning(means: Sequence[PoseMean]) -> bool:
    """Whether the plate of a run leans enough for its waves to be useful."""
    tilt = tilt_of_run(means)
    return tilt is not None and tilt >= LEAST_TILT_RAD


def ring_of_run(
    means: Sequence[PoseMean], triad: Triad, tilt_rad: float | None = None,
    gravity_m_s2: float = np.nan, room_rad_s: float = np.nan, vertical_rad_s: float = 0.0,
) -> Ring | None:
    """The rings of the poses of one run; their specific force is nominal.

    Parameters
    ----------
    means : sequence of PoseMean
    triad : str
    tilt_rad : float, optional
        Where it is known better than by the nominal accelerometer.
    gravity_m_s2, room_rad_s, vertical_rad_s : float
        As of :class:`Ring`.

    Returns
    -------
    Ring or None
        None where the plate is level, or was not seen to go round in every pose.
    """
    if not is_leaning(means):
        return None
    tilt = tilt_of_run(means) if tilt_rad is None else tilt_rad
    used = [i for i, mean in enumerate(means)
            if mean.accelerometer.waves is not None and mean.of(triad).waves is not None
            and _is_round(mean.accelerometer.waves)]
    if not used:
        return None
    of_triad = [getattr(means[i], triad) for i in used]
    reading = np.array([_points(each.mean, each.waves) for each in of_triad])
    force = np.array([_points(means[i].accelerometer.mean, means[i].accelerometer.waves)
                      for i in used])
    sd = _steadied([each.waves for each in of_triad])
    if triad == "gyroscope":  # nothing in the catalogue that it shows twice per turn
        sd[:, 1] = np.nan
    of_force = _steadied([means[i].accelerometer.waves for i in used])[:, 0]
    tilts, gravity, room, vertical = (
        np.full(len(used), value) for value in (tilt, gravity_m_s2, room_rad_s, vertical_rad_s))
    return Ring(np.array(used), reading, force, sd, tilts, gravity, room, vertical,
                force_sd=np.sqrt((of_force**2).mean(axis=1)),
                axis=np.full((len(used), 3), np.nan), axis_moved=np.zeros((len(used), 3, 0)),
                wow=np.array([_wow(means[i].gyroscope) for i in used]))


def _wow(mean: TriadMean) -> FloatArray:
    """The waves along the axis of a pose's rate over that rate, (4,): no gain of an axis matters.
    """
    if mean.waves is None:
        return np.zeros(len(TO_WAVES))
    along = mean.waves.amplitude.reshape(-1, 3) @ mean.mean
    return np.asarray(along / max(float(mean.mean @ mean.mean), NO_LENGTH))


def _steadied(waves: Sequence[Waves | None]) -> FloatArray:
    """Sds (w, 2, 3) of the amplitudes of poses: those of all, but of a disturbed one its own."""
    variance = np.array([each.variance for each in waves if each is not None])
    usual = np.median(variance, axis=0)
    usual = variance.mean(axis=0, where=variance <= DISTURBED * usual)
    return np.sqrt(np.where(variance > DISTURBED * usual, variance, usual))


def _points(mean: FloatArray, waves: Waves | None) -> FloatArray:
    """Readings (k, 3) at the angles ``ROUND``."""
    assert waves is not None
    return np.asarray(mean + TO_WAVES.T @ waves.amplitude.reshape(-1, 3) * ANGLES / 2)
