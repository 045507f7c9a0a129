"""Whether the shutter changed while filming, and what that does to the rate.

Cameras stamp a frame where its exposure begins, in its middle or where it ends, and do not say
which; what a frame shows is the middle. With an exposure e(t) the angle is therefore that of

    t + δ e(t),   δ between -1/2 and 1/2,

and a shutter that drifts adds up to slope(e)/2 to the relative rate. The smear along the turn has
the variance (Ω e)²/12, so its change shows that of e²; of e itself the largest change that goes
with it is the one from a closed shutter, e = √(e² - min e²). No exposure lasts longer than a frame,
T, so a change of e² lies between -T² and T². With z sds of a change that is known to σ, the odds O
of any change against none are

    O = o √(2π) σ/(2 T²) e^(z²/2)

(Jeffreys, Theory of Probability, 1961, section 5.2), o the odds beforehand, even where the light
changed. The less a clip can show, the less it takes to doubt it. The variance of the rate holds the
drift at its probability O/(1 + O): no threshold decides between all of it and nothing.
"""

from dataclasses import dataclass

import numpy as np

from vision.geometry import FloatArray
from vision.phase_track import PhaseTrack, PlateAngle
from vision.rate.least_squares import least_squares

BLACK = 16.0  # luma
GAMMA = 2.2  # of the luma's own scale against light
STRETCHES = 8  # of a clip, in which the exposure is taken as one
LIKELY = 0.5  # probability from which the user is told; it chooses the words only
FEWEST = 40  # frames in which the smear was seen


@dataclass(frozen=True)
class ExposureThresholds:
    """When the exposure counts as changed.

    Attributes
    ----------
    usual : float
        Odds, before the smear is looked at, that a camera changed its exposure while filming. An
        estimate for cameras that are not locked: one clip in ten.
    brighter : float
        Relative change of the light in the frames. Fact: an auto-exposure corrects in steps of a
        third or a sixth of a stop, 12 to 26 %.
    least_s : float
        A change of the exposure, s, that is worth a word. Fact: over 10 s it changes the rate by a
        tenth of a poor clock.
    """

    usual: float = 0.1
    brighter: float = 0.1
    least_s: float = 2e-4


THRESHOLDS = ExposureThresholds()


@dataclass(frozen=True)
class ExposureDrift:
    """An exposure that changed.

    Attributes
    ----------
    change_s : float
        At most, from the first stretch of the clip to the last.
    relative_sd : float
        Of the rate: half the slope of the exposure against time, weighed by the probability.
    probability : float
        That the exposure changed at all.
    evidence : str
        What shows it.
    """

    change_s: float
    relative_sd: float
    probability: float
    evidence: str


def exposure_drift(
    track: PhaseTrack, angle: PlateAngle, rate_rad_s: float
) -> ExposureDrift | None:
    """How far the exposure may have changed; None where neither smear nor brightness did.

    Parameters
    ----------
    track : PhaseTrack
    angle : PlateAngle
        Frames that are used, and their times.
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
    # Light that changed makes another shutter as likely as the same one.
    shine = ratio > 1 + THRESHOLDS.brighter
    before = 1.0 if shine else THRESHOLDS.usual
    odds = before * _odds_of_change(smear * span, smear_sd * span, angle.frame_s)
    share = odds / (1 + odds)
    level = _by_stretch(time, square)
    beyond = np.minimum(np.sqrt(np.maximum(level - level.min(), 0.0)), angle.frame_s)
    middle = _by_stretch(time, time)
    away = middle - middle.mean()
    relative = 0.5 * abs(float(away @ beyond / (away @ away)))
    evidence = "the smear of the plate"
    if shine:
        evidence += f" and the brightness ({ratio - 1:.0%})"
    return ExposureDrift(float(np.ptp(beyond)), relative * float(np.sqrt(share)), share, evidence)


def exposure_warnings(source: str, drift: ExposureDrift | None) -> tuple[str, ...]:
    """Warn of a shutter that changed."""
    if drift is None or drift.probability < LIKELY or drift.change_s < THRESHOLDS.least_s:
        return ()
    return (
        f"{source}: lock the exposure and film again: {drift.evidence} changes from the beginning "
        f"of the clip to its end, so the exposure may have changed by up to "
        f"{1e3 * drift.change_s:.1f} ms, and the middle of the exposure moved against the time "
        f"stamps. The sd includes {1e6 * drift.relative_sd:.0f} ppm for it.",
    )


def _odds_of_change(change_s2: float, sd_s2: float, frame_s: float) -> float:
    """Odds that e² changed, s², against that it stayed."""
    if sd_s2 == 0:
        return 0.0 if change_s2 == 0 else 1e300
    room = np.sqrt(2 * np.pi) * sd_s2 / (2 * frame_s**2)
    far = min(0.5 * (change_s2 / sd_s2) ** 2, 700.0)  # e^700 is finite
    return float(min(room, 1.0) * np.exp(far))


def _slope(time_s: FloatArray, values: FloatArray, angle_rad: FloatArray) -> tuple[float, float]:
    """Slope against time and its sd, beside what repeats with every turn."""
    if not np.ptp(values):
        return 0.0, 0.0
    waves = [f(k * angle_rad) for k in (1, 2) for f in (np.cos, np.sin)]
    x = np.stack([np.ones_like(time_s), time_s - time_s.mean(), *waves], axis=1)
    fit = least_squares(x, values, turn_rad=angle_rad)
    return float(fit.beta[1]), float(fit.sd[1])


def _by_stretch(time_s: FloatArray, values: FloatArray) -> FloatArray:
    """Median in each of some stretches of equal length."""
    edges = np.linspace(time_s[0], time_s[-1], STRETCHES + 1)[1:-1]
    parts = np.split(values, np.searchsorted(time_s, edges))
    return np.array([np.median(part) for part in parts if len(part)])
