"""What the checks of a clip's rate judge: its track, its history, and the sizes that matter."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vision.geometry import FloatArray
from vision.numbers import median
from vision.phase_track import PhaseTrack, RateHistory
from vision.rate.cross_checks import CrossChecks
from vision.rate.dropped_frames import DroppedFrames
from vision.rate.steady_part import THRESHOLDS as STEADY
from vision.rate.steady_part import noise_of_turns

FEWEST_STRETCHES = 3  #: least number of averages in a clip; derived: two have no middle one
#: Frames over which a rate is the usual one; tuned: with one, frames shown twice are refused
#: (tests.vision.tracking.test_rests_and_gaps), with six a mark that sticks for three is not.
SHOWN = 3


@dataclass(frozen=True)
class CheckThresholds:
    """Sizes from which something matters.

    Attributes
    ----------
    turns : float
        Least number of turns. Fact: fewer show no point of the plate twice.
    stopped : float
        Of the fastest rate: a clip that ends slower shows a stop, one that begins slower a run-up.
        Share of the path: a plate that turns back by as much goes to and fro. It chooses the words,
        not the refusal.
    leaps : float
        Share of the rate in all that is not the usual one within a turn. Between two equal marks
        that are taken for one (0.5, derived) and noise (0.2, seen in films).
    wandering : float
        Scatter that is not noise, over the noise of single frames.
    mostly : float
        Share of the variation in a plate that rotation explains; it chooses the words, not the
        refusal. Fact: 26 of 27 plates of an independent renderer have 0.55 or more, a dark one
        0.32.
    scattered_rad : float
        Scatter about an even rotation that justifies a warning, rad. Ten times that of a poor clip
        (``tests.bench.vision_films``).
    """

    turns: float = 1.0
    stopped: float = 0.5
    leaps: float = 0.35
    wandering: float = 5.0
    mostly: float = 0.5
    scattered_rad: float = 0.0122


THRESHOLDS = CheckThresholds()


@dataclass(frozen=True, eq=False)
class Seen:
    """Quantities of a clip that the checks use.

    Attributes
    ----------
    track : PhaseTrack
    history : RateHistory
    dropped : DroppedFrames
    scatter_rad : float
        Noise of the rate's fit, rad; NaN before the fit.
    rate_rad_s : float
        Rate of the fit, signed; NaN before it.
    others : CrossChecks or None
        The rate by other methods; None before the fit.
    """

    track: PhaseTrack
    history: RateHistory
    dropped: DroppedFrames
    scatter_rad: float = np.nan
    rate_rad_s: float = np.nan
    others: CrossChecks | None = None

    @cached_property
    def even_history(self) -> tuple[FloatArray, float]:
        """Rates from turn to turn, (m,) in rad/s, and the relative range of noise alone.

        Positive in the direction of most of them; averaged over enough turns to detect an unsteady
        plate above the noise of single frames.
        """
        rate = self.history.rate_rad_s
        if len(rate) >= 5:  # without strays
            rate = median(np.lib.stride_tricks.sliding_window_view(rate, 3), axis=1)
        # The mean over n windows of a turn, half a turn apart, retains the noise of two frames at
        # either end, over n half turns.
        spread = noise_of_turns(self.history)
        wanted = int(np.ceil(spread / STEADY.other))
        span = min(wanted, len(rate) // FEWEST_STRETCHES) or 1
        rate = np.lib.stride_tricks.sliding_window_view(rate, span).mean(axis=1)
        return rate * (np.sign(median(rate)) or 1.0), spread / span

    @cached_property
    def change(self) -> float:
        """Relative change of the rate from turn to turn."""
        return float(np.ptp(self.even_history[0]) / max(abs(median(self.even_history[0])), 1e-9))

    @cached_property
    def unsteady(self) -> float:
        """The change over the largest one of a constant rate, or of the noise of frames."""
        return self.change / max(STEADY.other, self.even_history[1])

    @cached_property
    def step_rad(self) -> float:
        """Usual angle from frame to frame."""
        return float(median(np.abs(np.diff(self.history.angle.angle_rad))))

    @cached_property
    def usual_rad_s(self) -> float:
        """Usual rate over three frames, signed: a recorder may show each twice or three times."""
        angle = self.history.angle
        turned, frames = (x[SHOWN:] - x[:-SHOWN] for x in (angle.angle_rad, angle.index))
        return float(median(turned / frames)) / angle.frame_s

    @property
    def is_plate(self) -> bool:
        """Whether rotation explains most of its variation, or this share is unknown."""
        return not self.track.plate.explained < THRESHOLDS.mostly

    @property
    def subject(self) -> str:
        """The object that resembles a plate most; a hand may turn about an axis as well as one."""
        return "what was taken for the plate" + ("" if self.is_plate else (
            f", of whose change rotation explains {self.track.plate.explained:.0%} alone,"))

    def advice(self, usual: str) -> str:
        """Advice: the usual one, or one for something that hardly turns like a plate."""
        return usual if self.is_plate else (
            "A plate in good light shows 50 to 100 %. Keep everything else that moves out of the "
            "frame, fix the camera, switch on a light, or state the rim (--rim, or plate: "
            "centre_px, radii_px); --overlay shows what was tracked."
        )
