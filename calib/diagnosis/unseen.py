"""Influence on a calibration of effects that these poses cannot see, if the sensor is typical.

An effect that the base absorbs whole leaves no residual and moves the parameters:

    d theta = -(JᵀW J)⁻¹ JᵀW C

per unit of its parameters, with C its whitened columns. With the catalogue's typical size for each
parameter, independent of the others, that is a covariance, and a line of its own in the budget.
Whether this sensor is typical is not in the data: the sds of the parameters do not contain it. What
a corrected log will err by does, and the verdict says what it rests on. A lever on a turning plate
is the one error of a bench that no stated sd contains; a length shows its square alone.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from scipy.special import expit

from calib.diagnosis.absorbed import absorbed, parted
from calib.diagnosis.diagnose import Diagnosis
from calib.diagnosis.formula_error import error_of_formulas
from calib.diagnosis.stand_ins import error_of_stand_ins
from calib.diagnosis.verdict.decision import Code
from calib.effects.effect import EFFECTS, Effect
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.widened import WANDERS
from calib.fit.triad.calibration import TriadCalibration, parameter_sds
from calib.fit.triad.within_poses import LEAST_SHARE
from calib.fit.validation.elsewhere import error_by_missing
from calib.fit.validation.prediction import Prediction
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.runs.reference_runs import TIME_BASE

HARDLY_SEEN = 0.25
"""Share of the variance of a typical size that the poses leave. Derived: they know it no better
than to half of that size."""

OUTWEIGHS = 3.0
"""Times what the poses leave, that an effect adds which they hardly see: less than that a typical
size, known to a factor of two or three, does not decide. A judgement."""

LOW_COST = "MPU-6050"
"""The class of parts that a sensor is taken for where nothing else is known; see the catalogue."""


def unseen_budget(
    calibration: TriadCalibration, blind: Iterable[str], part: str
) -> dict[str, FloatArray]:
    """Sd of misalignment (rad), bias (counts) and scale (counts per unit) by each blind effect.

    Parameters
    ----------
    calibration : TriadCalibration
    blind : iterable of str
        Effects that the poses cannot see, as the diagnosis lists them.
    part : str
        Class of the sensor, as the pages of the catalogue call it.

    Returns
    -------
    dict of name to array, shape (3, 3)
        As :func:`calib.fit.triad.calibration.uncertainty_budget`. Effects without a quoted size for
        this triad, and those that move no parameter, are left out; so is a wrong clock that is
        stated.
    """
    stated = calibration.fit.poses.reference
    clocked = stated.common[:, [name == TIME_BASE for name in stated.common_names]].any()
    budget = {}
    for name in blind:
        effect = EFFECTS.get(name)
        if effect is None or (name == "reference_scale" and clocked):
            continue
        size = typical_size(effect, part, calibration.triad)
        if size is None:
            continue
        shift = size * absorbed(calibration, effect)
        sds = parameter_sds(calibration, shift @ shift.T)
        if (np.nan_to_num(sds) > LEAST_SHARE * np.nan_to_num(calibration.parameters.sd)).any():
            budget[name] = sds
    return budget


def typical_size(effect: Effect, part: str, triad: Triad) -> float | None:
    """Size of each parameter, SI, for this class of sensor; what belongs to the bench has its own.

    None where the catalogue quotes none.
    """
    pages = effect.page.typical
    size = pages.get(part) or next(iter(pages.values()), None)
    return None if size is None else size.si_for(triad)


def _typical_root(effect: Effect, size: float) -> FloatArray:
    """A square root (k, j) of the mean of t tᵀ: of normal parameters, or of their products."""
    count = len(effect.parameters)
    if not effect.in_square:
        return size * np.eye(count)
    i, j = np.triu_indices(count)
    squares = (i == j).astype(float)
    mean = np.diag(1 + squares) + np.outer(squares, squares)  # of x²x² three, of x²y² one
    return np.asarray(size**2 * np.linalg.cholesky(mean))


def with_unseen(
    prediction: Prediction, calibration: TriadCalibration, diagnosis: Diagnosis, part: str
) -> Prediction:
    """``prediction`` with the effects that these poses cannot see or the verdict leaves open.

    Effects of the bench are left out: the stated sds of the references contain them, but for a
    lever on the turning plate.

    Parameters
    ----------
    prediction : Prediction
        By the poses alone.
    calibration : TriadCalibration
    diagnosis : Diagnosis
        Of its fit.
    part : str
        Class of the sensor, as the pages of the catalogue call it.

    Returns
    -------
    Prediction
        Of an effect of typical size t that shows in the rows with Λ per unit, the poses leave
        ``t²/(1 + t²Λ)`` about what is likely. What of it they know better than ``HARDLY_SEEN``
        counts by how likely such an effect is beside none (:func:`_present`), where nothing is
        missing by the verdict: one of 60 evenings at 5° of tilt that hide an ordinary g-sensitivity
        is called complete, and erred by 14 times the sd of its poses.
        Blind effects that add less than ``LEAST_SHARE`` of what the poses leave are not listed, nor
        what they see where it adds less than ``OUTWEIGHS`` times all that they leave; a lever is on
        every plate.
    """
    unseen = {}
    settled = diagnosis.verdict == Code.NOTHING_MISSING
    # By a misfit of something else, what the rows hardly show would be any number of typical sizes.
    residual = _residual(calibration.fit) * settled
    for effect in _not_in_the_model(calibration.fit, diagnosis):
        size = typical_size(effect, part, calibration.triad)
        if size is None:
            continue
        held, remainder = parted(calibration, effect)
        typical = _typical_root(effect, size)
        shown, turns = np.linalg.eigh(typical.T @ remainder.T @ remainder @ typical)
        hardly = 1 / (1 + shown) > HARDLY_SEEN
        score = turns.T @ typical.T @ remainder.T @ residual
        present = _present(shown, score) if settled else 0.0
        likely = typical @ turns * (score / (1 + shown))
        without = likely[:, hardly].sum(axis=1)
        weight = np.sqrt(np.where(hardly, 1.0, present) / (1 + shown))
        root = np.column_stack([typical @ turns * weight, np.sqrt(1 - present) * without,
                                np.sqrt(present) * likely.sum(axis=1)])
        variance = error_by_missing(calibration, prediction, effect, held, root)
        blind = effect.in_square or effect.name in (*diagnosis.blind, *diagnosis.unavailable)
        least = (LEAST_SHARE if blind else OUTWEIGHS) ** 2 * prediction.variance.mean()
        if np.isfinite(variance).all() and variance.mean() > least:
            unseen[effect.name] = variance
    return replace(prediction, unseen=unseen,
                   open=_left_open(prediction, calibration, diagnosis))


def _present(shown: FloatArray, score: FloatArray) -> float:
    """The probability of an effect of typical size beside none, both as likely before.

    Along the directions of its normal prior, in whose sds the rows show ``shown`` = t²Λ and
    ``score``.
    """
    evidence = (score**2 / (1 + shown) - np.log1p(shown)).sum() / 2
    return float(expit(evidence))


def _residual(fit: Fit) -> FloatArray:
    """The whitened residual, weighted, (r,)."""
    return np.asarray(fit.rows.residual * np.sqrt(fit.weight))


def _not_in_the_model(fit: Fit, diagnosis: Diagnosis) -> list[Effect]:
    """The sensor's effects that the model lacks, also those for which gravity was not logged."""
    logged = np.isfinite(fit.poses.force).all() or not fit.poses.spin_rad_s.all()
    by_gravity = () if logged else (
        name for name in diagnosis.unavailable if EFFECTS[name].needs == ("force",))
    names = dict.fromkeys((*diagnosis.blind, *diagnosis.listed, *by_gravity))
    return [EFFECTS[name] for name in names if name in EFFECTS and name not in fit.model.names
            and (EFFECTS[name].belongs_to == "sensor" or EFFECTS[name].in_square)]


def _left_open(
    prediction: Prediction, calibration: TriadCalibration, diagnosis: Diagnosis
) -> FloatArray:
    """Variance (m, d) by what may be missing and goes on, averaged over all credible sets, and by
    what the model's effects stand for.

    An error that follows the temperature or the time vanishes under typical conditions, and one of
    unknown shape has no formula: each counts at least as much as the rows show of it. Noise that
    the samples of the poses do not show goes on in the next log, also where the model has it.
    """
    total = (error_of_formulas(prediction, calibration) + _drawn_anew(calibration.fit)
             + error_of_stand_ins(prediction, calibration, diagnosis.stands_for))
    if diagnosis.verdict == Code.NOTHING_MISSING:
        return total
    average, of_row = diagnosis.averaged, np.median(calibration.fit.equations.magnitude_sd) ** 2
    total += max(average.factor - 1.0, 0.0) * of_row
    for each in average.going_on:
        variance = np.full_like(total, each.shown * of_row)
        if each.effect is not None:
            held = absorbed(calibration, each.effect, each.shape)
            by_formula = error_by_missing(calibration, prediction, each.effect, held,
                                          _root(each.moment), each.shape)
            if each.effect.belongs_to == "bench":
                variance[:] = 0.0
            variance = np.fmax(variance, np.where(np.isfinite(by_formula), by_formula, 0.0))
        total += variance
    return total


def _root(moment: FloatArray) -> FloatArray:
    """A square root (k, k) of a mean of products (k, k)."""
    size, turns = np.linalg.eigh(moment)
    return np.asarray(turns * np.sqrt(np.maximum(size, 0.0)))


def _drawn_anew(fit: Fit) -> float:
    """Mean variance of a reading, SI, by the noise in the model: a new pose has its own."""
    poses, reference = fit.poses, fit.poses.reference
    drawn = poses.sd**2 - poses.as_stated.sd**2
    if reference.on_vector is not None:
        wanders = [name.startswith(WANDERS) for name in reference.common_names]
        drawn = drawn + (reference.on_vector[:, :, wanders] ** 2).sum(axis=2)
    return float(drawn.mean())


def together(budget: Mapping[str, FloatArray]) -> FloatArray:
    """All blind effects as one.

    Parameters
    ----------
    budget : mapping of str to array, shape (3, 3)
        By effect: what it adds to the sds of misalignment (rad), bias (counts) and scale (counts
        per SI unit), each x, y, z.

    Returns
    -------
    array, shape (3, 3)
        The root of the sum of their squares, in the same units.
    """
    return np.asarray(np.sqrt(sum(sds**2 for sds in budget.values())))
