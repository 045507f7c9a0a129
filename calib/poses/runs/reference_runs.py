"""Averaged poses and their references, as runs of a triad."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from calib.earth import EARTH_RATE_RAD_S, earth_rate_horizontal, earth_rate_vertical
from calib.errors import Remedy, Undetermined
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.checks.pose_checks import check_axes_alive
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.reference import (
    PLAUSIBLE_RATIO,
    CommonError,
    PlateRate,
    Reference,
    constant_reference,
    room_names,
)
from calib.poses.runs.pose_run import PoseRun, check_alive
from calib.poses.runs.ring import ring_of_run
from calib.poses.triad_kind import TRIAD_KINDS

TURNING_RAD_S = 0.09
"""Rate, 5 °/s, of a pose beyond the typical one: the offset is the same in every pose, so that its
noise and drift stay far below; the slowest plate turns at 100 °/s. Fact."""

GRAVITY = "local gravity"
TIME_BASE = "time base of the camera"
RATE_OF = "rate "
"""Prefix of the setting in the name of the sd of one rate in the budget."""


def spin_sign(means: Sequence[PoseMean], direction: str | None) -> FloatArray:
    """+1 counter-clockwise seen from above, -1 clockwise, 0 unknown, (n,), no unit.

    Rate and specific force are parallel on a level plate, so their product gives the direction in
    any attitude; the clip is used only where no accelerometer was logged.
    """
    gyro = np.array([mean.gyroscope.mean for mean in means])
    force = np.array([mean.accelerometer.mean for mean in means])
    sensed = np.sign((gyro * force).sum(axis=1))
    filmed = {"ccw": 1.0, "cw": -1.0, None: 0.0}[direction]
    return np.where(np.isfinite(sensed), sensed, filmed)


def gravity_run(
    name: str, means: Sequence[PoseMean], gravity_m_s2: float, sd_m_s2: float
) -> PoseRun:
    """Poses of the accelerometer under gravity.

    Parameters
    ----------
    name : str
        Name of the run.
    means : sequence of PoseMean, length n
        The poses; where the gyro turns, its rate becomes ``spin_rad_s``.
    gravity_m_s2, sd_m_s2 : float
        Local gravity and its sd, m/s².

    Raises
    ------
    Undetermined
        Readings that are nowhere near gravity by the data sheet, or poses without accelerometer.
    """
    run = still_run("accelerometer", name, means, gravity_m_s2, CommonError(GRAVITY, sd_m_s2))
    gyro = np.array([mean.gyroscope.mean for mean in means])
    rest = np.linalg.norm(gyro - np.median(gyro, axis=0), axis=1)
    spinning = np.isfinite(rest) & (rest > TURNING_RAD_S)
    spin = np.where(spinning, np.linalg.norm(gyro, axis=1) * spin_sign(means, None), 0.0)
    return replace(run, spin_rad_s=spin)


def still_run(
    triad: Triad, name: str, means: Sequence[PoseMean], magnitude: float, common: CommonError
) -> PoseRun:
    """Poses at rest in a field of known magnitude.

    Parameters
    ----------
    triad : str
        Which one senses the field.
    name : str
        Name of the run.
    means : sequence of PoseMean, length n
    magnitude : float
        Of the field, in the SI unit of the triad.
    common : CommonError
        By what the magnitude is uncertain, in the same unit.

    Raises
    ------
    Undetermined
        Readings that are nowhere near the magnitude by the data sheet, or poses without this triad.
    """
    kind, n = TRIAD_KINDS[triad], len(means)
    readings = np.array([mean.of(triad).mean for mean in means])
    _check_logged(name, means, readings, triad)
    typical = float(np.median(np.linalg.norm(readings, axis=1)))
    if not magnitude / PLAUSIBLE_RATIO < typical < magnitude * PLAUSIBLE_RATIO:
        raise Undetermined(
            f"{name}: by the data sheet the {triad} reads {typical:.3g} {kind.unit} in a typical "
            f"pose, where {magnitude:.5g} {kind.unit} is expected. Check the full scale, bits, "
            f"encoding and unit of the {triad}, and the order of the columns.",
            Remedy("data_sheet", triad),
        )
    check_alive(means, triad, name)
    check_axes_alive(name, triad, readings, np.full(n, magnitude))
    return PoseRun(
        name=name,
        means=means,
        reference=constant_reference(n, magnitude, [common]),
        spin_rad_s=np.zeros(n),
        expected=np.zeros((n, 3)),
    )


def turning_run(means: Sequence[PoseMean], rate: PlateRate, latitude_rad: float | None) -> PoseRun:
    """Poses of the gyro on the turning plate; the Earth's vertical rate belongs to the reference.

    Parameters
    ----------
    means : sequence of PoseMean, length n
    rate : PlateRate
        The measured rate, one for the run or one per pose.
    latitude_rad : float or None
        Geodetic latitude, rad; without it the Earth's rate is a common error.

    Raises
    ------
    Undetermined
        The gyro does not turn, turns at quite another rate than the plate, or was not logged; or
        the number of rates is neither 1 nor n.
    """
    n = len(means)
    readings = np.array([mean.gyroscope.mean for mean in means])
    _check_logged(rate.name, means, readings, "gyroscope")
    if len(rate.rate_rad_s) not in (1, n):
        raise Undetermined(
            f"{rate.name}: {len(rate.rate_rad_s)} clips for {n} poses; give one clip for the run, "
            f"or one per pose in the same order."
        )
    plate = np.broadcast_to(rate.rate_rad_s, n).astype(float)
    check_alive(means, "gyroscope", rate.name)
    check_axes_alive(rate.name, "gyroscope", readings, plate)
    _check_turning(rate.name, means, np.linalg.norm(readings, axis=1), plate)
    sign = spin_sign(means, rate.direction)
    shared = len(rate.rate_rad_s) == 1
    common = [plate * rate.timebase_relative]
    names = [TIME_BASE]
    if shared:
        common.append(np.full(n, float(rate.sd_rad_s[0])))
        names.append(RATE_OF + rate.name)
    each_sd = np.zeros(n) if shared else np.asarray(rate.sd_rad_s, float)
    vertical = 0.0 if latitude_rad is None else earth_rate_vertical(latitude_rad)
    if latitude_rad is None:
        common.append(sign * EARTH_RATE_RAD_S / np.sqrt(3))
        names.append("Earth rate, latitude not given")
    horizontal = EARTH_RATE_RAD_S if latitude_rad is None else earth_rate_horizontal(latitude_rad)
    room = horizontal / np.sqrt(2)
    ring = ring_of_run(means, "gyroscope", room_rad_s=room, vertical_rad_s=vertical)
    if ring is not None:  # up = n cos(tilt) + t sin(tilt), with n the axis and t along the lean
        names += room_names(rate.name)
        common += [-sign * room * np.sin(ring.tilt_rad[0]), np.zeros(n)]
        vertical *= np.cos(ring.tilt_rad[0])
    return PoseRun(
        name=rate.name,
        means=means,
        ring=ring,
        reference=Reference(
            magnitude=plate + sign * vertical,
            sd=each_sd,
            common=np.column_stack(common),
            common_names=tuple(names),
            of_setting=frozenset({RATE_OF + rate.name} if shared else ()),
        ),
        spin_rad_s=sign * plate,
        expected=np.zeros((n, 3)),
    )


def stopped_run(name: str, means: Sequence[PoseMean], latitude_rad: float | None) -> PoseRun:
    """Poses of the gyro with the plate stopped, which measure the Earth's rate.

    Its vertical part is known where the latitude and the accelerometer are; the horizontal part has
    an unknown direction and goes into the sd.

    Parameters
    ----------
    name : str
        Name of the run.
    means : sequence of PoseMean, length n
    latitude_rad : float or None
        Geodetic latitude, rad.

    Raises
    ------
    Undetermined
        The gyro turns, or was not logged.
    """
    n = len(means)
    readings = np.array([mean.gyroscope.mean for mean in means])
    _check_logged(name, means, readings, "gyroscope")
    _check_stopped(name, means, readings)
    force = np.array([mean.accelerometer.mean for mean in means])
    known = latitude_rad is not None and bool(np.isfinite(force).all())
    if known and latitude_rad is not None:
        up = force / np.linalg.norm(force, axis=1, keepdims=True)
        expected = earth_rate_vertical(latitude_rad) * up
        horizontal_sd = earth_rate_horizontal(latitude_rad) / np.sqrt(2)
    else:
        expected, horizontal_sd = np.zeros((n, 3)), EARTH_RATE_RAD_S / np.sqrt(3)
    return PoseRun(
        name=name,
        means=means,
        reference=replace(constant_reference(n, 0.0, []), sd=np.full(n, horizontal_sd)),
        spin_rad_s=np.zeros(n),
        expected=expected,
    )


def _check_logged(name: str, means: Sequence[PoseMean], readings: FloatArray, triad: str) -> None:
    absent = np.flatnonzero(~np.isfinite(readings).all(axis=1))
    if absent.size:
        raise Undetermined(
            f"{name}: {means[absent[0]].label} has no {triad} columns; "
            f"{', '.join(TRIAD_KINDS[triad].columns)} are needed in every pose of this run."
        )


def _check_turning(
    name: str, means: Sequence[PoseMean], rate: FloatArray, plate: FloatArray
) -> None:
    ratio = rate / plate
    wrong = np.flatnonzero((ratio < 1 / PLAUSIBLE_RATIO) | (ratio > PLAUSIBLE_RATIO))
    if wrong.size == 0:
        return
    worst = int(wrong[0])
    raise Undetermined(
        f"{name}: in {means[worst].label} (and {wrong.size - 1} other poses) the gyro reads "
        f"{rate[worst]:.3g} rad/s by the data sheet while the plate turns at {plate[worst]:.4g} "
        f"rad/s. Either the plate was not turning in these poses, or the stated data sheet of the "
        f"gyroscope (full scale, bits, encoding, unit) is not this sensor's.",
        Remedy("data_sheet", "gyroscope"),
    )


def _check_stopped(name: str, means: Sequence[PoseMean], readings: FloatArray) -> None:
    # A zero-rate offset is the same in every pose, a turning plate is not: the pose turns it.
    rest = np.linalg.norm(readings - np.median(readings, axis=0), axis=1)
    turning = np.flatnonzero(rest > TURNING_RAD_S)
    if turning.size == 0:
        return
    worst = int(turning[np.argmax(rest[turning])])
    raise Undetermined(
        f"{name}: {turning.size} of {len(means)} poses do not read as at rest: in "
        f"{means[worst].label} the gyro differs by {rest[worst]:.3g} rad/s "
        f"({np.degrees(rest[worst]):.1f} °/s) from its typical reading. If they were recorded on "
        f"the turning plate, name its rate instead of saying that it was stopped; else their zero "
        f"is another one: are they of another sensor or range, or had it just been switched on?"
    )
