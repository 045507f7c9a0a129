"""Whether one number can stand for the rate of a clip: steady, drifting, stopping, rolling."""

from dataclasses import dataclass

import numpy as np

from vision.errors import RateRefused
from vision.geometry import FloatArray
from vision.numbers import RPM, SD_PER_MAD
from vision.phase_track import PhaseTrack, RateHistory
from vision.rate.steady_part import steady_parts

FEWEST_STRETCHES = 3  # that a clip is averaged in
FEWEST_ROLLS = 6  # frames in which the surroundings were looked at
SMOOTHED_ROLLS = 5  # of them


@dataclass(frozen=True)
class StabilityThresholds:
    """When a rate is not constant, and what is worth a warning.

    Attributes
    ----------
    unsteady : float
        Relative change of the rate within a clip that is refused. Fact: the scale of a sensor
        calibrated against a mean rate errs by up to as much.
    uneven : float
        Relative change that is worth a warning. Fact: ten times a poor clock (100 ppm).
    stopped : float
        Of the fastest rate: a clip that ends slower shows a stop, one that begins slower a run-up.
        It chooses the words, not the refusal.
    peak_to_peak : float
        Sds between the extremes of a hundred overlapping turns of white noise. Derived: 5 for
        independent values (Tippett), and a margin for the heavy tails of late stamps.
    hidden_drop : float
        Of the angle from frame to frame: a scatter that hides a dropped frame.
    wandering : float
        Times the noise of single frames: a scatter that is no noise.
    scattered_rad : float
        Scatter about an even rotation worth a warning, rad. Ten times that of a poor clip
        (``tests.bench.vision_films``).
    rolled_rad : float
        Range of the camera's roll that matters, rad.
    clear_roll : float
        Times the noise of one roll, that the range exceeds.
    """

    unsteady: float = 0.01
    uneven: float = 0.001
    stopped: float = 0.5
    peak_to_peak: float = 8.0
    hidden_drop: float = 0.5
    wandering: float = 5.0
    scattered_rad: float = 0.0122
    rolled_rad: float = 0.0052
    clear_roll: float = 8.0


THRESHOLDS = StabilityThresholds()


def refuse_unsteady(source: str, history: RateHistory) -> None:
    """Raise if the rate is not constant.

    Parameters
    ----------
    source : str
        Name of the clip.
    history : RateHistory

    Raises
    ------
    RateRefused
        With the history and the stretch that is steady, if there is one.
    """
    rate, _ = _forward(history)
    if _variation(rate) < THRESHOLDS.unsteady:
        return
    first, last, fastest = rate[0] / RPM, rate[-1] / RPM, rate.max() / RPM
    if rate.min() < -THRESHOLDS.stopped * rate.max():
        kind = "changes its direction"
    elif last < THRESHOLDS.stopped * fastest:
        kind = "slows down"
    elif first < THRESHOLDS.stopped * fastest:
        kind = "is still running up"
    else:
        kind = "does not turn steadily"
    span = f"from {history.time_s[0]:.1f} s to {history.time_s[-1]:.1f} s"
    raise RateRefused(
        f"{source}: the plate {kind}: {span} it goes from {first:.2f} to {last:.2f} rpm "
        f"(slowest {rate.min() / RPM:.2f}, fastest {fastest:.2f}) in {history.revolutions:.2f} "
        f"turns. A constant rate may change by at most {THRESHOLDS.unsteady:.0%}. "
        f"{_advice(history)}",
        history,
    )


def refuse_wandering(source: str, history: RateHistory, scatter_rad: float) -> None:
    """Raise where dropped frames look like an uneven rotation.

    Frames that a recorder drops silently make the angle jump. With a fast camera the jumps are
    small; blurred by an encoder they are a slow wander, and the rate is too high by their share.

    Parameters
    ----------
    source : str
    history : RateHistory
    scatter_rad : float
        Noise of the rate's fit, rad.

    Raises
    ------
    RateRefused
    """
    step = _angle_step(history)
    limit = max(THRESHOLDS.hidden_drop * step, THRESHOLDS.wandering * history.phase_noise_rad)
    if scatter_rad < limit:
        return
    raise RateRefused(
        f"{source}: the angle wanders by {np.degrees(scatter_rad):.2f}° about an even rotation, "
        f"while the noise of a frame is {np.degrees(history.phase_noise_rad):.2f}° and the plate "
        f"turns by {np.degrees(step):.2f}° from frame to frame: this clip cannot determine whether "
        f"frames were dropped. Put a bold mark near the rim; where there is one, film with fewer "
        f"frames per second.",
        history,
    )


def stability_warnings(
    source: str, history: RateHistory, scatter_rad: float, dropped: int
) -> tuple[str, ...]:
    """Warn of a rate that changes a little, of an angle that scatters, of what it hides.

    Parameters
    ----------
    source : str
    history : RateHistory
    scatter_rad : float
        Noise of the rate's fit, rad.
    dropped : int
        Frames known to be dropped; where there are some, the angle does not hide them.
    """
    rate, spread = _forward(history)
    change = _variation(rate)
    warnings = []
    if change >= max(THRESHOLDS.uneven, spread):
        warnings.append(
            f"{source}: the rate changes by {change:.2%} within the clip. The result is its mean; "
            f"a sensor logged at another time may have seen another rate."
        )
    step = _angle_step(history)
    if not dropped and scatter_rad >= THRESHOLDS.hidden_drop * step:
        warnings.append(
            f"{source}: the plate turns by {np.degrees(step):.2f}° from frame to frame and the "
            f"angle scatters by {np.degrees(scatter_rad):.2f}°: a dropped frame would not be "
            f"noticed, and one in a hundred makes the rate 1 % too high. Put a bold mark near the "
            f"rim; where there is one, film with fewer frames per second."
        )
    if scatter_rad >= THRESHOLDS.scattered_rad:
        late_ms = 1e3 * scatter_rad / float(np.abs(np.median(rate)))
        warnings.append(
            f"{source}: the angle scatters by {np.degrees(scatter_rad):.1f}° about an even "
            f"rotation; a plate filmed from a stand gives some hundredths. The cause is noise in "
            f"the frames, time stamps that are late by {late_ms:.0f} ms, a camera that moves, or "
            f"an object that is no plate. The sd includes it; --overlay shows what was tracked."
        )
    return tuple(warnings)


def _angle_step(history: RateHistory) -> float:
    """Usual angle from frame to frame, rad."""
    return float(np.median(np.abs(np.diff(history.angle.angle_rad))))


def _variation(rate: FloatArray) -> float:
    """Relative change from turn to turn."""
    return float(np.ptp(rate) / max(abs(np.median(rate)), 1e-9))


def _forward(history: RateHistory) -> tuple[FloatArray, float]:
    """Rates from turn to turn, and how far apart noise alone would spread them, relative.

    Positive in the direction of most of them; without strays; averaged over as many turns as it
    takes to see an unsteady plate through the noise of single frames: stamps that come a few
    milliseconds early or late are no change of the rate.
    """
    rate = _without_strays(history.rate_rad_s)
    # The mean over n windows of a turn, half a turn apart, keeps the noise of two frames at either
    # end, over n half turns.
    spread = noise_of_turns(history)
    wanted = int(np.ceil(spread / THRESHOLDS.unsteady))
    span = min(wanted, len(rate) // FEWEST_STRETCHES) or 1
    rate = np.lib.stride_tricks.sliding_window_view(rate, span).mean(axis=1)
    return rate * (np.sign(np.median(rate)) or 1.0), float(spread / span)


def _without_strays(rate: FloatArray) -> FloatArray:
    if len(rate) < 5:
        return rate
    return np.median(np.lib.stride_tricks.sliding_window_view(rate, 3), axis=1)


def _advice(history: RateHistory) -> str:
    """What to do, with the parts that could be used, if there are some."""
    parts = steady_parts(history, noise_of_turns(history))
    if not parts:
        return "Let the plate settle and film again."
    named = " and ".join(
        f"from {part.start_s:.1f} s to {part.stop_s:.1f} s ({part.rate_rad_s / RPM:+.2f} rpm)"
        for part in sorted(parts, key=lambda part: part.start_s)
    )
    return f"It is steady {named}: measure one such part alone (--from, --to, or from_s, to_s)."


def noise_of_turns(history: RateHistory) -> float:
    """Relative range of the rate from turn to turn by the noise of the angles alone."""
    return float(THRESHOLDS.peak_to_peak * 2 * history.phase_noise_rad / (2 * np.pi))


@dataclass(frozen=True)
class CameraRoll:
    """A camera that rolled while it filmed.

    Attributes
    ----------
    range_rad : float
        How far, rad.
    rate_rad_s : float
        Slope against time, counter-clockwise as filmed: what it adds to the rate of the plate.
    """

    range_rad: float
    rate_rad_s: float


def camera_roll(track: PhaseTrack, time_s: FloatArray) -> CameraRoll | None:
    """The camera's roll; None where it stood still, or where that cannot be seen.

    Parameters
    ----------
    track : PhaseTrack
    time_s : array, shape (f,)
        Of every frame of the track, s.
    """
    seen = np.isfinite(track.roll_rad)
    if seen.sum() < FEWEST_ROLLS:
        return None
    time, roll = time_s[seen], track.roll_rad[seen]
    noise = SD_PER_MAD * float(np.median(np.abs(np.diff(roll, 2)))) / np.sqrt(6.0)
    smooth = np.median(np.lib.stride_tricks.sliding_window_view(roll, SMOOTHED_ROLLS), axis=1)
    range_rad = float(np.ptp(smooth))
    if range_rad < max(THRESHOLDS.rolled_rad, THRESHOLDS.clear_roll * noise):
        return None
    away = time - time.mean()
    return CameraRoll(range_rad, float(away @ roll / (away @ away)))


def roll_warnings(source: str, roll: CameraRoll | None, rate_rad_s: float) -> tuple[str, ...]:
    """Warn of a camera that rolled while it filmed a plate at ``rate_rad_s``."""
    if roll is None:
        return ()
    share = abs(roll.rate_rad_s / rate_rad_s)
    return (
        f"{source}: the camera rolled by {np.degrees(roll.range_rad):.1f}° while it filmed, as "
        f"what lies around the plate shows. Up to {share * 1e6:.0f} ppm of the rate may come from "
        f"the camera; the sd includes them. Fix the camera to a stand and film again.",
    )
