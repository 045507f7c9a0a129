"""Changes of the exposure time while filming, and their effect on the rate.

Cameras stamp a frame at the start, in the middle or at the end of its exposure, and do not state
which; a frame shows the middle. With an exposure e(t) the angle is therefore that of

    t + δ e(t),   δ between -1/2 and 1/2,

and a drift of the exposure adds up to slope(e)/2 to the relative rate. The motion blur along the
turn has the variance (Ω e)²/12, so its change shows c, the change of e²; the largest compatible
change of e itself is the one from zero exposure, √|c|. No exposure lasts longer than a frame, T, so
c lies between -T² and T², with a uniform prior. With s the change that the blur shows, known to σ,
the odds O of any change against none are

    O = o/(2 T²) ∫ e^((s² - (s - c)²)/(2 σ²)) dc

(Jeffreys, Theory of Probability, 1961, section 5.2), o the prior odds, even if the light changed.
The less a clip can show, the less it takes to doubt it. The variance of the rate contains the mean
of |c|, weighted by the same integrand, at the probability O/(1 + O): a blur that shows little
permits large changes, and no threshold decides between all of the drift and nothing.
"""

from dataclasses import dataclass

import numpy as np

from vision.geometry import FloatArray
from vision.phase_track import PhaseTrack, PlateAngle
from vision.rate.least_squares import least_squares
from vision.rate.unwrap import waves_per_turn

BLACK = 16.0  # luma
GAMMA = 2.2  # of luma against light
LIKELY = 0.5  # probability from which the user is warned; it chooses the words only
FEWEST = 40  # least number of frames with a measured blur
REACH, POINTS = 6.0, 401  # sds on both sides, and points, of the integral; numerical


# Limits for a changed exposure.
USUAL = 0.02
"""Prior odds that a camera changed its exposure while filming, if the light in the frames is
constant. An estimate for cameras that are not locked; tuned so that it does not widen sound films,
tests.bench.clip_study from seed 310000 on."""
BRIGHTER = 0.1
"""Relative change of the light in the frames. Fact: an auto-exposure corrects in steps of a third
or a sixth of a stop, 12 to 26 %."""


@dataclass(frozen=True)
class ExposureDrift:
    """A changed exposure.

    Attributes
    ----------
    change_s : float
        Largest change from the beginning of the clip to its end, if there is one.
    relative_sd : float
        Relative sd of the rate: half that change over the time, weighted by the probability.
    probability : float
        Probability that the exposure changed at all.
    brighter : bool
        Whether the brightness of the frames changed too.
    evidence : str
        Evidence of the change.
    """

    change_s: float
    relative_sd: float
    probability: float
    brighter: bool
    evidence: str


def exposure_drift(
    track: PhaseTrack, angle: PlateAngle, rate_rad_s: float
) -> ExposureDrift | None:
    """Possible change of the exposure; None if neither blur nor brightness changed.

    Parameters
    ----------
    track : PhaseTrack
    angle : PlateAngle
        Used frames, and their times.
    rate_rad_s : float
    """
    square = 12 * track.smear_rad2[angle.index] / rate_rad_s**2  # e² beyond that of the template
    seen = np.isfinite(square)
    if seen.sum() < FEWEST:
        return None
    time, square = angle.repaired_time_s[seen], square[seen]
    span = float(time[-1] - time[0])
    smear, smear_sd = _slope(time, square, angle.angle_rad[seen])
    light = np.log(np.maximum(track.brightness[angle.index][seen] - BLACK, 1.0)) * GAMMA
    brighter, _ = _slope(time, light, angle.angle_rad[seen])
    ratio = float(np.exp(abs(brighter) * span))
    # If the light changed, another exposure is as probable as the same one.
    shine = ratio > 1 + BRIGHTER
    before = 1.0 if shine else USUAL
    odds, change = _change(smear * span, smear_sd * span, angle.frame_s**2)
    share = before * odds / (1 + before * odds)
    change_s = float(np.sqrt(change))
    evidence = "the smear of the plate"
    if shine:
        evidence += f" and the brightness ({ratio - 1:.0%})"
    relative_sd = 0.5 * change_s / span * float(np.sqrt(share))
    return ExposureDrift(change_s, relative_sd, share, shine, evidence)


def exposure_warnings(source: str, drift: ExposureDrift | None) -> tuple[str, ...]:
    """Warnings of a changed exposure."""
    if drift is None or drift.probability < LIKELY:
        return ()
    unless = "" if drift.brighter else ", unless it is locked already,"
    return (
        f"{source}: lock the exposure{unless} and film again: {drift.evidence} changes from the "
        f"beginning of the clip to its end, so the exposure may have changed by up to "
        f"{1e3 * drift.change_s:.1f} ms, and the middle of the exposure moved against the time "
        f"stamps. The sd includes {1e6 * drift.relative_sd:.0f} ppm for it.",
    )


def _change(shown: float, sd: float, most: float) -> tuple[float, float]:
    """Odds of a change of e² against none, at even prior odds, and the mean size of the change.

    All in s²: the change that the blur shows and its sd, the largest possible one, and the mean
    size over the posterior.
    """
    shown = min(max(shown, -most), most)  # the excess is noise
    sd = max(sd, most * np.finfo(float).eps)
    change = np.linspace(max(-most, shown - REACH * sd), min(most, shown + REACH * sd), POINTS)
    exponent = (2 * shown - change) * change / (2 * sd**2)
    weight = np.exp(exponent - exponent.max())
    total = np.trapezoid(weight, change)
    odds = np.exp(min(exponent.max(), 700.0)) * total / (2 * most)  # e^700 is finite
    return float(odds), float(np.trapezoid(weight * np.abs(change), change) / total)


def _slope(time_s: FloatArray, values: FloatArray, angle_rad: FloatArray) -> tuple[float, float]:
    """Slope against time and its sd, beside the part that repeats with every turn."""
    x = np.column_stack([np.ones_like(time_s), time_s - time_s.mean(), waves_per_turn(angle_rad)])
    fit = least_squares(x, values)
    return float(fit.beta[1]), float(fit.sd[1])

