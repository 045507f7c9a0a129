"""What a phase track may hold besides a constant rate: each term is a set of columns.

    θ_i = θ_0 + Ω t_i + Σ_k X_k(i) β_k + noise

``columns`` gives X for a term by name. The angle in the columns is that of the line, not the
measured one, so that the noise of an angle does not enter its own regressor.

``forward_prediction`` is no matter of the plate and not offered to the user: an encoder that
predicts picture after picture from the one before carries faint texture along by coarse motion, and
it lags, by up to some mrad at strong compression. Beside pictures predicted from both sides it does
not, and encoders change between the two within a film.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vision.geometry import FloatArray
from vision.phase_track import BoolArray, PhaseTrack, PlateAngle

CONSTANT_RATE = "constant_rate"
TERMS = ("once_per_rev", "twice_per_rev", "rate_drift", "frame_steps", "rolling_shutter")
FORWARD_PREDICTION = "forward_prediction"
UNITS = {
    "once_per_rev": "rad",
    "twice_per_rev": "rad",
    "rate_drift": "rad/s²",
    "frame_steps": "frames",
    "rolling_shutter": "s per row",
}
MEANING = {
    "once_per_rev": "a wave once per turn: an eccentric mark or drive, an unbalanced plate, a "
    "view that is slightly off",
    "twice_per_rev": "a wave twice per turn: a camera tilt left over, an oval drive",
    "rate_drift": "a rate that changes evenly in time",
    "frame_steps": "jumps by whole frame times: pictures lost by the recorder",
    "rolling_shutter": "rows read out one after the other: the mark is seen earlier at the top "
    "of the picture than at the bottom",
}


@dataclass(frozen=True, eq=False)
class Regressors:
    """What the columns of all terms are made of, on the usable pictures.

    Attributes
    ----------
    time_s : array, shape (u,)
        Time with that of lost pictures put back, from the middle of the clip.
    stamp_s : array, shape (u,)
        Time as stamped, from the middle of the clip.
    line_rad : array, shape (u,)
        Angle of the fitted line.
    steps_rad : array, shape (u,)
        Angle turned in the time of the pictures lost so far.
    forward : array, shape (u,)
        1 where the picture is one of a run predicted from the pictures before, else 0.
    mark_row_px : array, shape (u,)
        How far below the spindle the mark stands, pixels of the film.
    rate_rad_s : float
    """

    time_s: FloatArray
    stamp_s: FloatArray
    line_rad: FloatArray
    steps_rad: FloatArray
    forward: FloatArray
    mark_row_px: FloatArray
    rate_rad_s: float

    def rows(self, used: BoolArray) -> "Regressors":
        """Some of the rows."""
        return Regressors(
            self.time_s[used],
            self.stamp_s[used],
            self.line_rad[used],
            self.steps_rad[used],
            self.forward[used],
            self.mark_row_px[used],
            self.rate_rad_s,
        )


def regressors(track: PhaseTrack, angle: PlateAngle, rate_rad_s: float) -> Regressors:
    """Evaluate them for a rate."""
    time = angle.repaired_time_s - angle.repaired_time_s.mean()
    line = rate_rad_s * time + angle.angle_rad.mean()
    return Regressors(
        time_s=time,
        stamp_s=angle.time_s - angle.time_s.mean(),
        line_rad=line,
        steps_rad=np.asarray(rate_rad_s * angle.frame_s * np.cumsum(angle.dropped), float),
        forward=track.forward[angle.index].astype(float),
        mark_row_px=track.plate.mark_row_px(line) * track.plate.reduction,
        rate_rad_s=rate_rad_s,
    )


def columns(term: str, given: Regressors) -> FloatArray:
    """X of a term, shape (u, k)."""
    if term == "once_per_rev":
        return np.stack([np.cos(given.line_rad), np.sin(given.line_rad)], axis=1)
    if term == "twice_per_rev":
        return np.stack([np.cos(2 * given.line_rad), np.sin(2 * given.line_rad)], axis=1)
    if term == "rate_drift":
        square = 0.5 * given.time_s**2
        return np.asarray((square - square.mean())[:, None])
    if term == "frame_steps":
        # Against the times as stamped; one per unit is one for every picture counted as lost.
        return given.steps_rad[:, None]
    if term == FORWARD_PREDICTION:
        return given.forward[:, None]
    if term == "rolling_shutter":
        # A row lower is read later, when the plate has turned on.
        return np.asarray(given.rate_rad_s * given.mark_row_px[:, None])
    raise KeyError(term)


def design(terms: Sequence[str], given: Regressors, time_s: FloatArray) -> FloatArray:
    """Columns of constant, rate (on either time) and the terms, shape (u, 2 + Σk)."""
    parts = [np.ones((len(time_s), 1)), time_s[:, None]]
    parts += [columns(term, given) for term in terms]
    return np.concatenate(parts, axis=1)
