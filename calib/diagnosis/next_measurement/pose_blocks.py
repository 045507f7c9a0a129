"""Poses that could be recorded next, as hypothetical rows beside the real ones.

Each block is the 18 wedge poses (or the corners) under another condition. What it would show of an
effect is computed, not looked up: its rows are built at the fitted model and joined to the fit.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from calib.diagnosis.next_measurement.kind import (
    OF_ALL,
    SAME_SPEED,
    TEMPERATURE,
    THROUGH_TEMPERATURES,
    at_one_speed,
    in_a_chamber,
    shares_a_rate,
)
from calib.fit.least_squares.result import Fit
from calib.fit.rows.residuals import Equations
from calib.poses.attitudes import natural_directions
from calib.poses.imu_log import BoolArray, FloatArray
from calib.poses.pose_set import PoseSet
from calib.poses.reference import Reference
from calib.poses.runs import TIME_BASE

#: fact: 16⅔, 33⅓, 45 and 78 rpm
RECORD_SPEEDS_RAD_S = np.array([50 / 3, 100 / 3, 45.0, 78.0]) * np.pi / 30
HEADROOM = 0.9
"""Share of the full scale up to which a rate is advised; gain and offset take the rest."""

SOAK_K = 20.0  #: K above the room, as a hair dryer makes it; it only plans
POSE_S = 30.0  #: s of a planned pose; it only plans


@dataclass(frozen=True)
class Block:
    """One thing to record next.

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


def menu(fit: Fit, full_scale: float = np.inf) -> list[Block]:
    """The blocks worth considering for the poses of ``fit``, cheapest first.

    In a thermal chamber that is another course of the temperature, and no other attitude; of a
    session at one speed another speed, rest, direction or tilt of the plate, since more attitudes
    leave unseen what one speed does not show. A plate whose rate several poses share can be filmed
    with each pose. No speed of the plate is among them that would saturate a gyro of
    ``full_scale`` (rad/s).
    """
    poses = fit.poses
    has_temperature = TEMPERATURE in poses.columns
    one = MINUTES_PER_PASS
    soaks = [
        Block(
            "soak",
            "the same poses warmed by about 20 °C and once more after they have cooled",
            6 * one,
            ((1.0, SOAK_K, 1800.0), (1.0, 0.0, 7200.0)),
        )
    ]
    if in_a_chamber(poses):
        return [replace(soaks[0], instruction=THROUGH_TEMPERATURES)]
    corners = Block("corners", "the 8 corner poses", one / 2, ((1.0, 0.0, 0.0),), corners=True)
    repeat = Block("repeat", "the same poses once more, in random order", one, ((1.0, 0.0, 0.0),))
    if poses.triad == "accelerometer":
        return [corners, repeat, *(soaks if has_temperature else [])]
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
                rpm = speed * 30 / np.pi
                instruction = f"the same poses at another speed of the plate ({rpm:.3g} rpm)"
                blocks.append(Block("speed", instruction, one, ((speed / slow, 0.0, 0.0),)))
                break
        if (spins >= 0).all() or (spins <= 0).all():
            instruction = "the same poses with the plate turning the other way"
            blocks.append(Block("direction", instruction, one, ((-1.0, 0.0, 0.0),)))
        instruction = "the same poses on a plate tilted by about 60°"
        blocks.append(Block("tilt", instruction, 2 * one, ((1.0, 0.0, 0.0),), tilt_rad=np.pi / 3))
        blocks += [CLIPS] if shares_a_rate(poses) else []
    if not at_one_speed(poses):
        blocks += [repeat, corners]
    return [*blocks, *(soaks if has_temperature else [])]


def _vectors(fit: Fit, block: Block) -> tuple[FloatArray, FloatArray]:
    """Up directions (n, 3) and axes of rotation (n, 3) of one pass through the block's poses."""
    natural = natural_directions()
    up = natural[18:] if block.corners else natural[:18]
    if block.tilt_rad == 0.0:
        return up, up
    sideways = np.cross(up, np.roll(up, 1, axis=1))
    sideways /= np.maximum(np.linalg.norm(sideways, axis=1, keepdims=True), 1e-12)
    return up, np.cos(block.tilt_rad) * up + np.sin(block.tilt_rad) * sideways


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
    poses = fit.poses
    up, axis = _vectors(fit, block)
    n = len(up)
    turning = ~poses.reference.is_null
    magnitude = poses.reference.magnitude[turning]
    base = float(magnitude.min()) if turning.any() else 0.0
    spin_base = float(np.abs(poses.spin_rad_s[turning]).min()) if turning.any() else 0.0
    size = abs(factor) * base
    direction = np.sign(factor) if factor else 0.0
    if poses.triad == "gyroscope" and turning.any():
        way = float(np.sign(np.median(np.sign(poses.spin_rad_s[turning])))) or 1.0
        direction *= way
    else:
        direction = 1.0
    s = direction * size * axis
    matrix, offset = fit.equations.start.matrix, fit.equations.start.offset
    like = poses.reference.is_null if factor == 0.0 else turning
    force = np.linalg.norm(poses.force, axis=1)
    logged = force[np.isfinite(force)]
    gravity = float(np.median(logged)) if logged.size else np.nan
    time_s, columns = _course(poses, n, warmth, delay_s)
    names = poses.reference.common_names
    common = np.zeros((n, len(names)))
    sd = float(np.median(poses.reference.sd[like])) if like.any() else 0.0
    if block.filmed:
        sd = float(np.hypot(sd, _rate_sd(poses) * size))
    for j, name in enumerate(names):
        relative = np.median(np.abs(poses.reference.common[turning, j]) / magnitude)
        if poses.triad == "accelerometer" or name == TIME_BASE:
            common[:, j] = relative * size
    return PoseSet(
        triad=poses.triad,
        label=tuple(f"{block.code} {i + 1}" for i in range(n)),
        run=(block.code,) * n,
        reading=np.linalg.solve(matrix, (s - offset).T).T,
        sd=np.tile(_typical(poses.sd, like), (n, 1)),
        force=gravity * up,
        vibration=np.tile(
            np.zeros(3) if factor == 0.0 and not like.any() else _typical(poses.vibration, like),
            (n, 1),
        ),
        spin_rad_s=np.full(n, direction * abs(factor) * spin_base),
        time_s=time_s,
        expected=np.zeros((n, 3)),
        reference=Reference(
            np.full(n, size),
            np.full(n, sd),
            common,
            names,
        ),
        columns=columns,
    )


def _joined(a: PoseSet, b: PoseSet) -> PoseSet:
    """Poses of ``a`` followed by those of ``b``; a new common error for b's shared rate."""

    def both(get: Callable[[PoseSet], FloatArray]) -> FloatArray:
        return np.concatenate([get(a), get(b)])

    names = a.reference.common_names
    padding = np.zeros((len(b), len(names) - len(b.reference.common_names)))
    reference = Reference(
        both(lambda p: p.reference.magnitude),
        both(lambda p: p.reference.sd),
        np.concatenate([a.reference.common, np.hstack([b.reference.common, padding])]),
        names,
    )
    return replace(
        a,
        label=a.label + b.label,
        run=a.run + b.run,
        reading=both(lambda p: p.reading),
        sd=both(lambda p: p.sd),
        force=both(lambda p: p.force),
        vibration=both(lambda p: p.vibration),
        spin_rad_s=both(lambda p: p.spin_rad_s),
        time_s=both(lambda p: p.time_s),
        expected=both(lambda p: p.expected),
        other_reading=None,  # of hypothetical poses it follows from the plate and from gravity
        run_time_s=None,
        reference=reference,
        columns={name: np.concatenate([a.columns[name], b.columns[name]]) for name in a.columns},
    )


def _own_rate_error(poses: PoseSet, block: PoseSet) -> PoseSet:
    """``poses`` with one more common error: the rate of the block, known as well as the others."""
    reference = poses.reference
    turning = ~reference.is_null
    if poses.triad == "accelerometer" or not turning.any():
        return poses
    new = np.zeros((len(poses), 1))
    new[-len(block) :, 0] = _rate_sd(poses) * block.reference.magnitude
    return replace(
        poses,
        reference=Reference(
            reference.magnitude,
            reference.sd,
            np.hstack([reference.common, new]),
            (*reference.common_names, f"rate {block.run[0]} {len(reference.common_names)}"),
        ),
    )


def _rate_sd(poses: PoseSet) -> float:
    """Typical sd of the rate of one setting of the plate, relative to it."""
    reference, turning = poses.reference, ~poses.reference.is_null
    fresh = [j for j, name in enumerate(reference.common_names) if name not in OF_ALL]
    loading = np.abs(reference.common[:, fresh]).sum(axis=1) if fresh else reference.sd
    return float(np.median(loading[turning] / reference.magnitude[turning]))


def with_block(fit: Fit, block: Block) -> Fit:
    """``fit`` as it would stand with the rows of ``block`` added, at the same parameters."""
    poses = fit.poses
    for factor, warmth, delay_s in block.parts:
        part = _pass(fit, block, factor, warmth, delay_s)
        poses = _joined(poses, part)
        if factor and not block.filmed:
            poses = _own_rate_error(poses, part)
    equations = Equations(poses, fit.model)
    eta = np.zeros(equations.common.shape[1])
    rows = equations.rows(fit.theta, eta, fit.shapes)
    return replace(
        fit,
        poses=poses,
        equations=equations,
        eta=eta,
        rows=rows,
        weight=np.ones(len(rows.residual)),
    )


def hypothetical(fit: Fit, full_scale: float = np.inf) -> Iterator[tuple[Block, Fit]]:
    """Every block of the menu with the fit as it would then stand."""
    for block in menu(fit, full_scale):
        yield block, with_block(fit, block)
