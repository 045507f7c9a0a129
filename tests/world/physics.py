"""The physics of an evening, sample by sample: where the sensor is, how it turns, what it feels.

Frames: the *site* (north, west, up), the *plate* (z along the spindle, turning), the *case* of the
sensor. Time runs on through the evening; every run is an array of p poses of n samples.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tests.world.bench import (
    RATED_SPEED_RAD_S,
    TEMPERATURE,
    Course,
    Design,
    Run,
    attitudes,
    pose_order,
)
from tests.world.disturbed_bench import disturbed_run, floor_rate, true_gravity
from tests.world.hidden import Hidden
from tests.world.imu import FloatArray, Triad
from tests.world.moments import Moments
from tests.world.plate import PlateMotion

TRIADS = ("accelerometer", "gyroscope")
Z = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class RunPhysics:
    """What truly acts along the axes during one run, and what noiseless axes would say.

    ``true`` and ``felt`` map a triad's name to an array (p, n, 3) in m/s² or rad/s.
    """

    run: Run
    time_s: FloatArray
    columns: Mapping[str, FloatArray]
    attitude: FloatArray
    true: Mapping[str, FloatArray]
    felt: Mapping[str, FloatArray]


def live_through(
    design: Design, seed: int, hidden: tuple[Hidden, ...] = ()
) -> Iterator[RunPhysics]:
    """The physics of every run in turn, without the noise of the sensor."""
    surroundings = np.random.default_rng([seed, 1])
    drawn = {
        name: course.draw(design.end_s, surroundings) for name, course in courses(design).items()
    }
    before = dict.fromkeys(TRIADS, np.zeros(3))
    number = 0

    def warmth(time_s: FloatArray) -> FloatArray:
        """True temperature at any time: a soak lasts until the next run begins."""
        place = np.searchsorted(design.begins_s(), time_s, side="right") - 1
        soak = np.array([run.soak_c for run in design.runs])[np.maximum(place, 0)]
        return drawn[TEMPERATURE](time_s) + soak

    for index, (run, begin_s) in enumerate(zip(design.runs, design.begins_s(), strict=True)):
        chance = np.random.default_rng([seed, 2, index])
        order = pose_order(len(run.directions), design.shuffled, chance)
        attitude = attitudes(run.directions[order], design.jitter_deg, chance)
        time_s = _clock(run, begin_s, design.sample_rate_hz)
        columns = {name: course(time_s) for name, course in drawn.items()}
        columns[TEMPERATURE] = columns[TEMPERATURE] + run.soak_c

        really = disturbed_run(run, begin_s, hidden)
        motion = move(design, really, time_s - begin_s, attitude, chance, hidden)
        force = {"accelerometer": motion.force_at_chip, "gyroscope": motion.rate}
        true, felt = {}, {}
        for name in TRIADS:
            triad = triad_of(design, name)
            true[name] = triad.project(force[name])
            mean = true[name].mean(axis=1)
            moments = Moments(
                time_s=time_s,
                columns=columns,
                courses=courses(design),
                rate=motion.rate,
                force=motion.force,
                spin=motion.spin,
                spin_up=motion.spin_up,
                vibration_m_s2=motion.vibration_m_s2,
                triad=triad,
                before=np.vstack([before[name], mean[:-1]])[:, None, :],
                number=(number + np.arange(len(time_s)))[:, None, None],
                warmth=warmth,
            )
            felt[name] = true[name]
            for effect in hidden:
                if effect.triad == name and effect.physics.act:
                    felt[name] = felt[name] + effect.error(true[name], moments)
            before[name] = mean[-1]
        number += len(time_s)
        yield RunPhysics(run, time_s, columns, attitude, true, felt)


@dataclass(frozen=True, eq=False)
class Motion:
    """How the case moves during a run, in case coordinates, shapes (p, n, 3)."""

    rate: FloatArray
    force: FloatArray
    force_at_chip: FloatArray
    spin: FloatArray
    spin_up: FloatArray
    vibration_m_s2: FloatArray  # (p, 1, 1)


def move(
    design: Design,
    run: Run,
    time_s: FloatArray,
    attitude: FloatArray,
    chance: np.random.Generator,
    hidden: tuple[Hidden, ...],
) -> Motion:
    """Rate and specific force from the plate's motion; ``time_s`` (p, n) is since the run began."""
    table, site = design.turntable, design.site
    poses = len(attitude)
    if run.motion is None:
        angle = rate = spin_up = np.zeros_like(time_s)
        plate_from_site = np.eye(3)
    else:
        angle, rate, spin_up = _turn(run.motion, time_s)
        tilt = run.tilt_rad or table.tilt_rad
        plate_from_site = Rotation.from_rotvec([*tilt, 0.0]).as_matrix().T
    up = _on_plate(plate_from_site @ Z, angle)
    earth = _on_plate(plate_from_site @ (site.earth_rate() + floor_rate(hidden) * Z), angle)

    into_case = attitude  # (p, 3, 3): v_plate @ attitude = attitudeᵀ v_plate, row by row
    place = np.zeros((poses, 1, 3))
    place[:, 0, :2] = table.offset_m + table.placement_sd_m * chance.standard_normal((poses, 2))
    gravity = true_gravity(design, hidden)

    def specific_force(lever: FloatArray) -> FloatArray:
        """On the plate: reaction to gravity, Euler, centripetal and Coriolis accelerations."""
        x, y = lever[..., 0], lever[..., 1]
        force = gravity * up
        if run.motion is not None:
            force = force + 2 * rate[..., None] * np.cross(earth, np.cross(Z, lever))
            force[..., 0] -= spin_up * y + rate**2 * x
            force[..., 1] += spin_up * x - rate**2 * y
        return force

    field_in_plate = _on_plate(plate_from_site @ np.array([*table.magnet, 0.0]), angle)
    rocked = np.zeros((*angle.shape, 3))
    if table.rocking is not None and run.motion is not None:
        rocked = table.rocking(angle, time_s - time_s[:, :1])
    step_s = time_s[0, 1] - time_s[0, 0]

    chip = place + (attitude @ design.sensor.chip_m)[:, None, :]
    at_centre, at_chip = (
        (force - np.cross(rocked, force)) @ into_case
        for force in (specific_force(place), specific_force(chip)))
    shake = np.zeros((poses, 1, 1))
    if run.motion is not None and table.vibration_m_s2 > 0:
        speed = np.abs(rate).mean(axis=1) / RATED_SPEED_RAD_S
        loudness = 1 + 0.2 * chance.uniform(-1, 1, poses)  # how well the plate damps it differs
        shake = (table.vibration_m_s2 * speed * loudness)[:, None, None]
        vibration = shake * chance.standard_normal(at_chip.shape)
        at_centre, at_chip = at_centre + vibration, at_chip + vibration
    spindle = attitude[:, 2, None, :]  # the plate's z in the case, (p, 1, 3)
    spin = rate[..., None] * spindle
    rocking = np.gradient(rocked, step_s, axis=1) - np.cross(rocked, rate[..., None] * Z)
    magnetic = field_in_plate @ into_case @ table.magnetic.T
    return Motion(
        rate=earth @ into_case + spin + rocking @ into_case + magnetic,
        force=at_centre,
        force_at_chip=at_chip,
        spin=spin,
        spin_up=spin_up[..., None] * spindle,
        vibration_m_s2=shake,
    )


def _turn(motion: PlateMotion, time_s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Angle, rate and angular acceleration of the plate, each (p, n)."""
    angle = motion.angle(time_s.ravel()).reshape(time_s.shape)
    rate = motion.base_rate(time_s) * motion.unevenness(angle)
    return angle, rate, np.gradient(rate, time_s[0, 1] - time_s[0, 0], axis=1)


def _on_plate(vector: FloatArray, angle: FloatArray) -> FloatArray:
    """A fixed vector (3,) as seen from the plate turned by ``angle`` (p, n), shape (p, n, 3)."""
    x, y, z = vector
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * x + s * y, c * y - s * x, np.full_like(c, z)], axis=-1)


def _clock(run: Run, begin_s: float, sample_rate_hz: float) -> FloatArray:
    """Sample times (p, n) in seconds since power-on."""
    starts = begin_s + np.arange(len(run.directions)) * (run.seconds + run.rest_s)
    return starts[:, None] + np.arange(round(run.seconds * sample_rate_hz)) / sample_rate_hz


def courses(design: Design) -> dict[str, Course]:
    """Every logged quantity besides the counts."""
    return {TEMPERATURE: design.temperature, **design.columns}


def triad_of(design: Design, name: str) -> Triad:
    """The triad called "accelerometer" or "gyroscope"."""
    return getattr(design.sensor, name)
