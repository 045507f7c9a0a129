"""The specific force on the turning plate against gravity.

The accelerometer is calibrated on poses at rest. On the plate it senses gravity g and, across it,
the centripetal ``Ω² r`` at r metres from the spindle, so that ``|f|`` lies between g and
``hypot(g, Ω² r)`` whatever the attitude; where the plate leans, g is its part along the axis. Where
``|f|`` lies outside, one of the two sets of logs is not what it seems. Each common mistake (axes
exchanged or mirrored, counts halved, another unit) is undone in turn; with n poses it explains the
contradiction better by the log likelihood ratio ``n/2 ln(S_as_logged / S_undone)`` of the mean
squares S of ``|f| - g``. It is named where this exceeds the logarithm of the number of trials over
``FALSE_ALARM``. The uncertainty of the calibration in these poses (its misfit in its own poses, an
effect that these hardly determine) contradicts nothing.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from calib.consistency.signed_axes import IDENTITY, SIGNED_PERMUTATIONS, permutation_words
from calib.earth import STANDARD_GRAVITY_M_S2
from calib.errors import Contradiction
from calib.fit.triad.calibration import TriadCalibration
from calib.poses.checks.frozen import CERTAIN_SD, FALSE_ALARM
from calib.poses.data_sheet import LARGEST_DRIFT
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.pose_set import PoseSet
from calib.poses.samples.in_step import FEWEST_TURNS

PLATE_RADIUS_M = 0.15  #: m; fact: of a record
FEWEST_POSES = 3  #: fewest poses of a run; derived: the median of fewer is that of one pose

_RANGES = {2.0: "halved", 0.5: "doubled", 4.0: "a quarter", 0.25: "fourfold", 8.0: "an eighth",
           0.125: "eightfold"}
_G = STANDARD_GRAVITY_M_S2
FACTORS: Mapping[Triad, Mapping[float, str]] = {
    "accelerometer": {
        **_RANGES, _G: "in g instead of m/s²", 1 / _G: "in m/s² instead of g",
        1e-3: "in mg instead of g", 1e3: "in g instead of mg", 1e-3 * _G: "in mg instead of m/s²",
    },
    "gyroscope": {**_RANGES, np.pi / 180: "in °/s instead of rad/s",
                  180 / np.pi: "in rad/s instead of °/s"},
}
"""Matrices that undo a common mistake of range, unit or bits, and the mistakes in words."""

WITHIN_A_SESSION = 0.006
"""Share of gravity. Derived: 0.02 %/K of gain and 0.5 to 0.9 mg/K of offset (MPU-6050) make
0.55 % over the 5 K that a sensor warms by between runs; units of one type differ by 1 to 5 %."""

NOTICEABLE = 5e-4
"""Share of gravity that noise, placement and warmth leave in a good session; a mistake that changes
less than this goes unnoticed and does as little harm. A judgement."""


def require_gravity(
    poses: PoseSet, accelerometer: TriadCalibration, gravity_m_s2: float
) -> None:
    """Refuse runs of the gyro in which the accelerometer does not read gravity.

    Parameters
    ----------
    poses : PoseSet
        Of the gyro, with the calibrated specific force.
    accelerometer : TriadCalibration
    gravity_m_s2 : float

    Raises
    ------
    Contradiction
        Naming the run, what it reads, and the mistake that explains it if one does.
    """
    runs = np.array(poses.run)
    sound = np.isfinite(poses.force).all(axis=1)
    for name in dict.fromkeys(runs[sound]):
        member = np.flatnonzero(sound & (runs == name))
        if len(member) >= FEWEST_POSES:
            _check_run(str(name), _Force(poses.take(member), accelerometer, gravity_m_s2))


@dataclass(frozen=True, eq=False)
class _Force:
    """The calibrated specific force in n poses of the gyroscope, beside ``gravity``, m/s²."""

    poses: PoseSet
    accelerometer: TriadCalibration
    gravity: float

    @property
    def nominal(self) -> FloatArray:
        """Nominal readings, (n, 3)."""
        assert self.poses.other_reading is not None  # only ideal poses have none
        return self.poses.other_reading

    def sizes(self, readings: FloatArray) -> FloatArray:
        """Magnitudes (n,) of the force by nominal readings (n, 3)."""
        at = self.poses.accelerometer_conditions(readings)
        return np.asarray(np.linalg.norm(self.accelerometer.correct(at), axis=1))

    @cached_property
    def unknown(self) -> FloatArray:
        """Uncertainty of the magnitudes by the calibration, (n,).

        It combines the covariance of the parameters with the model's misfit in its own poses.
        """
        at = self.poses.accelerometer_conditions(self.nominal)
        cov = self.accelerometer.covariance_of(
            lambda correction: np.asarray(np.linalg.norm(correction.correct(at), axis=1)))
        fitted = self.accelerometer.fit
        misfit = np.linalg.norm(fitted.rows.vector, axis=1) - fitted.poses.reference.magnitude
        return np.asarray(np.sqrt(np.maximum(np.diag(cov), 0.0) + np.mean(misfit**2)))

    def misfit(self, readings: FloatArray) -> FloatArray:
        """Distance (n,) of magnitudes from those that gravity and the plate allow.

        These are wider by ``CERTAIN_SD`` of the calibration.
        """
        poses, unknown = self.poses, CERTAIN_SD * self.unknown
        lean = 1.0 if poses.ring is None else float(np.cos(poses.ring.tilt_rad).mean())
        size = self.sizes(readings) / lean
        largest = np.hypot(self.gravity, poses.spin_rad_s**2 * PLATE_RADIUS_M) + unknown
        return np.asarray(np.maximum(size - largest, 0)
                          + np.minimum(size - self.gravity + unknown, 0))

    def leaning_advice(self) -> str:
        """Advice if the force is small in a run because the plate leans.

        "" where no run looks so: the rotating part of gravity is known already.
        """
        runs, size, sentences = np.array(self.poses.run), self.sizes(self.nominal), []
        for name in dict.fromkeys(self.poses.run if self.poses.ring is None else ()):
            of_run = size[runs == name] / self.gravity
            least, varies = float(np.median(of_run)), float(np.std(of_run))
            turned = self.poses.spin_rad_s[runs == name].all()
            if turned and least < 1 - WITHIN_A_SESSION and varies < WITHIN_A_SESSION:
                sentences.append(
                    f"All poses of {name} read so, as on a plate that leans by "
                    f"{np.degrees(np.arccos(least)):.0f}°: if it does, log each for at least "
                    f"{FEWEST_TURNS} whole turns, which show that gravity goes round, and let no "
                    f"cable turn the case. ")
        return "".join(sentences)


def _check_run(run: str, force: _Force) -> None:
    as_logged, gravity = force.misfit(force.nominal), force.gravity
    off = float(np.sqrt(np.mean(as_logged**2)))
    impossible = float(np.median(np.abs(as_logged))) > LARGEST_DRIFT * gravity
    if off <= LARGEST_DRIFT * gravity:
        return  # a sensor that drifted can look like one with a mirrored axis
    likely = _likely_mistake(force, as_logged, only_axes=not impossible)
    if likely is None and not impossible:
        return
    kind = "on the turning plate" if force.poses.spin_rad_s.any() else "with the plate stopped"
    leans = force.leaning_advice()
    raise Contradiction(
        f"{run}: in its poses {kind} the calibrated accelerometer reads "
        f"{np.median(force.sizes(force.nominal)):.4g} m/s² (median) where gravity is "
        f"{gravity:.4g} m/s², off by {off / gravity:.2g} of it (root mean square). "
        + (likely or f"{leans}{'Else its' if leans else 'Its'} logs and those of the "
           f"accelerometer's own poses are of another sensor, range, unit or order of columns. "
           f"Compare the files of both.")
    )


def force_notes(
    poses: PoseSet, accelerometer: TriadCalibration, gravity_m_s2: float
) -> tuple[str | None, str | None]:
    """Two notes on the calibrated accelerometer in the poses of the gyro, each a text or None.

    The first: its calibration hardly holds there, since an effect of its model depends on
    conditions that its own poses did not have, so that nothing can be compared with the specific
    force. The second: it deviates by more than warmth within a session explains, and by too little
    for :func:`require_gravity`. The arguments are those of that function.
    """
    sound = np.flatnonzero(np.isfinite(poses.force).all(axis=1))
    if not sound.size:
        return None, None
    force = _Force(poses.take(sound), accelerometer, gravity_m_s2)
    hardly, off = None, None
    sd = float(force.unknown.max())
    if CERTAIN_SD * sd >= LARGEST_DRIFT * STANDARD_GRAVITY_M_S2:
        hardly = (
            f"in the poses of the gyroscope the accelerometer's model determines the specific "
            f"force to {sd:.2g} m/s² only: it leaves as much in its own poses, or an effect in it "
            f"goes far beyond them. The axes of the triads were not compared, and effects of the "
            f"specific force on the gyroscope are as uncertain."
        )
    share = float(np.sqrt(np.mean(force.misfit(force.nominal) ** 2))) / gravity_m_s2
    if share > WITHIN_A_SESSION and sound.size >= FEWEST_POSES and poses.ring is None:
        off = (
            f"in the poses of the gyroscope the calibrated accelerometer reads "
            f"{np.median(force.sizes(force.nominal)):.5g} m/s² (median) where gravity is "
            f"{gravity_m_s2:.5g} m/s², off by {100 * share:.2g} % (root mean square), more than a "
            f"sensor drifts within a session. {force.leaning_advice()}Are the poses at rest those "
            f"of another unit, another range or another day? Record both with the same sensor."
        )
    return hardly, off


def _likely_mistake(force: _Force, as_logged: FloatArray, *, only_axes: bool) -> str | None:
    """The mistake that explains the contradiction, in words."""
    factors = [1.0] if only_axes else [1.0, *FACTORS["accelerometer"]]
    looks = [(i, f) for i, f in product(range(len(SIGNED_PERMUTATIONS)), factors)
             if (i, f) != (IDENTITY, 1.0)]
    squares = np.array([
        np.mean(force.misfit(f * force.nominal @ SIGNED_PERMUTATIONS[i].T) ** 2)
        for i, f in looks])
    least = (NOTICEABLE * force.gravity) ** 2
    best = int(np.argmin(squares))
    before = float(np.mean(as_logged**2))
    gained = len(as_logged) / 2 * np.log((before + least) / (squares[best] + least))
    if gained < np.log(len(looks) / FALSE_ALARM):
        return None
    i, factor = looks[best]
    parts = []
    if i != IDENTITY:
        parts.append(permutation_words(SIGNED_PERMUTATIONS[i].T))
    if factor != 1.0:
        parts.append(f"the readings are {FACTORS['accelerometer'][factor]}")
    return (
        f"It fits if {' and '.join(parts)} in the accelerometer of these poses, or the other way "
        f"round in those at rest. Bring both to the same columns, range and unit."
    )
