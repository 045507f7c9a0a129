"""Terms of a phase track besides a constant rate: each term is a set of columns.

    θ_i = θ_0 + Ω t_i + Σ_k X_k(i) β_k + noise

``columns`` gives X for a term by name. The angle in the columns is that of the line, not the
measured one, so that the noise of an angle does not enter its own regressor.

``forward_prediction`` has nothing to do with the plate and is not offered to the user: an encoder
that predicts each frame from the previous one moves faint texture by coarse motion, and the angle
lags by up to some mrad at strong compression. Beside frames predicted from both sides there is no
lag, and encoders change between the two within a clip.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from vision.errors import RateRefused
from vision.geometry import FloatArray
from vision.phase_track import BoolArray, PhaseTrack, PlateAngle
from vision.rate.least_squares import LeastSquares, least_squares
from vision.rate.unwrap import waves_per_turn

ROUNDS, STAYS = 8, 1e-3  #: rounds at most; sds of the rate within which it stays; numerical
CONSTANT_RATE = "constant_rate"
TERMS = ("once_per_rev", "twice_per_rev", "rate_drift", "frame_steps", "rolling_shutter")
FORWARD_PREDICTION = "forward_prediction"
ALWAYS = ("once_per_rev", "twice_per_rev", "rate_drift", FORWARD_PREDICTION)
DRIFT, LAG = 6, 7  #: columns of two of these beside the constant and the rate; definition
#: Sds before the data, of the waves, rad: 4° of a centre or a view that is off, 1.8° of a camera
#: tilted by 20°; of an even relative change over a clip (judgement: a third of the largest one of a
#: constant rate); and of the lag of predicted frames, rad: some mrad at strong compression.
USUAL_WAVES, USUAL_CHANGE, USUAL_LAG = (0.07, 0.03), 0.003, 0.005
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
    "frame_steps": "jumps by whole frame times: frames dropped by the recorder",
    "rolling_shutter": "rows read out one after the other: the mark is seen earlier at the top "
    "of the frame than at the bottom",
}


@dataclass(frozen=True, eq=False)
class Regressors:
    """Inputs of the columns of all terms, on the usable frames.

    Attributes
    ----------
    time_s : array, shape (u,)
        Time with the time of dropped frames added, from the middle of the clip.
    stamp_s : array, shape (u,)
        Time as stamped, from the middle of the clip.
    line_rad : array, shape (u,)
        Angle of the fitted line.
    steps_rad : array, shape (u,)
        Angle turned in the time of the frames dropped so far.
    forward : array, shape (u,)
        1 if the frame belongs to a run predicted from earlier frames, else 0.
    mark_row_px : array, shape (u,)
        Distance of the mark below the spindle, pixels of the clip.
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
        *arrays, _ = fields(self)
        return replace(self, **{array.name: getattr(self, array.name)[used] for array in arrays})


def regressors(track: PhaseTrack, angle: PlateAngle, rate_rad_s: float) -> Regressors:
    """Inputs of the columns, at a signed rate."""
    time = angle.repaired_time_s - angle.repaired_time_s[[0, -1]].mean()
    line = rate_rad_s * time + (angle.angle_rad - rate_rad_s * time).mean()
    return Regressors(
        time_s=time,
        stamp_s=angle.time_s - angle.time_s.mean(),
        line_rad=line,
        steps_rad=np.asarray(rate_rad_s * angle.frame_s * np.cumsum(angle.dropped), float),
        forward=track.forward[angle.index].astype(float),
        mark_row_px=track.plate.mark_row_px(line) * track.plate.reduction,
        rate_rad_s=rate_rad_s,
    )


def columns(term: str, base: Regressors) -> FloatArray:
    """X of a term, shape (u, k), rad per unit of each parameter."""
    if term in ("once_per_rev", "twice_per_rev"):
        return waves_per_turn(base.line_rad, (1 if term == "once_per_rev" else 2,))
    if term == "rate_drift":
        square = 0.5 * base.time_s**2
        return np.asarray((square - square.mean())[:, None])
    if term == "frame_steps":
        # Against the stamped times; a size of one is one frame for each one counted as dropped.
        return base.steps_rad[:, None]
    if term == FORWARD_PREDICTION:
        return base.forward[:, None]
    if term == "rolling_shutter":
        # A lower row is read later, when the plate has turned further.
        return np.asarray(base.rate_rad_s * base.mark_row_px[:, None])
    raise KeyError(term)


def design(terms: Sequence[str], base: Regressors, time_s: FloatArray) -> FloatArray:
    """Columns of constant, rate (on either time) and the terms, rad per unit, (u, 2 + Σk)."""
    parts = [np.ones((len(time_s), 1)), time_s[:, None]]
    parts += [columns(term, base) for term in terms]
    return np.concatenate(parts, axis=1)


def fit_rate(
    track: PhaseTrack, angle: PlateAngle, stray: BoolArray, rate_rad_s: float
) -> tuple[LeastSquares, FloatArray, Regressors]:
    """Fit the rate jointly with the terms that are always fitted, until the line converges.

    The line places the waves, and if they are large, misplaced ones bias it.

    Parameters
    ----------
    track : PhaseTrack
    angle : PlateAngle
    stray : array of bool, shape (u,)
        Frames that are likely mismeasured.
    rate_rad_s : float
        Near the rate, signed.

    Returns
    -------
    fit : LeastSquares, x : array, shape (u, k), base : Regressors
        β of constant, rate, the terms of ``ALWAYS`` and the steps of the clock; their columns and
        regressors at the line.
    """
    # The sizes of the steps of a clock are known no better than by the fit.
    past = np.cumsum(angle.stepped)
    steps = (past[:, None] >= np.arange(1, past[-1] + 1)).astype(float)
    for _ in range(ROUNDS):
        base = regressors(track, angle, rate_rad_s)
        x = np.column_stack([design(ALWAYS, base, base.time_s), steps])
        fit = least_squares(x, angle.angle_rad, usual_sizes(base, x.shape[1]), stray)
        before, rate_rad_s = rate_rad_s, float(fit.beta[1])
        if abs(rate_rad_s - before) < STAYS * float(fit.sd[1]):
            break
    return fit, x, base


def usual_sizes(base: Regressors, count: int) -> FloatArray:
    """Sd of each of the ``count`` parameters of a rate before the data, (count,), in its unit.

    A step of the clock by more than half a turn looks like a smaller one.
    """
    drift = USUAL_CHANGE * abs(base.rate_rad_s) / float(np.ptp(base.time_s))
    sizes = (np.inf, np.inf, *[USUAL_WAVES[0]] * 2, *[USUAL_WAVES[1]] * 2, drift, USUAL_LAG)
    return np.array(sizes + (np.pi,) * (count - len(sizes)))


@dataclass(frozen=True, eq=False)
class TermValue:
    """A fitted term of the stated model.

    Attributes
    ----------
    name : str
    value, sd : array, shape (k,)
    unit : str
    """

    name: str
    value: FloatArray
    sd: FloatArray
    unit: str


@dataclass(frozen=True, eq=False)
class StatedFit:
    """The stated model against the angles.

    Attributes
    ----------
    model : tuple of str
        constant_rate first.
    terms : tuple of TermValue
    time_s, angle_rad, residual_rad : array, shape (u,)
        Time from the first frame with the time of dropped frames added, plate angle wrapped to
        (-π, π], and the residual.
    used : array of bool, shape (u,)
        Not an outlier of the fit of the rate.
    columns : mapping of name to array, shape (u, k)
        Columns of the constant rate (1 and the time) and of every possible term of the clip,
        stated or not.
    """

    model: tuple[str, ...]
    terms: tuple[TermValue, ...]
    time_s: FloatArray
    angle_rad: FloatArray
    residual_rad: FloatArray
    used: BoolArray
    columns: Mapping[str, FloatArray]

    @property
    def rms_rad(self) -> float:
        """Root mean square of the residual of the used frames."""
        return float(np.sqrt((self.residual_rad[self.used] ** 2).mean()))


def fit_stated(
    source: str, stated: tuple[str, ...], angle: PlateAngle, base: Regressors, used: BoolArray
) -> StatedFit:
    """Fit the stated model.

    Parameters
    ----------
    source : str
        Name of the clip.
    stated : tuple of str
        Terms besides the constant rate.
    angle : PlateAngle
    base : Regressors
        Regressors on the rows of ``angle``.
    used : array of bool, shape (u,)
        Fitted rows; the residual covers all rows.

    Raises
    ------
    RateRefused
        Terms that one clip cannot separate.
    """
    possible = [t for t in TERMS if t != "frame_steps" or angle.dropped.any()]
    present = [t for t in stated if t in possible]
    x = design(present, base, base.stamp_s)
    try:
        fit = least_squares(x[used], angle.angle_rad[used])
    except np.linalg.LinAlgError as error:
        raise RateRefused(
            f"{source}: one clip cannot separate the terms {', '.join(present)}: their waves are "
            f"the same. Remove one of them from the model."
        ) from error
    return StatedFit(
        model=(CONSTANT_RATE, *stated),
        terms=_values(present, fit, base),
        time_s=angle.repaired_time_s,
        angle_rad=np.angle(np.exp(1j * angle.angle_rad)),
        residual_rad=angle.angle_rad - x @ fit.beta,
        used=used,
        columns={
            CONSTANT_RATE: design((), base, base.stamp_s),
            **{term: columns(term, base) for term in possible},
        },
    )


def _values(terms: Sequence[str], fit: LeastSquares, base: Regressors) -> tuple[TermValue, ...]:
    values, at = [], 2
    for term in terms:
        part = slice(at, at + columns(term, base).shape[1])
        values.append(TermValue(term, fit.beta[part], fit.sd[part], UNITS[term]))
        at = part.stop
    return tuple(values)
