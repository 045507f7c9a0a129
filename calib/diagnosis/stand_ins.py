"""Effects of a model that stand for others, and the error of the next log by these.

Poses that do not tell an effect from another do not tell which of them corrects the next log, in
which time and temperature go ways of their own. With P the probability of another member of the
class, v the vector that the calibration corrects and v' the one that it would correct with that
member, refitted, in its effect's place, a magnitude errs by

    E² = Σ P <(|v| - |v'|)²>

averaged over the attitudes, times and columns of the poses, each by itself.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.search.table_at import table_at
from calib.effects.catalogue import BASE
from calib.effects.effect import Effect
from calib.errors import CalibrationError
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit as fit_model
from calib.fit.model import Model
from calib.fit.triad.calibration import TriadCalibration, calibrate_triad
from calib.fit.validation.elsewhere import squares_apart
from calib.fit.validation.prediction import LOGS, Prediction, other_logs
from calib.poses.imu_log import FloatArray


@dataclass(frozen=True, eq=False)
class StandIn:
    """The effects that one of a model stands for.

    Attributes
    ----------
    names : tuple of str
        Theirs, and the expressions that were not told from it where it was found.
    effects : tuple of Effect
        Those with a name, the shape parameter that is the likeliest first among its starts.
    probability : tuple of float
        That it is this effect of the class and no other, by effect.
    """

    names: tuple[str, ...]
    effects: tuple[Effect, ...]
    probability: tuple[float, ...]


def stand_ins(fit: Fit, hypotheses: Sequence[Hypothesis]) -> Mapping[str, StandIn]:
    """The effects that ``fit`` was extended by, with those that would do as well in their place.

    Parameters
    ----------
    fit : Fit
    hypotheses : sequence of Hypothesis
        What may be missing beside the model of ``fit``.

    Returns
    -------
    mapping of str to StandIn
        Of effects that something may stand in the place of: listed effects whose odds against it
        are better than one to twenty, while either is as much better than none; and the expressions
        that were not told from it where it was found.
    """
    listed = [h for h in hypotheses if h.kind == "listed" and not h.is_placed]
    alike: dict[str, StandIn] = {}
    for effect in fit.model.effects:
        if effect.name in BASE or effect.acts_on in ("reading", "noise") or effect.drawn:
            continue
        mine = Hypothesis(effect.name, "listed", 0.0, effect, fit.shapes.get(effect.name))
        table = table_at(fit, (mine, *listed), (effect.name,))
        density, _ = table.singles()
        nothing = float(np.logaddexp(*table.noise.nothing(table.chi2)))
        least = max(float(density[0]) - CONSTANTS.told_apart,
                    nothing + CONSTANTS.told_apart)
        first: dict[str, tuple[Hypothesis, float]] = {}
        for h, value in sorted(zip(listed, density[1:], strict=True), key=lambda pair: -pair[1]):
            if value > least:
                first.setdefault(h.name, (h, float(value)))
        if first or effect.alike:
            odds = np.exp([value - float(density[0]) for _, value in first.values()])
            alike[effect.name] = StandIn(
                (*first, *effect.alike),
                tuple(_from_its_shape(h) for h, _ in first.values()),
                tuple(map(float, odds / (1 + odds.sum()))))
    return alike


def _from_its_shape(h: Hypothesis) -> Effect:
    """The effect of a hypothesis, the search of its shape parameter beginning at its shape."""
    assert h.effect is not None
    if h.effect.shape is None or h.shape is None:
        return h.effect
    return replace(h.effect, shape=replace(h.effect.shape, starts=(h.shape,)))


def error_of_stand_ins(
    prediction: Prediction, calibration: TriadCalibration, standing: Mapping[str, StandIn],
) -> FloatArray:
    """Mean square error of a corrected magnitude by the effects that others stand for, SI, (m, d).
    """
    total = np.zeros_like(prediction.variance)
    if not any(alike.effects for alike in standing.values()):
        return total
    logs = [other_logs(calibration.fit.poses, size * prediction.directions)
            for size in prediction.magnitude]
    conditions = [each.conditions(each.reading).as_in_a_log(each.time_s) for each in logs]
    robust = bool((calibration.fit.weight != 1).any())
    for name, alike in standing.items():
        rest = [each for each in calibration.fit.model.effects if each.name != name]
        for effect, probability in zip(alike.effects, alike.probability, strict=True):
            try:
                model = Model((*rest, effect))
                other = calibrate_triad(
                    fit_model(calibration.fit.poses, model, robust=robust), calibration.spec)
                total += probability * np.array([
                    squares_apart(calibration, other, at).reshape(LOGS, -1).mean(axis=0)
                    for at in conditions])
            except CalibrationError:
                continue
    return total
