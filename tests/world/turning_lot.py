"""A lot of gyroscopes on the turning plate: their poses as mean counts, drawn all at once.

The physics of :mod:`tests.world.physics`, each pose in ``MOMENTS`` moments instead of all its
samples: enough for the turns of gravity and of the Earth's rate about a leaning spindle to average
as they do. The plate turns evenly, and its vibration has averaged out.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tests.world.bench import TEMPERATURE, Design, Run, attitudes
from tests.world.imu import FloatArray
from tests.world.lot import (
    Lot,
    LotPlan,
    course_of,
    errors_per_unit,
    in_counts,
    unlike,
    warmth_of,
)
from tests.world.lot_sizes import rows_of, sizes_of
from tests.world.moments import Moments
from tests.world.physics import courses, move
from tests.world.sizes import WARM_UP_TAU_S

MOMENTS = 24
"""In each pose, evenly spaced: four and more in every turn."""


def draw_turning_lot(design: Design, plan: LotPlan, seed: int) -> Lot:
    """Draw the evenings of ``plan`` with the one run of ``design`` on the turning plate.

    ``hidden`` of the plan may also be ``reference_drift`` and ``column:NAME``.
    """
    run = _the_run(design)
    rng = np.random.default_rng([seed, 62])
    sets, n = plan.sensors * plan.evenings, len(run.directions)
    unit = np.repeat(np.arange(plan.sensors), plan.evenings)
    begin_s = design.begins_s()[design.runs.index(run)]
    starts = np.arange(n) * (run.seconds + run.rest_s)
    since_s = starts[:, None] + run.seconds * (np.arange(MOMENTS) + 0.5) / MOMENTS  # (n, moments)
    order = np.argsort(rng.random((sets, n)), axis=1)
    attitude = attitudes(run.directions[order].reshape(-1, 3), design.jitter_deg, rng)
    quiet = replace(design, turntable=replace(design.turntable, vibration_m_s2=0.0))
    motion = move(quiet, run, np.tile(since_s, (sets, 1)), attitude, rng, ())
    typical = design.sensor.gyroscope
    axes, gain, offset = unlike(typical, plan.sensors, rng)
    rate = motion.rate.reshape(sets, -1, 3)
    true = (rate @ axes[unit].swapaxes(1, 2)).reshape(sets * n, MOMENTS, 3)
    time_s = begin_s + starts + run.seconds / 2
    columns = {TEMPERATURE: warmth_of(design.temperature, time_s, sets, rng) + run.soak_c}
    columns |= {name: course_of(course, time_s, sets, rng)
                for name, course in design.columns.items()}
    mean = true.mean(axis=1).reshape(sets, n, 3)
    samples = round(run.seconds * design.sample_rate_hz)
    sd = typical.pose_mean_sd(samples, 1 / design.sample_rate_hz)
    size, error = np.zeros((sets, 0)), np.zeros((sets, n, 3))
    if plan.hidden is not None:
        before = np.concatenate([np.zeros((sets, 1, 3)), mean[:, :-1]], axis=1)
        moments = Moments(
            time_s=np.tile(begin_s + since_s, (sets, 1)),
            columns={name: np.repeat(values.reshape(-1, 1), MOMENTS, axis=1)
                     for name, values in columns.items()},
            courses=courses(design),
            rate=motion.rate,
            force=motion.force,
            spin=motion.spin,
            spin_up=motion.spin_up,
            vibration_m_s2=motion.vibration_m_s2,
            triad=typical,
            before=before.reshape(-1, 1, 3),
            number=np.tile(np.arange(n), sets)[:, None, None],
            warmth=lambda at: np.full_like(at, design.temperature.start),
        )
        tau_s = np.random.default_rng([seed, 63]).uniform(*WARM_UP_TAU_S)
        each = _errors(plan.hidden, true, moments, axes[unit], {"tau_s": tau_s})
        each = each.mean(axis=1).reshape(sets, n, 3, -1)
        along = mean / np.linalg.norm(mean, axis=2, keepdims=True)
        own = np.linalg.norm(along * sd, axis=2, keepdims=True)
        size = sizes_of(plan, unit, rows_of(plan.hidden, each, along / own), rng)
        error = np.einsum("snik,sk->sni", each, size)
    without_noise, counts, stated = in_counts(
        plan, typical, gain[unit], offset[unit], mean + error, sd, rng)
    assert run.motion is not None
    plate = run.motion.rate_rad_s
    off = design.rate_sd_relative * rng.standard_normal((sets, 1))
    earth = np.sign(plate) * design.site.earth_rate()[2]
    return Lot(
        counts=counts,
        true_counts=without_noise,
        sd_counts=stated,
        columns=columns,
        time_s=time_s,
        unit=unit,
        size=size,
        magnitude=np.broadcast_to(abs(plate) * (1 + off) + earth, (sets, n)),
        triad=typical,
        force_m_s2=motion.force.mean(axis=1).reshape(sets, n, 3),
        rate_sd=design.rate_sd_relative * abs(plate),
        spin_rad_s=plate,
    )


def _the_run(design: Design) -> Run:
    turning = [run for run in design.runs if run.motion is not None]
    if len(turning) != 1 or design.rests_count_for_gyroscope:
        raise ValueError("a lot of gyroscopes has one run on the turning plate, and none at rest")
    return turning[0]


def _errors(
    name: str, true: FloatArray, moments: Moments, axes: FloatArray,
    detail: Mapping[str, float | int | str],
) -> FloatArray:
    """Errors (p, samples, 3, k) along the axes (S, 3, 3) per unit of each size of an effect."""
    if name == "reference_drift":  # the plate is faster than the clip says, the more the later
        more = moments.spin * moments.time_s[..., None]
        along = more.reshape(len(axes), -1, 3) @ axes.swapaxes(1, 2)
        return np.asarray(along.reshape(*true.shape, 1))
    return errors_per_unit(name, "gyroscope", true, moments, detail)
