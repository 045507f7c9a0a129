"""The next measurement: the block that separates the rivals best for its duration.

The separating power of a block is the non-centrality ``lambda``: by how much chi-square would
rise if the rival were fitted where the candidate is true, everything else free (T-optimality). 12
gives about 90 % power. Nothing is looked up; every block is computed at the fitted model.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.next_measurement.chance import BLIND_SIGNAL_SD, Rival, chance_of_a_name
from calib.diagnosis.next_measurement.kind import shares_a_rate
from calib.diagnosis.next_measurement.pose_blocks import (
    CLIPS,
    SOAK,
    hypothetical,
    menu,
    minutes_for,
)
from calib.effects.effect import Effect
from calib.fit.least_squares.result import Fit
from calib.fit.linear import orthonormal_columns
from calib.fit.validation.prediction import Prediction
from calib.numbers import NO_LENGTH
from calib.poses.attitudes import direction_name, list_directions
from calib.poses.imu_log import FloatArray

ENOUGH_LAMBDA = 12.0  #: non-centrality; derived: power 0.93 at 5 % with one degree of freedom
LABELS_LISTED = 3  #: it chooses words only


@dataclass(frozen=True)
class Advice:
    """Advice: ``block`` for programs, ``instruction`` for people, ``power`` the lambda.

    ``minutes`` is what it takes, ``timed`` the instruction with it; ``chance`` the share of
    simulated sessions in which what is there then gets a name, None where no name is asked for.
    """

    block: str
    instruction: str
    power: float
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


def _signal(fit: Fit, rival: Rival, others: Sequence[Rival]) -> float:
    """lambda of ``rival`` when ``others`` and the model are fitted in its place."""
    d = fit.equations.data_count
    columns = rival.columns(fit)
    fitted = [fit.rows.jacobian[:, : fit.model.size], fit.rows.jacobian[:, fit.model.size :]]
    for other in others:
        more = np.zeros((len(fit.rows.residual), len(other.effect.parameters)))
        more[:d] = other.columns(fit)
        fitted.append(more)
    basis = orthonormal_columns(np.hstack(fitted))
    full = np.zeros((len(fit.rows.residual), columns.shape[1]))
    full[:d] = columns
    if rival.size is not None:
        signal = full @ rival.size
        remainder = signal - basis @ (basis.T @ signal)
        return float(remainder @ remainder)
    # No size to go by: the direction that shows least, of BLIND_SIGNAL_SD root mean square.
    norm = np.maximum(np.sqrt((full**2).sum(axis=0)), NO_LENGTH)
    return float(_least_first(full / norm * np.sqrt(d) * BLIND_SIGNAL_SD, basis)[0])


def _least_first(columns: FloatArray, basis: FloatArray) -> FloatArray:
    """Squares (k,) of the parts of columns (r, k) outside a ``basis``, by direction, ascending.

    NaN where the columns are not known.
    """
    if not np.isfinite(columns).all():
        return np.full(columns.shape[1], np.nan)
    remainder = columns - basis @ (basis.T @ columns)
    return np.asarray(np.linalg.eigvalsh(remainder.T @ remainder))


def best_block(fit: Fit, rivals: Sequence[Rival], full_scale: float = np.inf) -> Advice | None:
    """The block that tells ``rivals`` apart (or makes a single one visible), per minute of work.

    The criterion is the T-optimality of Atkinson and Fedorov (Biometrika 62, 1975).

    Parameters
    ----------
    fit : Fit
        The fit of the poses recorded so far.
    rivals : sequence of Rival
        At least one.
    full_scale : float
        Of the triad, SI; it keeps the block to what the sensor can measure.

    Returns
    -------
    Advice or None
        None where no block of the menu reaches ``ENOUGH_LAMBDA``.
    """
    options = []
    for block, then in hypothetical(fit, full_scale):
        power = _power(then, rivals)
        if np.isfinite(power) and power >= ENOUGH_LAMBDA:
            options.append((Advice(block.code, block.instruction, power, block.minutes), then))
    if not options:
        return None
    # Power beyond enough adds nothing: the cheapest sufficient block wins.
    advice, then = max(options, key=lambda option: (
        min(option[0].power, 10 * ENOUGH_LAMBDA) / option[0].minutes))
    return replace(advice, chance=chance_of_a_name(then, rivals))


def likeliest_block(fit: Fit, rivals: Sequence[Rival], full_scale: float = np.inf) -> Advice | None:
    """The block after which one of ``rivals`` has a name most often, whatever its chance.

    The parameters are those of :func:`best_block`; None where no block can be judged.
    """
    options = []
    for block, then in hypothetical(fit, full_scale):
        power = _power(then, rivals)
        if np.isfinite(power):
            options.append(Advice(block.code, block.instruction, power, block.minutes,
                                  chance_of_a_name(then, rivals)))
    return max(options, default=None, key=lambda advice: (advice.chance, -advice.minutes))


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
        advice = Advice(block.code, block.instruction, float(of_block[0]), block.minutes)
        if advice.power >= enough:
            whole.append(advice)
        elif (of_block >= enough).sum() > now:
            more.append(advice)
    return whole, more


def _power(then: Fit, rivals: Sequence[Rival]) -> float:
    """The least lambda of any of ``rivals`` with any other in its place."""
    powers = []
    for i, rival in enumerate(rivals):
        others = [
            [each] for j, other in enumerate(rivals) if j != i for each in other.in_all_shapes
        ] or [[]]
        powers += [_signal(then, rival, other) for other in others]
    return min(powers)


def film_each_pose(fit: Fit, drop: float) -> Advice | None:
    """A clip with each pose, for a plate whose scatter takes ``drop`` off chi-square.

    None where the poses have rates of their own already.
    """
    if not shares_a_rate(fit.poses):
        return None
    return Advice(CLIPS.code, CLIPS.instruction, drop, CLIPS.minutes)


def another_soak(fit: Fit, drop: float) -> Advice | None:
    """Other temperatures, for what follows the temperature and takes ``drop`` off chi-square.

    A course that rises and falls, each slowly, tells what lags from what bends. None where no
    temperature was logged.
    """
    soak = next((block for block in menu(fit) if block.code == SOAK), None)
    return None if soak is None else Advice(soak.code, soak.instruction, drop, soak.minutes)


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
    return Advice("directions", words, prediction.times_a_pose**2, minutes_for(count))


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
