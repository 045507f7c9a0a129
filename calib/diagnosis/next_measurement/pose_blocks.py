"""Poses that could be recorded next, as hypothetical rows beside the real ones.

Each block is poses of the session (or the corners) under another condition. Its view of an effect
is computed, not looked up: its rows are built at the fitted model and joined to the fit.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from calib.diagnosis.next_measurement.ideal_poses import PlannedRun, ideal_poses
from calib.diagnosis.next_measurement.kind import (
    SAME_SPEED,
    THROUGH_TEMPERATURES,
    at_one_speed,
    attitudes_again,
    in_a_chamber,
)
from calib.fit.least_squares.result import Fit
from calib.fit.rows.problem import Estimate
from calib.fit.rows.residuals import Equations
from calib.numbers import RPM
from calib.poses.attitudes import natural_directions, uncovered
from calib.poses.imu_log import TEMPERATURE, BoolArray, FloatArray
from calib.poses.pose_set import PoseSet
from calib.poses.reference import Reference, room_names
from calib.poses.runs.ideal_ring import ADVISED_TILT, ADVISED_TILT_RAD
from calib.poses.runs.reference_runs import RATE_OF, TIME_BASE

#: fact: 16⅔, 33⅓, 45 and 78 rpm
RECORD_SPEEDS_RAD_S = np.array([50 / 3, 100 / 3, 45.0, 78.0]) * RPM
HEADROOM = 0.9
"""Share of the full scale up to which a rate is advised. Derived: by its data sheet the gain of an
MPU-6050 errs by up to 3 % and its zero by 20 °/s, which is 8 % of ±250 °/s."""

SOAK = "soak"  #: code of the block at other temperatures
SOAK_K = 20.0  #: K above the room, as a hair dryer makes it; it only plans
POSE_S = 30.0  #: s of a planned pose; it only plans


@dataclass(frozen=True)
class Block:
    """One candidate for the next measurement.

    ``code`` names it for programs, ``instruction`` for people; ``minutes`` is what it takes;
    ``parts`` are (rate factor over the plate's, warmth in K, delay in s) of its passes through the
    poses; ``filmed`` whether each pose has a clip of its own.
    """

    code: str
    instruction: str
    minutes: float
    parts: tuple[tuple[float, float, float], ...]
    corners: bool = False
    tilt_rad: float = 0.0
    filmed: bool = False


MINUTES_PER_PASS = 10.0  #: 18 poses of half a minute each; it only plans
CLIPS = Block(
    "clips", "the same poses with a clip of the plate for each of them", 2 * MINUTES_PER_PASS,
    ((1.0, 0.0, 0.0),), filmed=True,
)


NATURAL_POSES = 18  #: number of faces and edges of a box together; fact
CORNERS = slice(NATURAL_POSES, None)
"""Natural directions after the faces and the edges. Definition."""


def minutes_for(poses: int) -> float:
    """Time to record so many poses, whole minutes, at least one."""
    return float(max(1, round(poses * MINUTES_PER_PASS / NATURAL_POSES)))


TILTED = Block(
    "tilt", f"the same poses with {ADVISED_TILT}", MINUTES_PER_PASS + 1.0, ((1.0, 0.0, 0.0),),
    tilt_rad=ADVISED_TILT_RAD,
)


def menu(fit: Fit, full_scale: float = np.inf) -> list[Block]:
    """The blocks worth considering for the poses of ``fit``, cheapest first.

    In a thermal chamber that is another course of the temperature, and no other attitude; of a
    session at one speed another speed, rest, direction or tilt of the plate (where it leans by less
    than half as much), since more attitudes leave unseen what one speed does not show. A plate
    whose rate several poses share can be filmed with each pose. No speed of the plate is among them
    that would saturate a gyro of ``full_scale`` (rad/s).
    """
    poses = fit.poses
    has_temperature = TEMPERATURE in poses.columns
    one = MINUTES_PER_PASS
    soaks = [
        Block(
            SOAK,
            "the same poses warmed by about 20 °C and once more after they have cooled",
            6 * one,
            ((1.0, SOAK_K, 1800.0), (1.0, 0.0, 7200.0)),
        )
    ]
    if in_a_chamber(poses):
        return [replace(soaks[0], instruction=THROUGH_TEMPERATURES)]
    where = " on the turning plate" if poses.spin_rad_s.any() else ""
    corners = Block(
        "corners", f"the 8 corner poses{where}", one / 2, ((1.0, 0.0, 0.0),), corners=True)
    repeat = Block("repeat", "the same poses once more, in random order", one, ((1.0, 0.0, 0.0),))
    attitudes = [repeat] if _has_corners(fit) else [corners, repeat]
    if poses.triad == "accelerometer":
        return [*attitudes, *(soaks if has_temperature else [])]
    spins = poses.spin_rad_s
    blocks = []
    if not poses.reference.is_null.any():
        blocks.append(
            Block("stopped", "the same poses with the plate stopped", one, ((0.0, 0.0, 0.0),))
        )
    moving = np.abs(spins[spins != 0])
    if moving.size:
        slow = float(moving.min())
        for speed in RECORD_SPEEDS_RAD_S:
            new = bool((np.abs(moving / speed - 1) > SAME_SPEED).all())
            if new and speed < HEADROOM * full_scale:
                rpm = speed / RPM
                instruction = f"the same poses at another speed of the plate ({rpm:.3g} rpm)"
                blocks.append(Block("speed", instruction, one, ((speed / slow, 0.0, 0.0),)))
                break
        if (spins >= 0).all() or (spins <= 0).all():
            instruction = "the same poses with the plate turning the other way"
            blocks.append(Block("direction", instruction, one, ((-1.0, 0.0, 0.0),)))
        lean = 0.0 if poses.ring is None else poses.ring.tilt_rad.max()
        if lean < TILTED.tilt_rad / 2 and np.isfinite(poses.force).all():
            blocks.append(TILTED)
        blocks += [CLIPS] if poses.reference.of_setting else []
    if not at_one_speed(poses):
        blocks += reversed(attitudes)
    blocks += soaks if has_temperature else []
    return sorted(blocks, key=lambda each: each.minutes)


def _has_corners(fit: Fit) -> bool:
    """Whether the session has a pose near each of the 8 corners: once more they show nothing new.
    """
    vectors = fit.rows.vector[~fit.poses.reference.is_null]
    return len(vectors) > 0 and len(uncovered(vectors, natural_directions()[CORNERS])) == 0


def _typical(values: FloatArray, like: BoolArray) -> FloatArray:
    """Median of the rows of ``values`` where ``like`` holds, of all where it nowhere does."""
    return np.asarray(np.median(values[like] if like.any() else values, axis=0))


def _course(
    poses: PoseSet, n: int, warmth: float, delay_s: float
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Times (n,) and logged columns (n,) each of ``n`` hypothetical poses.

    Without a soak they follow the course that time, temperature and every other column took in
    the real session: poses added to it tell nothing new of what only went with the clock.
    """
    if delay_s == 0.0:
        spread = np.linspace(0, len(poses) - 1, n).round().astype(int)
        order = np.argsort(poses.time_s, kind="stable")[spread]
        return poses.time_s[order], {name: v[order] for name, v in poses.columns.items()}
    columns = {name: np.full(n, float(np.median(v))) for name, v in poses.columns.items()}
    if TEMPERATURE in columns:
        columns[TEMPERATURE] = columns[TEMPERATURE] + warmth
    known = poses.time_s[np.isfinite(poses.time_s)]
    start_s = (float(known.max()) if known.size else 0.0) + delay_s
    return start_s + POSE_S * np.arange(n, dtype=float), columns


def _pass(fit: Fit, block: Block, factor: float, warmth: float, delay_s: float) -> PoseSet:
    """One pass through the poses of ``block`` as a pose set at the fitted model."""
    poses, turning = fit.poses, ~fit.poses.reference.is_null
    axis = natural_directions()[CORNERS] if block.corners else attitudes_again(fit)
    n = len(axis)
    size = abs(factor) * _least(poses.reference.magnitude[turning])
    direction = _direction(poses, factor)
    like = poses.reference.is_null if factor == 0.0 else turning
    force = np.linalg.norm(poses.force, axis=1)
    logged = force[np.isfinite(force)]
    gravity = float(np.median(logged)) if logged.size else np.nan
    at_rest = factor == 0.0 and not like.any()  # no pose shows the vibration on a stopped plate
    vibration = np.zeros(3) if at_rest else _typical(poses.vibration, like)
    time_s, columns = _course(poses, n, warmth, delay_s)
    run = PlannedRun(
        block.code, axis, size,
        direction * abs(factor) * _least(np.abs(poses.spin_rad_s[turning])),
        _typical(poses.sd, like), 0.0, (), gravity, time_s, np.tile(vibration, (n, 1)), columns,
        block.tilt_rad)
    return replace(ideal_poses(poses.triad, [run], fit.equations.start),
                   reference=_planned_reference(poses, block, like, n, size))


def _least(values: FloatArray) -> float:
    """The smallest of ``values`` (k,), 0 without any."""
    return float(values.min()) if values.size else 0.0


def _direction(poses: PoseSet, factor: float) -> float:
    """Direction of the plate in a planned pass: +1 or -1, 0 at rest; +1 without a gyroscope."""
    turning = ~poses.reference.is_null
    if poses.triad != "gyroscope" or not turning.any():
        return 1.0
    usual = float(np.sign(np.median(np.sign(poses.spin_rad_s[turning])))) or 1.0
    return usual * float(np.sign(factor))


def _planned_reference(
    poses: PoseSet, block: Block, like: BoolArray, n: int, size: float
) -> Reference:
    """References of ``n`` planned poses of one magnitude ``size``, SI, known as those recorded."""
    recorded, turning = poses.reference, ~poses.reference.is_null
    sd = float(np.median(recorded.sd[like])) if like.any() else 0.0
    if block.filmed:
        sd = float(np.hypot(sd, _rate_sd(poses) * size))
    common = np.zeros((n, len(recorded.common_names)))
    for j, name in enumerate(recorded.common_names):
        if poses.triad == "accelerometer" or name == TIME_BASE:
            relative = np.abs(recorded.common[turning, j]) / recorded.magnitude[turning]
            common[:, j] = np.median(relative) * size
    return Reference(np.full(n, size), np.full(n, sd), common, recorded.common_names,
                     recorded.of_setting)


def _own_rate_error(poses: PoseSet, block: PoseSet) -> PoseSet:
    """``poses`` with one more common error: the rate of the block, known as well as the others."""
    reference = poses.reference
    turning = ~reference.is_null
    if poses.triad == "accelerometer" or not turning.any():
        return poses
    new = np.zeros((len(poses), 1))
    new[-len(block) :, 0] = _rate_sd(poses) * block.reference.magnitude
    name = f"{RATE_OF}{block.run[0]} {len(reference.common_names)}"
    return replace(poses, reference=replace(
        reference,
        common=np.hstack([reference.common, new]),
        common_names=(*reference.common_names, name),
        of_setting=reference.of_setting | {name},
    ))


def _rate_sd(poses: PoseSet) -> float:
    """Typical sd of the rate of one setting of the plate, relative to it."""
    reference, turning = poses.reference, ~poses.reference.is_null
    shared = [j for j, name in enumerate(reference.common_names) if name in reference.of_setting]
    loading = np.abs(reference.common[:, shared]).sum(axis=1) if shared else reference.sd
    return float(np.median(loading[turning] / reference.magnitude[turning]))


def with_block(fit: Fit, block: Block) -> Fit:
    """``fit`` as it would stand with the rows of ``block`` added, at the same parameters."""
    poses = fit.poses
    if block.tilt_rad:
        names = room_names(block.code)
        poses = replace(poses, reference=replace(
            poses.reference,
            common=np.hstack([poses.reference.common, np.zeros((len(poses), len(names)))]),
            common_names=(*poses.reference.common_names, *names)))
    for factor, warmth, delay_s in block.parts:
        part = _pass(fit, block, factor, warmth, delay_s)
        poses = poses.concat(part)
        if factor and not block.filmed:
            poses = _own_rate_error(poses, part)
    equations = Equations.of(poses, fit.model)
    at = Estimate.of(equations, fit.theta, np.zeros(equations.common_count), fit.shapes)
    return replace(fit, equations=equations, at=at, weight=np.ones(len(at.rows.residual)))


def hypothetical(fit: Fit, full_scale: float = np.inf) -> Iterator[tuple[Block, Fit]]:
    """Every block of the menu with the fit as it would then stand."""
    for block in menu(fit, full_scale):
        yield block, with_block(fit, block)
