"""Frames that a recorder dropped without a gap in its time stamps, and steps of its clock.

Each jump of the angle (``angle_levels``) has one of three causes. The recorder dropped k frames:
the angle leaps by k frame times. The clock of the stamps stepped: by any time, at once or seldom.
Or the angle is mismeasured there: that of a plate with little texture at one angle jumps there,
once per turn, and drifts back.

The sizes come from one fit of all jumps beside a rotation that drifts evenly; each is as large as
it is seen, and goes if none is likelier. What separates the clock from the plate: the error of the
angle at each place of the plate repeats with every turn, so that the time of a turn, t_i - t(θ_i -
2π), is free of it, and contains the jumps within the turn, of size J_j, that are errors of the
times:

    t_i - t(θ_i - 2π) = P - T Σ_j A_j J_j [jump j within the turn] + noise,   A_j = 1 or 0.

And frames are dropped at any angle of the plate, errors occur at one: the resultant R of n jumps
occurs by chance with the probability exp(-n R²) (Mardia and Jupp, Directional Statistics, 2000,
section 6.3). Both together are the odds of each jump.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.numbers import SD_PER_MAD, median
from vision.phase_track import BoolArray, PlateAngle
from vision.rate.angle_levels import JUMPS, SPREAD, AngleLevels, angle_levels
from vision.rate.least_squares import OUTLIER, correlation_time
from vision.rate.steady_part import FEWEST_FRAMES, TREND
from vision.rate.unwrap import waves_per_turn

NEITHER, NEITHER_SD = 0.5, 0.5  #: share before the data, and its sd; 1 and 0 are as likely


# Limits and prior probabilities of the causes of a jump.
STEPS = 1e-5
"""Probability that the clock steps before a frame, per frame time of the size. A judgement."""
HIDES = 0.5
"""Scatter that hides a dropped frame, over the angle from frame to frame. Derived: half a step is
rounded to a whole one."""
AMISS = 0.1
"""Sd of a share: with dropped frames one jump in ten may be false, with errors of the angle they do
not repeat exactly. Measured: 0.87 to 1.00, and -0.03 to 0.19 (300 tracks each of
``tests.bench.simulated_tracks``)."""


@dataclass(frozen=True, eq=False)
class DroppedFrames:
    """The angle with the time of dropped frames and of steps of the clock added.

    Attributes
    ----------
    angle : PlateAngle
        Angle with what is more probable than an error of the angle counted.
    stray : array of bool, shape (u,)
        Frames whose angle is likely mismeasured.
    size : array, shape (j,)
        Jumps of the angle, frame times.
    probability : array, shape (j,)
        Probability that each is one of the times, and not a mismeasured angle.
    at_rad : float
        Mean plate angle of the jumps; NaN without one.
    """

    angle: PlateAngle
    stray: BoolArray
    size: FloatArray
    probability: FloatArray
    at_rad: float = np.nan

    @property
    def count(self) -> int:
        """Number of dropped frames."""
        return int(self.angle.dropped[~self.angle.stepped].sum())

    @property
    def sd_of_rate(self) -> float:
        """Relative sd of the rate, from the change by the less probable cause of each jump."""
        doubt = np.sqrt(np.minimum(self.probability, 1 - self.probability))
        span_s = float(np.ptp(self.angle.time_s))
        return float(np.abs(self.size) @ doubt) * self.angle.frame_s / span_s

    def warnings(self, source: str) -> tuple[str, ...]:
        """A warning of the jumps, with their causes."""
        angle, is_time = self.angle, self.probability >= 0.5
        if not len(self.size):
            return ()
        jumps = (f"{source}: the angle jumps by {np.abs(self.size).sum():.3g} frame time(s) in "
                 f"all, at about {np.degrees(self.at_rad) % 360:.0f}° of plate angle")
        if self.sd_of_rate > TREND:
            odds = np.average(self.probability, weights=np.abs(self.size))
            return (f"{jumps}. This clip cannot determine whether frames were dropped or the angle "
                    f"is mismeasured there (the odds of dropped frames are {odds:.0%}); the sd "
                    f"covers both ({self.sd_of_rate:.2%} of the rate). Film over more turns, or "
                    f"put a bold mark near the rim.",)
        if not is_time.any():
            return (f"{jumps}, and returns within a turn. No frame is missing: the angle is "
                    f"mismeasured there. The rate uses the time stamps as they are. Film the whole "
                    f"plate, with a mark near the rim.",)
        causes = []
        if self.count:
            causes.append(
                f"the recorder dropped {self.count} frame(s) without a gap in the time stamps "
                f"({self.count / len(angle.time_s):.1%}): the angle jumps by whole frame times. "
                f"Their time was put back.")
        if angle.stepped.any():
            steps = [f"{1e3 * angle.frame_s * by:+.0f} ms at {at:.1f} s"
                     for by, at in zip(-angle.dropped[angle.stepped], angle.time_s[angle.stepped],
                                       strict=True)]
            causes.append(
                f"the clock of the time stamps steps by {' and '.join(steps)}, or that and whole "
                f"turns of the plate: the angle jumps there by no whole number of frame times. The "
                f"rate is fitted beside it.")
        return (f"{source}: {' '.join(causes)}",)


def dropped_frames(angle: PlateAngle) -> DroppedFrames:
    """Find the jumps of the angle, and the cause of each.

    Parameters
    ----------
    angle : PlateAngle
        Angle on the stamps unchanged, without dropped frames.
    """
    levels = angle_levels(angle)
    even = _sizes(angle, levels)
    if even is None or not len(even[0]):
        stray = levels.stray & (even is not None)
        return DroppedFrames(angle, stray, np.zeros(0), np.zeros(0))
    at, size, is_step = even
    resultant = complex(np.exp(1j * angle.angle_rad[at]).mean())
    before = 1 - len(at) * abs(resultant) ** 2  # 0 on average of uniform angles
    share, cov = confirmed_shares(angle.without(levels.stray), angle.index[at], size)
    odds = before + (share - NEITHER) / np.maximum(np.diag(cov), np.finfo(float).eps)  # 1 against 0
    probability = 1 / (1 + np.exp(-np.clip(odds, -30, 30)))
    is_time = probability >= 0.5
    dropped, stepped = np.zeros(len(angle.time_s)), np.zeros(len(angle.time_s), bool)
    dropped[at[is_time]] = size[is_time]
    stepped[at[is_time & is_step]] = True
    return DroppedFrames(replace(angle, dropped=dropped, stepped=stepped), levels.stray, size,
                         probability, float(np.angle(resultant)))


def _sizes(
    angle: PlateAngle, levels: AngleLevels
) -> tuple[NDArray[np.intp], FloatArray, BoolArray] | None:
    """Evident jumps: first frame after each, size in frame times, no whole number, (j,) all.

    None for a plate that does not turn evenly.
    """
    time, at = angle.time_s - angle.time_s.mean(), levels.jumps
    shown = ~levels.stray & ~_beside(np.arange(len(time)), at, np.full(len(at), SPREAD))
    if 2 * shown.sum() < len(shown):  # what is usual is no level
        return None
    # Of jumps without a frame between them, the last one is all of them.
    past = np.cumsum(shown)[at - 1]
    at = at[(past > 0) & (np.diff(np.append(past, shown.sum())) > 0)]
    per_frame = float(median(np.diff(angle.angle_rad) / np.diff(angle.index)))
    base = np.column_stack([np.ones_like(time), time, time**2,
                            waves_per_turn(angle.angle_rad)])[shown]
    passed = (np.flatnonzero(shown)[:, None] >= at).astype(float)
    y = angle.angle_rad[shown]
    while True:
        x = np.column_stack([passed, base])
        beta = np.linalg.lstsq(x, y)[0]
        rest = y - x @ beta
        variance = rest @ rest / max(len(y) - len(beta), 1)
        if variance >= (HIDES * per_frame) ** 2:
            return None
        variance *= correlation_time(rest)
        variance *= np.diag(np.linalg.pinv(x.T @ x))
        size = beta[: len(at)] / per_frame
        sd = np.sqrt(np.maximum(variance[: len(at)], np.finfo(float).tiny)) / abs(per_frame)
        whole = np.maximum(np.round(size), 1.0)
        # Of dropped frames, k at once have the probability 1/(k (k + 1)).
        drop = np.log(JUMPS / (whole * (whole + 1))) - 0.5 * ((size - whole) / sd) ** 2
        step = np.log(STEPS * np.sqrt(2 * np.pi) * sd)
        evident = np.maximum(drop, step) + 0.5 * (size / sd) ** 2
        if (evident > 0).all():
            return at, np.where(step > drop, size, whole), step > drop
        at, passed = (np.delete(each, evident.argmin(), axis=-1) for each in (at, passed))


def _beside(index: NDArray[np.intp], at: NDArray[np.intp], many: FloatArray) -> BoolArray:
    """Whether frames, (u,), are among so many, (j,), on either side of a jump, (j,)."""
    after = index[:, None] - at
    return np.asarray(((after >= -many) & (after < many)).any(axis=1))


def confirmed_shares(
    angle: PlateAngle, at: NDArray[np.intp], size: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """A of each jump: what the time of a turn confirms of it.

    Parameters
    ----------
    angle : PlateAngle
    at : array, shape (j,)
        Number in the clip of the first frame after each jump.
    size : array, shape (j,)
        Frame times.

    Returns
    -------
    mean : array, shape (j,)
        No unit.
    cov : array, shape (j, j)
        No unit; with the prior, 1/2 ± 1/2.
    """
    before = np.full(len(at), NEITHER), NEITHER_SD**2 * np.eye(len(at))
    # An angle that jumps back is passed twice.
    angle = angle.without(_beside(angle.index, at, SPREAD + np.ceil(np.maximum(-size, 0.0))))
    if len(angle.time_s) < FEWEST_FRAMES:
        return before
    turned = np.maximum.accumulate(np.abs(angle.angle_rad - angle.angle_rad[0]))
    later = turned >= 2 * np.pi
    was = turned[later] - 2 * np.pi
    passed = (angle.index[:, None] >= at).astype(float)
    once = np.column_stack([np.interp(was, turned, each) for each in passed.T])
    clear = (once == np.round(once)).all(axis=1)  # one turn earlier lies within no jump
    if np.count_nonzero(clear) < FEWEST_FRAMES:
        return before
    time = angle.time_s[later]
    took = ((time - np.interp(was, turned, angle.time_s)) / angle.frame_s)[clear]
    x = ((once - passed[later]) * size)[clear]
    even, _ = np.linalg.qr(np.column_stack([np.ones_like(took), time[clear]]))
    x, took = (each - even @ (even.T @ each) for each in (x, took))
    rest = took - x @ np.linalg.lstsq(x, took)[0]
    noise = max(SD_PER_MAD * float(median(np.abs(rest))), 1e-3)
    used = np.abs(rest) <= OUTLIER * noise
    noise *= np.sqrt(correlation_time(rest[used]))
    x, rest = x[used] / noise, (took - x @ before[0])[used] / noise
    scatter = AMISS**2 * x.T @ x + np.eye(len(at))
    cov = np.linalg.inv(np.linalg.solve(scatter, x.T @ x) + np.linalg.inv(before[1]))
    return before[0] + cov @ np.linalg.solve(scatter, x.T @ rest), cov
