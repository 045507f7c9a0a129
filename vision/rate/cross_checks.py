"""Three more ways to the rate, none as exact, that would show if the first went wrong.

The centroid of the mark, the count of frames between alignments, and the return of the frames after
whole turns. They are compared with the rate, not averaged with it. The last two use the time
stamps as they are, without the time of dropped frames, and are compared with the rate on these.
"""

from dataclasses import dataclass

import numpy as np

from vision.geometry import FloatArray
from vision.image_return import other_return
from vision.numbers import RPM
from vision.phase_track import PhaseTrack, PlateAngle
from vision.rate.least_squares import least_squares
from vision.rate.other_rates import END_SD, EVEN, FrameCount, LagRate, count_frames, lag_rate
from vision.rate.unwrap import frame_time

FEWEST_CENTROIDS = 12  #: frames; two per parameter of the ellipse and spindle
SLIPPED_RAD = 0.5  # between the mark's centroid and the refined angle: not the same mark


@dataclass(frozen=True)
class CrossCheckThresholds:
    """When another way to the rate disagrees with it.

    Attributes
    ----------
    apart : float
        Sds. Derived: five, beyond every chance.
    centroid_matters, lag_matters : float
        Relative difference that matters. Facts: half a poor clock (100 ppm); the lag's own bias
        where the frames change during the clip (``tests.bench.vision_films``).
    count_apart : float
        Frames. Derived: rounding both ends gives up to one, and a margin of a twentieth.
    slipped : float
        Share of frames with the centroid elsewhere than the refined angle.
    """

    apart: float = 5.0
    centroid_matters: float = 50e-6
    lag_matters: float = 2e-3
    count_apart: float = 1.05
    slipped: float = 0.02


THRESHOLDS = CrossCheckThresholds()


@dataclass(frozen=True, eq=False)
class CrossChecks:
    """The rate by other ways, on the time stamps as they are.

    Attributes
    ----------
    frame_count : FrameCount or None
        None with fewer than two alignments of the marks.
    lag : LagRate or None
        None where the frames have no clear return or the stamps are not evenly spaced.
    contradiction_rad_s : float
        How far the return of the frames is from the rate, where that is beyond every chance: which
        of them is right the clip does not show. Else 0.
    warnings : tuple of str
        A paragraph for each way that disagrees.
    """

    frame_count: FrameCount | None
    lag: LagRate | None
    contradiction_rad_s: float
    warnings: tuple[str, ...]


def cross_check(
    track: PhaseTrack, time_s: FloatArray, angle: PlateAngle, rate_rad_s: float, sd_rad_s: float
) -> CrossChecks:
    """Measure the rate by other ways and compare.

    Parameters
    ----------
    track : PhaseTrack
    time_s : array, shape (f,)
        Stamps of all frames of the track, s.
    angle : PlateAngle
        With the dropped frames counted.
    rate_rad_s, sd_rad_s : float
        The measured rate, signed, and its sd without the clock's.
    """
    by_stamps = abs(rate_rad_s) * _stretch(angle, 0, -1)
    count = count_frames(angle, track.plate.mark_azimuth_rad, track.plate.fixed_mark_azimuth_rad)
    lag = lag_rate(track, time_s, by_stamps)
    apart = _lag_apart(lag, by_stamps, sd_rad_s)
    paragraphs = (
        _compare_centroid(track, angle, rate_rad_s, sd_rad_s),
        _compare_count(track.source, count, angle, abs(rate_rad_s)),
        _lag_warning(track.source, lag, by_stamps) if apart else "",
        _another_rate(track, time_s, by_stamps),
    )
    return CrossChecks(count, lag, apart, tuple(text for text in paragraphs if text))


def _stretch(angle: PlateAngle, first: int, last: int) -> float:
    """Time between two rows with that of dropped frames put back, over that of their stamps."""
    repaired = angle.repaired_time_s
    return float((repaired[last] - repaired[first]) / (angle.time_s[last] - angle.time_s[first]))


def _compare_count(
    source: str, count: FrameCount | None, angle: PlateAngle, rate_rad_s: float
) -> str:
    if count is None:
        return ""
    first, last = np.searchsorted(angle.index, count.alignments[[0, -1]])
    rate_rad_s *= _stretch(angle, first, last)
    frames = abs(count.rate_rad_s - rate_rad_s) / count.sd_rad_s * END_SD
    if frames <= THRESHOLDS.count_apart:
        return ""
    return (
        f"{source}: counting frames between alignments gives {count.rate_rad_s / RPM:.4f} ± "
        f"{count.sd_rad_s / RPM:.4f} rpm, the regression {rate_rad_s / RPM:.4f} rpm: they differ "
        f"by more than one frame. Check with --overlay that the mark is the mark."
    )


def _lag_apart(lag: LagRate | None, rate_rad_s: float, sd_rad_s: float) -> float:
    """How far the rate by the return of the frames is away, 0 where that does not matter."""
    if lag is None:
        return 0.0
    apart = abs(lag.rate_rad_s - rate_rad_s)
    limit = THRESHOLDS.apart * float(np.hypot(lag.sd_rad_s, sd_rad_s))
    return apart if apart > max(limit, THRESHOLDS.lag_matters * rate_rad_s) else 0.0


def _lag_warning(source: str, lag: LagRate | None, rate_rad_s: float) -> str:
    if lag is None:
        return ""
    return (
        f"{source}: the image returns after whole turns at {lag.rate_rad_s / RPM:.4f} ± "
        f"{lag.sd_rad_s / RPM:.4f} rpm, the regression gives {rate_rad_s / RPM:.4f} rpm. Something "
        f"else in the frame may be turning, or turns were miscounted; the sd spans both. Put one "
        f"bold mark near the rim and film again."
    )


def _another_rate(track: PhaseTrack, time_s: FloatArray, rate_rad_s: float) -> str:
    """Whether something else in the frame turns at a rate of its own."""
    frame_s = frame_time(time_s)
    if track.plate.symmetry > 1 or np.abs(np.diff(time_s) - frame_s).max() > EVEN * frame_s:
        return ""
    other = other_return(track.thumbnail, frame_s, 2 * np.pi / rate_rad_s)
    if other is None:
        return ""
    return (
        f"{track.source}: two things turn in the frame at two rates, {rate_rad_s / RPM:.4g} rpm "
        f"and {other.rate_rad_s / RPM:.4g} rpm ± {other.sd_s / other.period_s:.1%}. The rate is "
        f"that of the first, which shows more. If the sensor turns with the second, cover the "
        f"first or state the rim of the second (--rim, or plate: centre_px, radii_px)."
    )


def _compare_centroid(
    track: PhaseTrack, angle: PlateAngle, rate_rad_s: float, sd_rad_s: float
) -> str:
    difference = np.angle(np.exp(1j * (track.mark_angle_rad - track.phase_rad)))[angle.index]
    seen = np.isfinite(difference)
    if seen.sum() < FEWEST_CENTROIDS:
        return ""
    middle = float(np.angle(np.mean(np.exp(1j * difference[seen]))))
    difference = np.angle(np.exp(1j * (difference - middle)))
    off = float((np.abs(difference[seen]) > SLIPPED_RAD).mean())
    if off > THRESHOLDS.slipped:
        return (
            f"{track.source}: in {off:.0%} of the frames the mark's centroid is not where the "
            f"angle of the whole plate puts it. The mark may be hidden at times, or is none. The "
            f"rate is that of the whole plate."
        )
    time = angle.repaired_time_s[seen]
    slope = least_squares(_waves(time - time.mean(), angle.angle_rad[seen]), difference[seen])
    apart = abs(float(slope.beta[1]))
    limit = THRESHOLDS.apart * np.hypot(slope.sd[1], sd_rad_s)
    if apart < max(limit, THRESHOLDS.centroid_matters * abs(rate_rad_s)):
        return ""
    return (
        f"{track.source}: the rate of the mark's centroid differs by "
        f"{apart / abs(rate_rad_s) * 1e6:.0f} ppm from that of the whole plate. The light may "
        f"change during the clip."
    )


def _waves(time_s: FloatArray, angle_rad: FloatArray) -> FloatArray:
    parts = [np.ones_like(time_s), time_s]
    parts += [f(k * angle_rad) for k in (1, 2) for f in (np.cos, np.sin)]
    return np.stack(parts, axis=1)
