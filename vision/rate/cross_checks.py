"""Three more ways to the rate, none as good, that would notice if the first went wrong.

The centroid of the mark, the count of frames between alignments, and the return of the picture
after whole turns. They are compared with the rate, not averaged with it.
"""

import numpy as np

from vision.geometry import FloatArray
from vision.phase_track import PhaseTrack, PlateAngle
from vision.rate.aliases import RPM
from vision.rate.autocorrelation import LagRate
from vision.rate.frame_count import END_SD, FrameCount
from vision.rate.least_squares import least_squares

APART = 5.0  # standard deviations
CENTROID_MATTERS = 50e-6  # relative
LAG_MATTERS = 2e-3  # relative
COUNT_APART = 1.05  # frames; rounding both ends gives up to one
SLIPPED = 0.02  # of the pictures with the centroid elsewhere than the refined angle


def second_opinions(
    track: PhaseTrack,
    angle: PlateAngle,
    rate_rad_s: float,
    sd_rad_s: float,
    count: FrameCount | None,
    lags: LagRate | None,
) -> tuple[str, ...]:
    """A paragraph for each way that disagrees."""
    says = []
    rate = abs(rate_rad_s)
    if (text := _centroid(track, angle, rate_rad_s, sd_rad_s)) is not None:
        says.append(text)
    if count is not None:
        frames = abs(count.rate_rad_s - rate) / count.sd_rad_s * END_SD
        if frames > COUNT_APART:
            says.append(
                f"{track.source}: counting frames between alignments gives "
                f"{count.rate_rad_s / RPM:.4f} ± {count.sd_rad_s / RPM:.4f} rpm, the regression "
                f"{rate / RPM:.4f} rpm: more apart than one frame. Look at the annotated picture: "
                f"is the mark the mark?"
            )
    if lags is not None:
        apart = abs(lags.rate_rad_s - rate)
        if apart > APART * np.hypot(lags.sd_rad_s, sd_rad_s) and apart > LAG_MATTERS * rate:
            says.append(
                f"{track.source}: the picture returns after whole turns at "
                f"{lags.rate_rad_s / RPM:.4f} ± {lags.sd_rad_s / RPM:.4f} rpm, the regression "
                f"gives {rate / RPM:.4f} rpm. Something else in the picture may be turning, or "
                f"turns were miscounted."
            )
    return tuple(says)


def _centroid(
    track: PhaseTrack, angle: PlateAngle, rate_rad_s: float, sd_rad_s: float
) -> str | None:
    difference = np.angle(np.exp(1j * (track.mark_angle_rad - track.phase_rad)))[angle.index]
    seen = np.isfinite(difference)
    if seen.sum() < 12:
        return None
    middle = float(np.angle(np.mean(np.exp(1j * difference[seen]))))
    difference = np.angle(np.exp(1j * (difference - middle)))
    off = float((np.abs(difference[seen]) > 0.5).mean())
    if off > SLIPPED:
        return (
            f"{track.source}: in {off:.0%} of the pictures the mark's centroid is elsewhere than "
            f"the angle from the whole plate says; the mark may be hidden at times, or is not "
            f"one. The rate is from the whole plate."
        )
    time, line = angle.repaired_time_s[seen], angle.angle_rad[seen]
    x = _waves(time - time.mean(), line)
    slope = least_squares(x, difference[seen])
    apart = abs(float(slope.beta[1]))
    if apart < APART * np.hypot(slope.sd[1], sd_rad_s) or apart < CENTROID_MATTERS * abs(
        rate_rad_s
    ):
        return None
    return (
        f"{track.source}: the mark's centroid turns {apart / abs(rate_rad_s) * 1e6:.0f} ppm "
        f"otherwise than the whole plate; the light may change during the clip."
    )


def _waves(time_s: FloatArray, angle_rad: FloatArray) -> FloatArray:
    parts = [np.ones_like(time_s), time_s]
    parts += [f(k * angle_rad) for k in (1, 2) for f in (np.cos, np.sin)]
    return np.stack(parts, axis=1)
