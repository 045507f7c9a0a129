"""From a phase track to the plate's rate and its uncertainty.

The rate is the mean over the clip of the slope of the angle against time. It is fitted together
with a once- and a twice-per-revolution wave (omitted, they bias the slope through the partial last
turn), with an even drift, with the lag of frames that the encoder predicted from earlier ones
alone, and with the time of dropped frames added. This treatment is always active. The *stated*
model is ``constant_rate`` and the terms that the user added: residual, its size and the diagnosis
refer to it, so that the right term has a visible effect, while the rate does not depend on it.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from vision.errors import RateRefused
from vision.numbers import RPM
from vision.phase_track import PhaseTrack, RateHistory
from vision.rate.aliases import Aliases, list_aliases
from vision.rate.camera_roll import camera_roll
from vision.rate.checks import Seen, refuse, warnings
from vision.rate.cross_checks import CrossChecks, cross_check, strongest_return
from vision.rate.diagnosis import PhaseDiagnosis, diagnose
from vision.rate.dropped_frames import dropped_frames
from vision.rate.exposure import exposure_drift, exposure_warnings
from vision.rate.slow_camera import FrameTimes, frame_times
from vision.rate.slow_changes import MovingEnds, slow_rate
from vision.rate.steady_part import FEWEST_FRAMES, WHOLE, ClipPart, the_steady_part
from vision.rate.terms import (
    CONSTANT_RATE,
    LAG,
    TERMS,
    StatedFit,
    fit_rate,
    fit_stated,
)
from vision.rate.timebase import Timebase
from vision.rate.unwrap import continuous_angle, rate_history, rough_rate, usable


@dataclass(frozen=True)
class RateUncertainty:
    """Standard deviation of the rate by its parts.

    Attributes
    ----------
    image_rad_s : float
        From the frames: angles, doubtful dropped frames, a changed exposure, the frame time of a
        camera slower than its clip, turns that show the same angles, a camera that rolls.
    timebase_rad_s : float
        From the clock that stamps the frames.
    """

    image_rad_s: float
    timebase_rad_s: float

    @property
    def total_rad_s(self) -> float:
        """Both parts together."""
        return float(np.hypot(self.image_rad_s, self.timebase_rad_s))


@dataclass(frozen=True)
class FrameTally:
    """Numbers of frames used, dropped silently by the recorder, and delivered twice."""

    used: int
    dropped: int
    repeated: int


@dataclass(frozen=True, eq=False, repr=False)
class RateMeasurement:
    """The rate of the plate and everything that goes with it.

    Attributes
    ----------
    rate_rad_s : float
        Mean rate over the clip, positive.
    direction : str
        "ccw" or "cw", as filmed.
    uncertainty : RateUncertainty
    frames : FrameTally
    fit : StatedFit
    aliases : Aliases
        Signed rates that would give the same frames, the chosen one first.
    cross_checks : CrossChecks
        The rate by other methods.
    history : RateHistory
        The rate from turn to turn.
    diagnosis : PhaseDiagnosis
        The term that the stated model lacks.
    channel : str
        Tracked quantity of the frames, as in the track.
    warnings : tuple of str
        One paragraph each.
    """

    rate_rad_s: float
    direction: str
    uncertainty: RateUncertainty
    frames: FrameTally
    fit: StatedFit
    aliases: Aliases
    cross_checks: CrossChecks
    history: RateHistory
    diagnosis: PhaseDiagnosis
    channel: str
    warnings: tuple[str, ...]

    def __repr__(self) -> str:
        return (f"{self.rate_rad_s:.7g} rad/s ± {self.sd_rad_s:.2g} ({self.rate_rad_s / RPM:.6g} "
                f"rpm, {self.direction}, {self.revolutions:.1f} revolutions)")

    @property
    def sd_rad_s(self) -> float:
        """Standard deviation of the rate, all parts together."""
        return self.uncertainty.total_rad_s

    @property
    def revolutions(self) -> float:
        """Turns of the plate in the clip."""
        return self.history.revolutions


def measure_rate(
    track: PhaseTrack,
    *,
    timebase: Timebase,
    nominal_rpm: float | None = None,
    model: Sequence[str] = (CONSTANT_RATE,),
    part: ClipPart = WHOLE,
) -> RateMeasurement:
    """Measure the rate; in a clip with the motor's start or stop, that of the steady part.

    Parameters
    ----------
    track : PhaseTrack
    timebase : Timebase
    nominal_rpm : float, optional
        Expected rate; chooses among the aliases and is compared with the result.
    model : sequence of str
        ``constant_rate`` and any of ``vision.rate.terms.TERMS``.
    part : ClipPart
        Measured part of the clip; if it is stated, no steady part is searched.

    Returns
    -------
    RateMeasurement

    Raises
    ------
    RateRefused
        Less than a turn, not steady, or stamps that cannot be times; with the rate against time
        if there is one.
    ValueError
        A term that does not exist.
    """
    stated = _stated_terms(model)
    frames = frame_times(track, timebase.times(track))
    rate, refusal = None, None
    try:
        rate = _measured(frames.part(part), timebase, nominal_rpm, stated)
    except RateRefused as error:
        refusal = error
    history = rate.history if rate else refusal.history if refusal else None
    steady = the_steady_part(history) if history and part == WHOLE else None
    if history and steady and (refusal or any(steady.moving_ends(history)[:2])):
        with suppress(RateRefused):
            chosen = frames.part(ClipPart(steady.start_s, steady.stop_s))
            rate = _measured(chosen, timebase, nominal_rpm, stated, steady.moving_ends(history))
            warning = steady.warning(track.source, float(frames.time_s[-1]))
            return replace(rate, warnings=(warning, *rate.warnings))
    if refusal:
        raise refusal
    assert rate
    return rate


def _measured(
    frames: FrameTimes,
    timebase: Timebase,
    nominal_rpm: float | None,
    stated: tuple[str, ...],
    ends: MovingEnds = (False, False, False),
) -> RateMeasurement:
    track, stamps = frames.track, frames.time_s
    _require_usable(track)
    returns = strongest_return(track, stamps)
    aliases = list_aliases(track, stamps, rough_rate(track, stamps), nominal_rpm, returns)
    dropped = dropped_frames(continuous_angle(track, stamps, aliases.chosen_rad_s))
    angle = dropped.angle
    fit, x, base = fit_rate(track, angle, dropped.stray, aliases.chosen_rad_s)
    mean = slow_rate(fit, x, angle.angle_rad, base, ends)
    seen = Seen(track, rate_history(angle, dropped.stray), mean, fit.noise)
    refuse(seen)
    rate = mean.rate_rad_s
    angle = replace(angle, angle_rad=angle.angle_rad - fit.beta[LAG] * base.forward)
    exposure = exposure_drift(track, angle, rate)
    roll = camera_roll(track)
    parts = (
        mean.sd_rad_s,
        dropped.sd_of_rate * rate,
        exposure.relative_sd * rate if exposure else 0.0,
        frames.relative_sd * rate,
        track.leaning_frames * angle.frame_s / float(np.ptp(angle.time_s)) * rate,
        roll.rate_rad_s,
    )
    checks = cross_check(angle, rate, returns)
    uncertainty = RateUncertainty(
        image_rad_s=float(np.linalg.norm(parts)),
        timebase_rad_s=abs(rate) * timebase.ppm * 1e-6,
    )
    return RateMeasurement(
        rate_rad_s=abs(rate),
        direction="ccw" if rate > 0 else "cw",
        uncertainty=uncertainty,
        frames=FrameTally(int(fit.used.sum()), dropped.count, int(frames.repetitions.sum())),
        fit=fit_stated(track.source, stated, angle, base, fit.used),
        aliases=aliases.about(rate),
        cross_checks=checks,
        history=seen.history,
        diagnosis=diagnose(
            stated, base.rows(fit.used), angle.angle_rad[fit.used], dropped.count
        ),
        channel=track.plate.channel,
        warnings=(
            *track.notes,
            *frames.warnings,
            *aliases.warnings,
            *dropped.warnings(track.source),
            *warnings(seen),
            *exposure_warnings(track.source, exposure),
            *roll.warnings(track.source, rate),
        ),
    )


def _require_usable(track: PhaseTrack) -> None:
    count = int(usable(track).sum())
    if count < FEWEST_FRAMES:
        raise RateRefused(
            f"{track.source}: what was taken for the plate is seen clearly in {count} frame(s), at "
            f"least {FEWEST_FRAMES} are needed. Film it with nothing in the way."
        )


def _stated_terms(model: Sequence[str]) -> tuple[str, ...]:
    """The terms besides constant_rate, in their order."""
    for name in model:
        if name != CONSTANT_RATE and name not in TERMS:
            raise ValueError(
                f"rate model: no term is named '{name}'; there are {CONSTANT_RATE}, "
                f"{', '.join(TERMS)}"
            )
    return tuple(dict.fromkeys(name for name in model if name != CONSTANT_RATE))
