"""The next measurement: the shortest block of poses that settles what is open.

Nothing is looked up; every block is computed at the fitted model.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.next_measurement.chance import Rival
from calib.diagnosis.next_measurement.pose_blocks import hypothetical, menu, minutes_for
from calib.effects.effect import Effect
from calib.fit.least_squares.result import Fit
from calib.fit.linear import orthonormal_columns
from calib.fit.validation.prediction import Prediction
from calib.poses.attitudes import direction_name, list_directions
from calib.poses.imu_log import FloatArray

LABELS_LISTED = 3  #: it chooses words only
DIRECTIONS = "directions"  #: code of the block of the attitudes that a calibration lacks


@dataclass(frozen=True)
class Advice:
    """Advice: ``block`` for programs, ``instruction`` for people.

    ``minutes`` is what it takes, ``timed`` the instruction with it; ``chance`` the share of
    simulated sessions in which what is there then gets a name, None where no name is asked for.
    """

    block: str
    instruction: str
    minutes: float
    chance: float | None = None

    @property
    def timed(self) -> str:
        """The instruction, its duration and how often it settles the question."""
        then = "" if self.chance is None else (
            f", after which {100 * self.chance:.0f} % of simulated sessions name it")
        return f"{self.instruction} ({self.minutes:.0f} min{then})"

    @property
    def is_worth_it(self) -> bool:
        """Whether it can settle anything."""
        return self.chance is None or self.chance >= CONSTANTS.least_offered


def _least_first(columns: FloatArray, basis: FloatArray) -> FloatArray:
    """Squares (k,) of the parts of columns (r, k) outside a ``basis``, by direction, ascending.

    NaN where the columns are not known.
    """
    if not np.isfinite(columns).all():
        return np.full(columns.shape[1], np.nan)
    remainder = columns - basis @ (basis.T @ columns)
    return np.asarray(np.linalg.eigvalsh(remainder.T @ remainder))


def settling_block(
    fit: Fit, chance: Callable[[Fit], float | None], full_scale: float = np.inf
) -> Advice | None:
    """The shortest block after which what is open has a name as surely as a verdict names it.

    Parameters
    ----------
    fit : Fit
        The fit of the poses recorded so far.
    chance : callable
        How likely a name is at the fit as it would then stand, by
        :mod:`calib.diagnosis.next_measurement.chance`; None where that cannot be said.
    full_scale : float
        Of the triad, SI; it keeps the block to what the sensor can measure.

    Returns
    -------
    Advice or None
        The likeliest block where none is sure; None where there is no block.
    """
    options = []
    for block, then in hypothetical(fit, full_scale):
        likely = chance(then)
        if likely is not None:
            options.append(Advice(block.code, block.instruction, block.minutes, likely))
            if likely >= CONSTANTS.sure:
                break
    return max(options, default=None, key=lambda each: (each.chance or 0.0, -each.minutes))


def showing_blocks(
    fit: Fit, effect: Effect, size: float, enough: float, full_scale: float = np.inf
) -> tuple[list[Advice], list[Advice]]:
    """Blocks of the menu that show an effect of typical size, and those that show more than now.

    Parameters
    ----------
    fit : Fit
        The fit of the poses recorded so far, which are blind to a direction of its parameters.
    effect : Effect
    size : float
        Typical of each of its parameters, SI.
    enough : float
        Chi-square of that size from which on a direction is seen.
    full_scale : float
        Of the triad, SI.

    Returns
    -------
    whole, more : list of Advice
        With which all directions are seen, and more directions than now; cheapest first.
    """
    def shown(then: Fit) -> FloatArray:
        columns = np.zeros((len(then.rows.residual), len(effect.parameters)))
        columns[: then.equations.data_count] = size * Rival(effect, None).columns(then)
        return _least_first(columns, orthonormal_columns(then.rows.jacobian))

    now = int((shown(fit) >= enough).sum())
    whole, more = [], []
    for block, then in hypothetical(fit, full_scale):
        of_block = shown(then)
        advice = Advice(block.code, block.instruction, block.minutes)
        if of_block[0] >= enough:
            whole.append(advice)
        elif (of_block >= enough).sum() > now:
            more.append(advice)
    return whole, more


def block_called(fit: Fit, code: str) -> Advice | None:
    """The block ``code`` of the menu for the poses of ``fit``; None where it has none.

    A clip with each pose, ``CLIPS``, for a plate whose rate scatters where poses share a measured
    rate; ``SOAK``, a course of the temperature that rises and falls, each slowly, which tells what
    lags from what bends.
    """
    block = next((each for each in menu(fit) if each.code == code), None)
    return None if block is None else Advice(block.code, block.instruction, block.minutes)


def lay_missing(fit: Fit, prediction: Prediction | None) -> Advice | None:
    """The poses that a calibration lacks to hold in every direction; None where it does."""
    if prediction is None or (prediction.holds_everywhere and not prediction.unchecked):
        return None
    if prediction.wanted:
        listed = list_directions(prediction.wanted, len(prediction.wanted), fit.poses.triad)
        words = f"poses with {listed}"
    else:
        near = [pose_in_words(fit, label) for label in prediction.unchecked]
        words = f"poses near those of {list_labels(near)}"
    count = len(prediction.wanted or prediction.unchecked)
    return Advice(DIRECTIONS, words, minutes_for(count))


def shown_name(label: str) -> str:
    """A pose by its file, without the folders where they lie beside that of the session.

    >>> shown_name("../logs/pose_07.csv"), shown_name("rest/pose_07.csv")
    ('pose_07.csv', 'rest/pose_07.csv')
    """
    return label.rpartition("/")[2] if label.startswith("../") else label


def pose_in_words(fit: Fit, label: str) -> str:
    """A pose by its file and the side that faces up: ``pose_07.csv (edge +x -z up)``.

    The file alone where a plate at rest shows no attitude.
    """
    shown = shown_name(label)
    i, poses = list(fit.poses.label).index(label), fit.poses
    up = poses.force[i]
    if not np.isfinite(up).all():
        spin = poses.spin_rad_s[i] if poses.triad == "gyroscope" else 1.0
        up = fit.rows.vector[i] * np.sign(spin)
    length = float(np.linalg.norm(up))
    return f"{shown} ({direction_name(up / length)})" if length > 0 else shown


def list_labels(labels: Sequence[str]) -> str:
    """The first ``LABELS_LISTED`` of ``labels`` as one phrase, and how many more there are."""
    text = ", ".join(labels[:LABELS_LISTED])
    rest = len(labels) - LABELS_LISTED
    return f"{text} and {rest} more" if rest > 0 else text
