"""Warnings where a calibration contradicts the clips, the data sheet, the plate or stated sds."""

from collections.abc import Iterator, Sequence

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.fit.least_squares.result import ONE_SESSION_OF, Fit
from calib.fit.least_squares.unknown_sd import tests_the_model
from calib.fit.parameters import TriadParameters
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import AXES, FloatArray
from calib.poses.pose_set import PoseSet
from calib.poses.triad_kind import TRIAD_KINDS

SHEET_TOLERANCE = 0.3
"""Relative deviation of a gain from its data sheet. Fact: gains lie within a few per cent of most
data sheets; that of the paper's own MTi is 28 % off."""


def turning_while_still(poses: PoseSet) -> Iterator[str]:
    """Warn of poses of the accelerometer in which the gyro shows a turning plate.

    Parameters
    ----------
    poses : PoseSet
        n poses of one triad; those of the gyro give no warning.

    Yields
    ------
    str
        One warning at most.
    """
    turning = np.flatnonzero(poses.spin_rad_s != 0)
    if poses.ring is not None:  # there the waves separate gravity from forces across it
        turning = np.setdiff1d(turning, poses.ring.place)
    if poses.triad != "accelerometer" or turning.size == 0:
        return
    fastest = int(turning[np.argmax(np.abs(poses.spin_rad_s[turning]))])
    rate = abs(float(poses.spin_rad_s[fastest]))
    per_cm = rate**2 * 0.01
    yield (
        f"{turning.size} of the {len(poses)} poses of the accelerometer were taken on the turning "
        f"plate: in {poses.label[fastest]} the gyro reads {np.degrees(rate):.0f} °/s. Every "
        f"centimetre off the spindle then adds a centripetal {per_cm:.2g} m/s² across gravity "
        f"(lever_arm). Take these poses with the plate stopped, or add accelerometer.lever_arm."
    )


def direction_against_clip(poses: PoseSet, filmed: Sequence[str | None]) -> Iterator[str]:
    """Warn of runs that turn in the direction opposite to their clip.

    Parameters
    ----------
    poses : PoseSet
        n poses of the gyro.
    filmed : sequence of str or None, length n
        ``ccw``, ``cw`` or None for each pose's run.

    Yields
    ------
    str
        One warning for each such run.
    """
    sign = {"ccw": 1.0, "cw": -1.0}
    runs: dict[str, list[bool]] = {}
    for run, spin, direction in zip(poses.run, poses.spin_rad_s, filmed, strict=True):
        if direction is not None and spin != 0:
            runs.setdefault(run, []).append(sign[direction] != np.sign(spin))
    for run, opposite in runs.items():
        if np.mean(opposite) > 0.5:  # most poses of the run
            yield (
                f"run {run}: by gyro and accelerometer together the plate turns the other way than "
                f"its rate says. The direction felt by the sensor was used. Change the sign of a "
                f"stated rate; was a clip mirrored, taken from below, or of another run?"
            )


def gain_off_the_sheet(parameters: TriadParameters, spec: TriadSpec, triad: str) -> Iterator[str]:
    """Warn of gains far from the full scale of the data sheet.

    Parameters
    ----------
    parameters : TriadParameters
        Those of the calibration; gains that were not fitted give no warning.
    spec : TriadSpec
        The data sheet.
    triad : str
        ``accelerometer`` or ``gyroscope``.

    Yields
    ------
    str
        One warning at most, for the axis whose gain is farthest off.
    """
    if not np.isfinite(parameters.cov[6:, 6:]).all():
        return  # the gains were not fitted: they are those of the data sheet
    ratio: FloatArray = parameters.scale_counts_per_unit * spec.nominal_scale
    worst = int(np.argmax(np.abs(ratio - 1)))
    if abs(ratio[worst] - 1) > SHEET_TOLERANCE:
        reference = TRIAD_KINDS[triad].reference
        named = np.isfinite(spec.full_scale)
        range_says = (
            f" (a range of {range_in_words(spec.full_scale / ratio.mean(), triad)} instead of "
            f"{range_in_words(spec.full_scale, triad)})"
            if named
            else ""
        )
        yield (
            f"the {triad}'s gain on {AXES[worst]} is {ratio[worst]:.2f} times the data sheet's"
            f"{range_says}. Either the data sheet is not this unit's (its range, bits or unit), "
            f"which the calibration does not depend on, or {reference} is wrong by that "
            f"factor and the scale with it. Check the {triad}'s full scale and bits, and "
            f"{reference}."
        )


def range_by_gain(scale_counts_per_unit: FloatArray, spec: TriadSpec) -> float | None:
    """The full scale, SI, that fitted gains (3,) show where they contradict the data sheet.

    None where they agree with the data sheet, or it states none.
    """
    ratio = scale_counts_per_unit * spec.nominal_scale
    if not np.isfinite(spec.full_scale) or np.abs(ratio - 1).max() <= SHEET_TOLERANCE:
        return None
    return float(spec.full_scale / ratio.mean())


def range_in_words(full_scale: float, triad: str) -> str:
    """A full scale in the unit of data sheets: ``±4 g``, ``±500 °/s``."""
    if triad == "accelerometer":
        return f"±{full_scale / STANDARD_GRAVITY_M_S2:.3g} g"
    return f"±{np.degrees(full_scale):.3g} °/s"


def sds_too_large(fit: Fit) -> Iterator[str]:
    """Warn, once at most, where residuals are too small for the sds of a table's means.

    The sd that the samples of a pose give may well exceed the scatter of its mean, by chance or
    because it contains the converter's steps and slow noise at their largest: nothing needs
    mending.
    """
    times = fit.sds_too_large
    if times is None or not tests_the_model(fit.poses):
        return
    yield (
        f"the sds of the {fit.poses.triad}'s poses are about {times:.2g} times too large: "
        f"chi²/dof is {fit.chi2 / fit.dof:.2g} with {fit.dof} degrees of freedom, and right sds "
        f"give so little in fewer than one session of {ONE_SESSION_OF}. The stated sds of the "
        f"parameters are too large with them, and an error of that size goes unseen. Are "
        f"they those of single samples? Those of the means belong here."
    )
