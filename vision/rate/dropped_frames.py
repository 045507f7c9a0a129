"""Frames that a recorder dropped without a gap in its time stamps.

A dropped frame makes the angle jump by rate × frame time, n frames by n times that. Jumps are
candidates only: a plate that shows little at one angle jumps there as well, once per turn, and
creeps back. Time is put back where the angles confirm it. With t_i the stamp of a frame, m_i its
turn, s_i its sector of the turn, f_i its angle within the sector, T the frame time and K_i the
candidates so far,

    t_i = P m_i + h(s_i) + c(s_i) f_i - A T K_i + noise.

h and c take whatever the angle errs by at each place of the plate, turn after turn, so A is 1 for
dropped frames and 0 for errors of the angle. A is not determined where each turn has its jump at
the same place. Frames are dropped at any angle, so such jumps are errors of the angle; Rayleigh's
test (Mardia and Jupp, Directional Statistics, 2000, section 6.3) compares their angles with
uniform ones.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vision.errors import RateRefused
from vision.geometry import FloatArray
from vision.phase_track import PhaseTrack, PlateAngle, RateHistory
from vision.rate.jumps import frame_jumps
from vision.rate.least_squares import least_squares
from vision.rate.stability import THRESHOLDS as STABILITY

SECTORS = 24  # of a turn, each with its own error of the angle
FEWEST_FREE = 6  # frames more than parameters, for a share to be determined
FEWEST_REGULAR = 3  # two jumps and two ends are never far from a straight line


@dataclass(frozen=True)
class DroppedFrameThresholds:
    """When a jump of the angle is a dropped frame.

    Attributes
    ----------
    confirmed : float
        Share of the candidates, from 1 where frames were dropped and from 0 where none were.
        Derived: half of the half that lies between.
    determined : float
        Sds between a share of 0 and one of 1. Derived: 5 sds from their middle to either.
    clustered : float
        Probability of angles as close as those of the jumps, were they uniform, below which the
        jumps are errors of the angle. Derived: one clip in a thousand.
    """

    confirmed: float = 0.25
    determined: float = 10.0
    clustered: float = 1e-3


THRESHOLDS = DroppedFrameThresholds()

Judgement = Literal["none", "dropped", "mismeasured", "undecided"]


@dataclass(frozen=True, eq=False)
class DroppedFrames:
    """Whether frames were dropped, and the angle with their time put back where they were.

    Attributes
    ----------
    judgement : str
        "none": no frame is missing. "dropped": frames were dropped. "mismeasured": the angle
        errs and no frame is missing. "undecided": neither can be excluded.
    angle : PlateAngle
        Counts the dropped frames where the judgement is "dropped", else none.
    candidates : int
        Frame times by which the angle jumps in all.
    share, share_sd : float
        A of the module's equation; NaN without candidates, sd infinite where not determined.
    at_rad : float
        Mean plate angle of the jumps.
    """

    judgement: Judgement
    angle: PlateAngle
    candidates: int = 0
    share: float = np.nan
    share_sd: float = np.nan
    at_rad: float = np.nan

    @property
    def count(self) -> int:
        """Frames dropped."""
        return int(self.angle.dropped.sum())

    @property
    def sd_of_rate(self) -> float:
        """Relative sd of the rate: where undecided, what all candidates together would change."""
        if self.judgement != "undecided":
            return 0.0
        span_s = float(self.angle.time_s[-1] - self.angle.time_s[0])
        return self.candidates * self.angle.frame_s / span_s


def dropped_frames(track: PhaseTrack, angle: PlateAngle) -> DroppedFrames:
    """Find the frames that were dropped silently.

    Parameters
    ----------
    track : PhaseTrack
        Holds the frames that repeat the one before.
    angle : PlateAngle
        On the stamps as they are, without dropped frames.
    """
    count = np.concatenate([[0], frame_jumps(angle)])
    candidates = int(count.sum())
    if not candidates:
        return DroppedFrames("none", angle)
    at_rad = angle.angle_rad[count > 0]
    resultant = complex(np.exp(1j * at_rad).mean())
    uniform = float(np.exp(-len(at_rad) * abs(resultant) ** 2))  # n R² is exponential
    repaired = replace(angle, dropped=count)
    share, sd = confirmed_share(repaired)
    judgement = _judge(share, sd, uniform)
    if judgement == "dropped" and _repeats_keep_time(track, angle, candidates):
        return DroppedFrames("none", angle)
    return DroppedFrames(
        judgement, repaired if judgement == "dropped" else angle, candidates, share, sd,
        float(np.angle(resultant)),
    )


def _judge(share: float, sd: float, uniform: float) -> Judgement:
    determined = THRESHOLDS.determined * sd < 1
    if determined and abs(share - 1) < THRESHOLDS.confirmed:
        return "dropped"
    if determined and share < THRESHOLDS.confirmed:
        return "mismeasured"
    return "mismeasured" if uniform < THRESHOLDS.clustered else "undecided"


def confirmed_share(angle: PlateAngle) -> tuple[float, float]:
    """Share A of the candidates that the angles confirm, and its sd.

    Parameters
    ----------
    angle : PlateAngle
        With the candidates counted.

    Returns
    -------
    share, sd : float
        NaN and infinity where the share is not determined.
    """
    turned = np.abs(angle.angle_rad - angle.angle_rad[0]) / (2 * np.pi)
    place = np.floor(SECTORS * turned).astype(np.intp)
    within = SECTORS * turned - place - 0.5
    put_back = -angle.frame_s * np.cumsum(angle.dropped)
    rows = np.stack([angle.time_s, np.floor(turned), put_back], axis=1)
    place %= SECTORS
    free = len(rows) - 2 * int(np.count_nonzero(np.bincount(place))) - 2
    if free < FEWEST_FREE:
        return np.nan, np.inf
    rows = _without_place(rows, place, within)
    try:
        fit = least_squares(rows[:, 1:], rows[:, 0], turn_rad=angle.angle_rad)
    except np.linalg.LinAlgError:
        return np.nan, np.inf
    return float(fit.beta[1]), float(fit.sd[1] * np.sqrt(len(rows) / free))


def _without_place(rows: FloatArray, place: NDArray[np.intp], within: FloatArray) -> FloatArray:
    """Columns less their mean and their slope against ``within`` in each place, shape (u, k)."""
    count = np.maximum(np.bincount(place, minlength=SECTORS), 1)

    def centred(values: FloatArray) -> FloatArray:
        return np.asarray(values - (np.bincount(place, values, SECTORS) / count)[place])

    aside = centred(within)
    square = np.maximum(np.bincount(place, aside**2, SECTORS), 1e-12)
    columns = [centred(column) for column in rows.T]
    slopes = [np.bincount(place, aside * column, SECTORS) / square for column in columns]
    pairs = zip(columns, slopes, strict=True)
    return np.stack([column - slope[place] * aside for column, slope in pairs], axis=1)


def _repeats_keep_time(track: PhaseTrack, angle: PlateAngle, candidates: int) -> bool:
    """Whether the recorder fills its time with repeated frames, so that no time is missing.

    A camera slower than its clip: the stamps are then never further from an even rotation than one
    frame time. Frames dropped at random lead further away.
    """
    if not FEWEST_REGULAR <= candidates <= track.duplicate.sum():
        return False
    line = np.polynomial.Polynomial.fit(angle.angle_rad, angle.time_s, 1)
    low, high = np.quantile(angle.time_s - line(angle.angle_rad), (0.01, 0.99))
    return bool(high - low < angle.frame_s)


def refuse_undecided(source: str, dropped: DroppedFrames, history: RateHistory) -> None:
    """Raise where neither can be excluded, and the rates differ by more than a steady one may.

    Parameters
    ----------
    source : str
        Name of the clip.
    dropped : DroppedFrames
    history : RateHistory
        Of the angle as stamped; goes with the refusal.

    Raises
    ------
    RateRefused
    """
    if dropped.sd_of_rate < STABILITY.unsteady:
        return
    raise RateRefused(
        f"{source}: the angle jumps by {dropped.candidates} frame time(s) in all, at about "
        f"{_place(dropped)}. This clip cannot determine whether frames were dropped or the angle "
        f"is mismeasured there, and the rates differ by {dropped.sd_of_rate:.1%}. Put a bold "
        f"mark near the rim; where there is one, film over more turns.",
        history,
    )


def dropped_frame_warnings(source: str, dropped: DroppedFrames) -> tuple[str, ...]:
    """What the jumps of the angle are, and what was done about them."""
    angle, n = dropped.angle, dropped.candidates
    if dropped.judgement == "none":
        return ()
    if dropped.judgement == "dropped":
        return (
            f"{source}: the recorder dropped {n} frame(s) without a gap in the time stamps "
            f"({n / len(angle.time_s):.1%}): the angle jumps by whole frame times. Their time was "
            f"put back; of all that time the angles before and after confirm "
            f"{dropped.share:.3f} ± {dropped.share_sd:.3f}.",
        )
    if dropped.judgement == "mismeasured":
        return (
            f"{source}: the angle jumps by {n} frame time(s) in all, at about {_place(dropped)}, "
            f"and returns within a turn. No frame is missing: the angle is mismeasured there. The "
            f"rate uses the time stamps as they are. Film the whole plate, with a mark near the "
            f"rim.",
        )
    return (
        f"{source}: the angle jumps by {n} frame time(s) in all, at about {_place(dropped)}. "
        f"This clip cannot determine whether frames were dropped or the angle is mismeasured "
        f"there; the sd covers both ({dropped.sd_of_rate:.2%} of the rate). Film over more turns, "
        f"or put a bold mark near the rim.",
    )


def _place(dropped: DroppedFrames) -> str:
    return f"{np.degrees(dropped.at_rad) % 360:.0f}° of plate angle"
