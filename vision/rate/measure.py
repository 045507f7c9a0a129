"""From a phase track to the plate's rate, with an uncertainty that can be trusted.

The rate is the slope of the angle against time, fitted together with a once- and a
twice-per-revolution wave (left out, they bias the slope through the partial last turn), with the
lag of pictures that the encoder predicted from earlier ones alone, and with the time of silently
lost pictures put back. That treatment is always on. The *stated* model is
``constant_rate`` and the terms the user added: residual, its size and the diagnosis refer to it,
so that adding the right term shows, while the rate does not hang on it. Only ``rate_drift`` enters
the rate's own fit when it is added; it leaves the mean rate alone and takes the drift out of the
uncertainty.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vision.errors import RateRefused
from vision.geometry import FloatArray
from vision.phase_track import BoolArray, PhaseTrack, PlateAngle, RateHistory
from vision.rate.aliases import choose_alias
from vision.rate.autocorrelation import LagRate, lag_rate
from vision.rate.camera_roll import camera_roll
from vision.rate.cross_checks import second_opinions
from vision.rate.diagnosis import PhaseDiagnosis, diagnose
from vision.rate.frame_count import FrameCount, count_frames
from vision.rate.least_squares import least_squares
from vision.rate.line_fit import fit_rate, without_lag
from vision.rate.stability import refuse_unsteady, refuse_wandering, uneven_warning
from vision.rate.terms import (
    CONSTANT_RATE,
    TERMS,
    UNITS,
    Regressors,
    columns,
    design,
)
from vision.rate.timebase import Timebase
from vision.rate.unwrap import plate_angle, rate_history, rough_rate, usable
from vision.rate.warnings import lost_pictures, rolling_camera, scattered_angle
from vision.rate.wow_flutter import SpeedFigures, speed_figures

FEWEST_USABLE = 12
FEWEST_TURNS = 1.0


@dataclass(frozen=True, eq=False)
class TermValue:
    """A fitted term of the stated model."""

    name: str
    value: FloatArray
    sd: FloatArray
    unit: str


@dataclass(frozen=True, eq=False)
class RateMeasurement:
    """The rate of the plate and everything that goes with it.

    Attributes
    ----------
    rate_rad_s, sd_rad_s : float
        Mean rate over the clip, positive, and its standard deviation, all parts together.
    image_sd_rad_s, timebase_sd_rad_s : float
        The parts: from the pictures, and from the clock they are stamped with.
    direction : str
        "ccw" or "cw", as filmed.
    revolutions : float
    frames : int
        Pictures in the fit.
    phase_rms_rad : float
        Of the residual of the stated model.
    frame_count : FrameCount or None
        By counting frames between alignments; None with less than a turn between them.
    lag_rate : LagRate or None
        By autocorrelation of the pictures; None where it finds no return.
    aliases : tuple of float
        Signed rates (positive counter-clockwise) that would give the same pictures; the chosen
        one first.
    alias_says : str
        Which was chosen and why.
    model : tuple of str
        The stated model, constant_rate first.
    terms : tuple of TermValue
    time_s, angle_rad, residual_rad : array, shape (u,)
        Repaired time from the first picture, plate angle wrapped to (-π, π], and the residual of
        the stated model.
    used : array of bool, shape (u,)
        Not an outlier of the rate's fit.
    history : RateHistory
    lost_frames, duplicate_frames : int
    speed : SpeedFigures
    diagnosis : PhaseDiagnosis
    channel : str
        What of the pictures was followed, as in the track.
    warnings : tuple of str
        A paragraph each.
    """

    rate_rad_s: float
    sd_rad_s: float
    image_sd_rad_s: float
    timebase_sd_rad_s: float
    direction: str
    revolutions: float
    frames: int
    phase_rms_rad: float
    frame_count: FrameCount | None
    lag_rate: LagRate | None
    aliases: tuple[float, ...]
    alias_says: str
    model: tuple[str, ...]
    terms: tuple[TermValue, ...]
    time_s: FloatArray
    angle_rad: FloatArray
    residual_rad: FloatArray
    used: BoolArray
    history: RateHistory
    lost_frames: int
    duplicate_frames: int
    speed: SpeedFigures
    diagnosis: PhaseDiagnosis
    channel: str
    warnings: tuple[str, ...]


def measure_rate(
    track: PhaseTrack,
    *,
    timebase: Timebase,
    nominal_rpm: float | None = None,
    model: Sequence[str] = (CONSTANT_RATE,),
) -> RateMeasurement:
    """Measure the rate.

    Parameters
    ----------
    track : PhaseTrack
    timebase : Timebase
    nominal_rpm : float, optional
        What the plate should do; chooses among the aliases and is compared with the result.
    model : sequence of str
        ``constant_rate`` and any of ``vision.rate.terms.TERMS``.

    Raises
    ------
    RateRefused
        Less than a turn, not steady, or stamps that cannot be times; with the rate against time
        where there is one.
    ValueError
        A term that does not exist.
    """
    stated = _stated_terms(model)
    stamps = timebase.times(track)
    if usable(track).sum() < FEWEST_USABLE:
        raise RateRefused(
            f"{track.source}: the plate is seen clearly in {int(usable(track).sum())} picture(s), "
            f"at least {FEWEST_USABLE} are needed; film it with nothing in the way."
        )
    alias = choose_alias(track, stamps, rough_rate(track, stamps), nominal_rpm)
    angle = plate_angle(track, stamps, alias.rate_rad_s)
    history = rate_history(angle)
    refuse_unsteady(track.source, history)
    if history.revolutions < FEWEST_TURNS:
        raise RateRefused(
            f"{track.source}: the plate makes {history.revolutions:.2f} of a turn in the clip, at "
            f"least one is needed to tell the rate from an off-centre view. Does it turn? Then "
            f"film for a minute.",
            history,
        )
    drift = "rate_drift" in stated
    fit, given, always = fit_rate(track, angle, alias.rate_rad_s, with_drift=drift)
    refuse_wandering(track.source, history, fit.noise)
    angle = without_lag(angle, fit, given, always)
    rate = float(fit.beta[1])
    lost = int(angle.dropped.sum())
    values, residual = _fit_stated(track.source, stated, angle, given, fit.used)
    diagnosis = diagnose(stated, given.rows(fit.used), angle.angle_rad[fit.used], lost)
    roll = camera_roll(track, stamps)
    # Which part of a roll the plate's own angle took up is not known well; all of it is doubt.
    image_sd = float(np.hypot(fit.sd[1], roll.rate_rad_s if roll else 0.0))
    clock_sd = abs(rate) * timebase.ppm * 1e-6
    count = count_frames(
        angle, track.plate.mark_azimuth_rad, track.plate.fixed_mark_azimuth_rad
    )
    # Where pictures are missing unseen, a lag in pictures is no time.
    lags = None if angle.dropped.any() else lag_rate(track, stamps, rate)
    warnings = (
        *track.notes,
        *alias.warnings,
        *uneven_warning(track.source, history),
        *lost_pictures(track.source, history, fit.noise),
        *scattered_angle(track.source, fit.noise, rate),
        *rolling_camera(track.source, roll, rate),
        *second_opinions(track, angle, rate, image_sd, count, lags),
    )
    return RateMeasurement(
        rate_rad_s=abs(rate),
        sd_rad_s=float(np.hypot(image_sd, clock_sd)),
        image_sd_rad_s=image_sd,
        timebase_sd_rad_s=clock_sd,
        direction="ccw" if rate > 0 else "cw",
        revolutions=history.revolutions,
        frames=int(fit.used.sum()),
        phase_rms_rad=float(np.sqrt((residual[fit.used] ** 2).mean())),
        frame_count=count,
        lag_rate=lags,
        # Alike to the picture, so at the same distances from the measured rate.
        aliases=tuple(rate + other - alias.rate_rad_s for other in alias.aliases),
        alias_says=alias.says,
        model=(CONSTANT_RATE, *stated),
        terms=values,
        time_s=angle.repaired_time_s,
        angle_rad=np.angle(np.exp(1j * angle.angle_rad)),
        residual_rad=residual,
        used=fit.used,
        history=history,
        lost_frames=lost,
        duplicate_frames=int(track.duplicate.sum()),
        speed=speed_figures(fit, given, always, angle.frame_s),
        diagnosis=diagnosis,
        channel=track.plate.channel,
        warnings=warnings,
    )


def _stated_terms(model: Sequence[str]) -> tuple[str, ...]:
    """The terms besides constant_rate, in the order given."""
    for name in model:
        if name != CONSTANT_RATE and name not in TERMS:
            raise ValueError(
                f"rate model: no term is named '{name}'; there are {CONSTANT_RATE}, "
                f"{', '.join(TERMS)}"
            )
    return tuple(dict.fromkeys(name for name in model if name != CONSTANT_RATE))


def _fit_stated(
    source: str,
    stated: tuple[str, ...],
    angle: PlateAngle,
    given: Regressors,
    used: BoolArray,
) -> tuple[tuple[TermValue, ...], FloatArray]:
    """Values of the stated terms, and the residual of the stated model on all rows."""
    present = [t for t in stated if t != "frame_steps" or angle.dropped.any()]
    x = design(present, given, given.stamp_s)
    try:
        fit = least_squares(x[used], angle.angle_rad[used])
    except np.linalg.LinAlgError as error:
        raise RateRefused(
            f"{source}: the terms {', '.join(present)} cannot be told apart in one clip: their "
            f"waves are the same. Remove one of them from the model."
        ) from error
    values, at = [], 2
    for term in present:
        width = columns(term, given).shape[1]
        part = slice(at, at + width)
        values.append(TermValue(term, fit.beta[part], fit.sd[part], UNITS[term]))
        at += width
    return tuple(values), angle.angle_rad - x @ fit.beta
