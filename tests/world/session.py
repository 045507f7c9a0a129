"""What the sensor logged in one evening, what the session states, and the truth behind both."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tests.world.bench import Design, Run
from tests.world.hidden import Hidden
from tests.world.imu import FloatArray
from tests.world.physics import TRIADS, RunPhysics, courses, live_through, triad_of
from tests.world.plate import PlateMotion
from tests.world.truth import Parameters, gyroscope_to_accelerometer, parameters


@dataclass(frozen=True, eq=False)
class PoseLog:
    """What the sensor logged in one pose: counts against time, and the other columns."""

    label: str
    time_s: FloatArray
    accelerometer: NDArray[np.int64]
    gyroscope: NDArray[np.int64]
    columns: Mapping[str, FloatArray]


@dataclass(frozen=True, eq=False)
class RunLog:
    """All poses of one run as arrays: counts (p, n, 3), time and other columns (p, n)."""

    run: Run
    time_s: FloatArray
    accelerometer: NDArray[np.int64]
    gyroscope: NDArray[np.int64]
    columns: Mapping[str, FloatArray]

    @property
    def poses(self) -> tuple[PoseLog, ...]:
        """One log per pose, in the order they were taken."""
        return tuple(
            PoseLog(
                f"{self.run.name}/pose_{i + 1:02d}",
                self.time_s[i],
                self.accelerometer[i],
                self.gyroscope[i],
                {name: values[i] for name, values in self.columns.items()},
            )
            for i in range(len(self.time_s))
        )


@dataclass(frozen=True)
class StatedRate:
    """Rate of the plate in a run, signed (positive counter-clockwise from above), in rad/s.

    ``rate_rad_s`` and ``sd_rad_s`` are what a session without a clip states, ``clock_relative`` the
    part of that sd that all its rates have in common; ``true_rad_s`` is the mean over whole turns
    of the undisturbed plate.
    """

    rate_rad_s: float
    sd_rad_s: float
    true_rad_s: float
    clock_relative: float = 0.0

    @property
    def own_sd_rad_s(self) -> float:
        """Sd of this rate without the clock's."""
        return float(np.sqrt(self.sd_rad_s**2 - (self.clock_relative * self.true_rad_s) ** 2))


@dataclass(frozen=True, eq=False)
class Session:
    """The logs of one evening, what it states, and (never written down) the truth."""

    design: Design
    hidden: tuple[Hidden, ...]
    runs: tuple[RunLog, ...]
    rates: Mapping[str, StatedRate]
    accelerometer: Parameters
    gyroscope: Parameters
    gyroscope_to_accelerometer: FloatArray


def simulate(design: Design, seed: int, hidden: tuple[Hidden, ...] = ()) -> Session:
    """One evening at the bench; the same seed draws the same poses whatever is hidden."""
    noise = {triad: np.random.default_rng([seed, 10 + i]) for i, triad in enumerate(TRIADS)}
    logging = np.random.default_rng([seed, 12])
    runs = []
    for physics in live_through(design, seed, hidden):
        counts = {
            name: triad_of(design, name).convert(physics.felt[name], physics.time_s, noise[name])
            for name in TRIADS
        }
        runs.append(
            RunLog(physics.run, physics.time_s, columns=_log(design, physics, logging), **counts)
        )
    stating = np.random.default_rng([seed, 13])
    clock = float(stating.standard_normal()) if design.clock_sd_relative else 0.0
    return Session(
        design=design,
        hidden=hidden,
        runs=tuple(runs),
        rates={
            run.name: state_rate(run, design, clock, stating)
            for run in design.runs
            if run.motion is not None
        },
        accelerometer=parameters(design.sensor.accelerometer),
        gyroscope=parameters(design.sensor.gyroscope),
        gyroscope_to_accelerometer=gyroscope_to_accelerometer(design.sensor),
    )


def _log(design: Design, physics: RunPhysics, rng: np.random.Generator) -> dict[str, FloatArray]:
    """The other columns as the logger writes them."""
    logged = {}
    for name, course in courses(design).items():
        true = physics.columns[name]
        noisy = true + course.logging_sd * rng.standard_normal(true.shape)
        logged[name] = np.round(noisy, course.decimals)
    return logged


def state_rate(run: Run, design: Design, clock: float, rng: np.random.Generator) -> StatedRate:
    """What is known of the plate's rate without a clip: the truth, off by a draw of its sd.

    ``clock`` is the error of the clock in units of its own sd, the same for all runs.
    """
    true = whole_turn_rate(run.motion)
    own, common = design.rate_sd_relative, design.clock_sd_relative
    off = own * float(rng.standard_normal()) + common * clock
    return StatedRate(true * (1 + off), abs(true) * float(np.hypot(own, common)), true, common)


def whole_turn_rate(motion: PlateMotion, seconds: float = 60.0) -> float:
    """Mean rate over as many whole turns as ``seconds`` hold, in rad/s."""
    if not motion.wow and motion.drift_rad_s2 == 0:
        return motion.rate_rad_s
    time_s = np.linspace(0, seconds, 60_001)
    turned = np.abs(motion.angle(time_s) - motion.angle_rad)
    turns = np.floor(turned[-1] / (2 * np.pi))
    elapsed = np.interp(2 * np.pi * turns, turned, time_s)
    return float(np.sign(motion.rate_rad_s) * 2 * np.pi * turns / elapsed)
