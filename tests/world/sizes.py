"""Draws hidden effects of a wanted strength, in noise units over the pose equations.

The strength of an effect is the root mean square, over all pose equations of its triad, of what
the effect adds to them, divided by their standard deviation: that of the sensor's own noise and,
on the turning plate, of the rate (less the clock's, which all rates share: that is pure scale). It
counts everything, also the part that other parameters of a calibration can take up.
"""

from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from tests.world.bench import Design, Run
from tests.world.hidden import EFFECTS, GYROSCOPE_ONLY, Hidden, TriadName
from tests.world.imu import FloatArray
from tests.world.physics import live_through, triad_of
from tests.world.session import whole_turn_rate

THIN = 0.1  # share of the samples that the noiseless rehearsals take
WARM_UP_TAU_S = (300.0, 1200.0)
PERIOD_S = (300.0, 900.0)


def pose_equations(
    design: Design, seed: int, triad: TriadName, hidden: tuple[Hidden, ...] = ()
) -> FloatArray:
    """Noiseless pose equations in units of their noise, shape (rows,).

    One row per pose, the length of its mean vector; three rows, the components, for the gyroscope
    at rest.
    """
    rehearsal = design.scaled(sample_rate=THIN)
    rows = []
    for physics in live_through(rehearsal, seed, hidden):
        at_rest = physics.run.motion is None
        if not _calibrates(design, physics.run, triad):
            continue
        samples = round(physics.run.seconds * design.sample_rate_hz)
        part = triad_of(design, triad)
        sd = part.pose_mean_sd(samples, 1 / design.sample_rate_hz)
        # The inverse undoes the lean of the axes; gains play no part in physical units.
        vector = physics.felt[triad].mean(axis=1) @ np.linalg.inv(part.axes).T
        if triad == "gyroscope" and at_rest:
            rows.append((vector / sd).ravel())
        else:
            length = np.linalg.norm(vector, axis=1)
            along = vector / length[:, None]
            reference_sd = _reference_sd(design, physics.run)
            rows.append(length / np.sqrt(along**2 @ sd**2 + reference_sd**2))
    return np.concatenate(rows)


@lru_cache(maxsize=16)
def without_effects(design: Design, seed: int, triad: TriadName) -> FloatArray:
    """:func:`pose_equations` with nothing hidden, where many draws start; not to be changed."""
    equations = pose_equations(design, seed, triad)
    equations.setflags(write=False)
    return equations


def _reference_sd(design: Design, run: Run) -> float:
    """Sd of the stated plate rate, rad/s; gravity is stated without one."""
    return 0.0 if run.motion is None else design.rate_sd_relative * abs(whole_turn_rate(run.motion))


def _calibrates(design: Design, run: Run, triad: TriadName) -> bool:
    """Whether the poses of a run are equations of a triad."""
    if triad == "accelerometer":
        return run.in_accelerometer_section
    if run.motion is None:
        return design.rests_count_for_gyroscope
    return not run.in_accelerometer_section


def strength(
    design: Design, seed: int, effect: Hidden, without: FloatArray | None = None
) -> float:
    """Root mean square of the effect over the pose equations, in noise units.

    ``without`` are the equations of the evening without it, where they are known.
    """
    if without is None:
        without = without_effects(design, seed, effect.triad)
    with_it = pose_equations(design, seed, effect.triad, (effect,))
    return float(np.sqrt(np.mean((with_it - without) ** 2)))


def draw_effect(
    name: str, triad: TriadName, noise_units: float, design: Design, seed: int
) -> Hidden:
    """An effect in a random direction over its axes, of the strength ``noise_units``.

    ``name`` is a key of :data:`EFFECTS`, with ``:NAME`` of a logged column where one is followed.
    """
    if triad == "accelerometer" and name in GYROSCOPE_ONLY:
        raise ValueError(f"{name} acts on gyroscopes")
    rng = np.random.default_rng([seed, 20, *name.encode()])
    physics = EFFECTS[name.partition(":")[0]]
    direction = rng.standard_normal(physics.shape)
    direction = direction / np.linalg.norm(direction)
    detail = _draw_detail(design, triad, rng)
    size = FIRST_TRY
    without = without_effects(design, seed, triad)
    # Nearly all effects are linear and settle at once; a lever arm enters |f| by its square.
    for _ in range(6):
        effect = Hidden(name, triad, size * direction, detail)
        twice = Hidden(name, triad, 1.1 * size * direction, detail)
        now = strength(design, seed, effect, without)
        if now == 0:
            raise ValueError(f"{name} does not reach the pose equations of this design")
        if abs(now / noise_units - 1) < 1e-3:
            break
        power = np.log(strength(design, seed, twice, without) / now) / np.log(1.1)
        size *= (noise_units / now) ** (1 / np.clip(power, 0.5, 2.0))
    return effect


FIRST_TRY = 1e-4  # in the unit of the effect, whatever that is: the iteration only needs a start


def _draw_detail(design: Design, triad: TriadName, rng: np.random.Generator) -> Mapping[str, float]:
    """A time constant, a moment, a pose and a period; each effect takes what it needs."""
    poses, begins_s, number = [], [], 0
    for run, begin_s in zip(design.runs, design.begins_s(), strict=True):
        if _calibrates(design, run, triad):
            poses += range(number, number + len(run.directions))
            begins_s += [begin_s, begin_s + run.length_s]
        number += len(run.directions)
    first, last = min(begins_s), max(begins_s)
    return {
        "tau_s": rng.uniform(*WARM_UP_TAU_S),
        "time_s": first + rng.uniform(0.2, 0.8) * (last - first),
        "number": int(rng.choice(poses)),
        "period_s": rng.uniform(*PERIOD_S),
        "phase_rad": rng.uniform(0, 2 * np.pi),
        "width": rng.uniform(0.1, 1.0),
        "lag_s": rng.uniform(120.0, 900.0),
        "wander_tau_s": rng.uniform(600.0, 3000.0),
        "draw": int(rng.integers(2**31)),
    }
