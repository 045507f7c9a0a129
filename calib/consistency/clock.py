"""The plate's rate in the log's own clock, from the accelerometer alone.

No plate is level. On a plate that leans by a degree, the component of gravity across the plate's
axis rotates once per turn in the axes of the sensor, in a circle and against the plate:

    z(t) = f·e1 + i f·e2 = g sin(lean) exp(-i Ω (t - t0)),   e1, e2, up right-handed

so the frequency of z is the plate's rate, sign included, in the clock of the stamps. It depends
neither on the gyro's gain nor on the camera: a wrong rate of a run, stamps that are not seconds,
and a gyro with the wrong sign show as contradictions. A plate that leans by less than the
accelerometer's noise shows nothing, and nothing is reported.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib.consistency.data_sheet import SHEET_TOLERANCE
from calib.errors import Contradiction
from calib.numbers import RPM
from calib.poses.attitudes import two_across
from calib.poses.averaging.average_pose import LEAST_PER_TURN
from calib.poses.data_sheet import Specs, TriadSpec
from calib.poses.imu_log import FloatArray, ImuLog

LEAST_SHARE = 0.5
"""Share of the specific force across gravity that must rotate for its rate to count as known:
nothing else can then be as large. Derived."""

LEFT_SHARE = 0.1
"""Share of that at the stated rate, below which the two rates contradict each other. A judgement: a
wave two turns away leaks less than 3 % into it."""

LARGEST_CLOCK_ERROR = 0.05
"""Relative error of the oscillator of a controller or sensor without a crystal. A fact: internal RC
oscillators are stated to 1 to 5 % over temperature."""

FASTEST, SLOWEST = 6.0, 0.1
"""Range of the searched rates, in units of the stated one: 78 over 16 rpm is 4.7. Derived from the
speeds of record players; slower than a tenth, no pose contains whole turns."""

FEWEST_TURNS = 2.0
"""Number of turns in the median pose: below it, a wave cannot be told from a drift. Derived."""

PER_RESOLUTION = 12
"""Number of searched rates per resolution of the spectrum (one over the turns). Numerical: the best
of them is within a 24th of the resolution of the maximum."""

PADDING = 8
"""Zero padding, log lengths, for a spectrum dense enough to interpolate. Numerical."""

SAMPLES_PER_TURN = 3.0
"""Samples in a turn of the fastest searched rate, after averaging. Derived: more than two show a
wave. Numerical."""

FEWEST_MEANS = 12
"""Fewest means from which a line is subtracted. Derived: six of each half. Numerical."""

LARGEST_GAIN = 1 / (1 - SHEET_TOLERANCE)
"""Largest ratio of a gyro's gain to that of its data sheet, or its inverse. Derived from the
tolerance of data sheets."""


@dataclass(frozen=True)
class GravityWave:
    """Signed rate of the plate by the accelerometer, rad per unit of the stamps, positive ccw.

    ``share`` is the share of the specific force across gravity that rotates at this rate,
    ``share_stated`` the same at the stated rate, in the better of both directions.
    """

    rate: float
    share: float
    share_stated: float

    @property
    def sense(self) -> float:
        """+1 counter-clockwise seen from above, -1 clockwise."""
        return float(np.sign(self.rate))

    @property
    def is_clear(self) -> bool:
        """Whether the rate is known at all."""
        return self.share >= LEAST_SHARE


def gravity_wave(logs: Sequence[ImuLog], stated: FloatArray, spec: TriadSpec) -> GravityWave | None:
    """Rotating part of the specific force in the poses of one run.

    Parameters
    ----------
    logs : sequence of ImuLog, length n
        Poses on the turning plate.
    stated : array, shape (n,)
        The plate's rate in each, positive, rad/s.
    spec : TriadSpec
        Of the accelerometer.

    Returns
    -------
    GravityWave or None
        None where the accelerometer was not logged, or the poses are too short to tell.
    """
    if not all(log.has("accelerometer") for log in logs):
        return None
    turns = np.array([w * (log.time_s[-1] - log.time_s[0]) / (2 * np.pi)
                      for log, w in zip(logs, stated, strict=True)])
    samples = np.array([len(log.time_s) for log in logs])
    if np.median(turns) < FEWEST_TURNS or (samples < LEAST_PER_TURN * turns).any():
        return None
    low = max(SLOWEST, FEWEST_TURNS / float(np.median(turns)))
    count = int((FASTEST - low) * np.median(turns) * PER_RESOLUTION) + 1
    ratios = np.linspace(low, FASTEST, count)
    signed = np.concatenate([-ratios, ratios])
    power, whole = np.zeros(len(signed)), 0.0
    for log, rate in zip(logs, stated, strict=True):
        step_s, z = across_gravity(log, float(rate), spec)
        # z rotates against the plate: its power at -Ω is the plate's at Ω.
        padded = np.abs(np.fft.fftshift(np.fft.fft(z, PADDING * len(z)))) ** 2 / len(z)
        at = np.fft.fftshift(np.fft.fftfreq(PADDING * len(z), step_s / (2 * np.pi)))
        power += np.interp(-signed * rate, at, padded)
        whole += float((np.abs(z) ** 2).sum())
    if whole == 0:
        return None
    share = power / whole
    near = np.abs(np.abs(signed) - 1) * np.median(turns) <= 1.0
    best = int(np.argmax(share))
    return GravityWave(
        rate=float(signed[best] * np.median(stated)),
        share=float(share[best]),
        share_stated=float(share[near].max()),
    )


def across_gravity(log: ImuLog, rate: float, spec: TriadSpec) -> tuple[float, np.ndarray]:
    """Specific force across gravity on a plate that turns at ``rate`` rad/s.

    Returns
    -------
    float
        The step of the means, s.
    array, shape (m,)
        Complex, in m/s²: along two axes across the mean, averaged, without mean and trend.
    """
    span = log.time_s[-1] - log.time_s[0]
    wanted = max(FEWEST_MEANS, int(span * rate * FASTEST / (2 * np.pi) * SAMPLES_PER_TURN))
    per = max(1, len(log.time_s) // wanted)
    n = len(log.time_s) // per
    force = spec.nominal(log.accelerometer[: n * per]).reshape(n, per, 3).mean(axis=1)
    up = force.mean(axis=0)
    size = float(np.linalg.norm(up))
    e1, e2 = two_across(up[None] / size if size else np.eye(3)[:1])[0]
    z = force @ e1 + 1j * (force @ e2)
    line = np.column_stack([np.ones(n), np.arange(n) / n])
    z = z - line @ np.linalg.lstsq(line.astype(complex), z)[0]
    return span / (len(log.time_s) - 1) * per, z


def require_whole_turns(
    run: str,
    logs: Sequence[ImuLog],
    stated: FloatArray,
    specs: Specs,
    others: Mapping[str, float],
) -> GravityWave | None:
    """Refuse a run in which gravity rotates at quite another rate than the plate's.

    Parameters
    ----------
    run : str
    logs : sequence of ImuLog, length n
    stated : array, shape (n,)
        The plate's rate in each, positive, rad/s.
    specs : mapping of triad to TriadSpec
        The accelerometer's and, if it was logged, that of the gyro, which shows which of the two
        rates is wrong.
    others : mapping of str to float
        The rates of the other settings.

    Returns
    -------
    GravityWave or None
        The rotating part, if that is clear.

    Raises
    ------
    Contradiction
        Naming the likely mistake.
    """
    wave = gravity_wave(logs, stated, specs["accelerometer"])
    if wave is None or not wave.is_clear:
        return None
    rate, plate = abs(wave.rate), float(np.median(stated))
    if wave.share_stated > LEFT_SHARE * wave.share or abs(rate / plate - 1) < LARGEST_CLOCK_ERROR:
        return wave
    gyro_rate = _gyro_rate(logs, specs.get("gyroscope"))
    raise Contradiction(
        f"{run}: by the time stamps of its logs the plate turned at {_rpm(rate)}: gravity goes "
        f"round once per turn in the accelerometer. The rate of this run is {_rpm(plate)}. "
        f"{_likely(run, rate, plate, gyro_rate, others)}"
    )


def _gyro_rate(logs: Sequence[ImuLog], spec: TriadSpec | None) -> float | None:
    """Rate of the gyro by its data sheet, rad/s; None where it was not logged."""
    if spec is None or not all(log.has("gyroscope") for log in logs):
        return None
    means = np.array([spec.nominal(log.gyroscope).mean(axis=0) for log in logs])
    return float(np.median(np.linalg.norm(means, axis=1)))


def _likely(
    run: str, rate: float, plate: float, gyro_rate: float | None, others: Mapping[str, float]
) -> str:
    same = [name for name, other in others.items() if abs(other / rate - 1) < LARGEST_CLOCK_ERROR]
    gyro_agrees = (gyro_rate is not None
                   and 1 / LARGEST_GAIN < gyro_rate / plate < LARGEST_GAIN)
    if abs(rate / (plate * RPM) - 1) < LARGEST_CLOCK_ERROR:
        return (
            f"As rpm the number would be right: {plate:.4g} rpm are {plate * RPM:.4g} rad/s. State "
            f"the rate in rad/s."
        )
    if gyro_agrees:
        return (
            f"The gyroscope agrees with that rate, so the stamps do not count seconds: they run "
            f"{_pace(plate / rate)}. Bring time_s to seconds."
        )
    if same:
        return (
            f"That is the rate of '{same[0]}': the files of '{run}' look like poses at "
            f"'{same[0]}'. Name the setting at which they were recorded, or, if their clips were "
            f"exchanged, exchange them back."
        )
    return (
        f"Either the rate belongs to another run (it would have to be {rate / plate:.3g} times as "
        f"large), or time_s does not count seconds (it would run {_pace(plate / rate)}). "
        f"Check both."
    )


def _pace(ratio: float) -> str:
    """What a clock does that counts ``ratio`` seconds in one."""
    return f"{ratio:.3g} times too fast" if ratio > 1 else f"{1 / ratio:.3g} times too slowly"


def _rpm(rate_rad_s: float) -> str:
    return f"{rate_rad_s / RPM:.4g} rpm"
