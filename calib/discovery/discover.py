"""Which formula the poses show: screened beside the model in closed form, judged on poses left out.

All formulas stand at one table (:mod:`calib.diagnosis.search.table_at`). Each has the log odds of
its evidence against none, with a prior that halves and halves again with every term, so that a
longer one pays. The likeliest are refitted, and one is accepted where its odds against none, as the
refit has them (beside a strong signal a linear score is off by more than noise), are high and
where it predicts poses that took no part, fold by fold, better than the model without it. A listed
effect that predicts them as well is what it is: a formula is for what none of these describes.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.columns import causes
from calib.diagnosis.hypotheses.listed import Hypothesis, held, listed_hypotheses
from calib.diagnosis.search.refit import refit
from calib.diagnosis.search.table import Table
from calib.diagnosis.search.table_at import table_at
from calib.discovery.grammar import Formula, formulas, lags
from calib.effects.catalogue import STEP
from calib.effects.effect import EFFECTS, Effect
from calib.fit.least_squares import solver
from calib.fit.least_squares.result import Fit
from calib.fit.validation.leave_one_out import left_out_residual
from calib.poses.imu_log import FloatArray
from calib.poses.lagged import with_lags

PER_TERM = float(np.log(4.0))
"""Log odds that each further term of a formula costs. Derived: with every term about four times
as many formulas can be built, and all of one length are as likely as all of the next."""

ACCEPTED = float(np.log(100.0))
"""Log odds of a formula against none from which it is believed. Derived: 100 to 1, one false
formula in a hundred."""

FOLDS = 5  #: parts of the poses, each of which is left out in turn; a judgement, as elsewhere
FOLDS_BETTER = 4
"""Number of folds that a formula must predict better. Derived: by chance 3 of 16 do."""

LEAST_FALL = 0.05
"""Fall of the chi-square of the poses left out, relative. A judgement: less is no formula that a
user would want to keep."""

REFITTED = 6  #: the likeliest formulas, of different classes, that are refitted; a limit of time


@dataclass(frozen=True, eq=False)
class Discovered:
    """A formula that the poses show.

    Attributes
    ----------
    formula : Formula
    alike : tuple of Formula
        What looks the same in these poses, the likeliest first.
    log_odds : float
        Against no formula, its prior included.
    left_out_before, left_out_after : float
        Root mean square in sds of the rows of poses that took no part, without and with it.
    fit : Fit
        With it.
    listed : str or None
        The listed effect that predicts the poses left out as well, and is to be added instead.
    left_out_listed : float
        What is left out with that, as above; NaN without one.
    """

    formula: Formula
    alike: tuple[Formula, ...]
    log_odds: float
    left_out_before: float
    left_out_after: float
    fit: Fit
    listed: str | None = None
    left_out_listed: float = math.nan


def discover(fit: Fit, covariates: Sequence[str] | None = None) -> Discovered | None:
    """The likeliest formula for what the model of ``fit`` misses.

    Parameters
    ----------
    fit : Fit
    covariates : sequence of str or None
        Logged columns that may cause an error; None for all that do not follow attitude or clock.

    Returns
    -------
    Discovered or None
        None where no formula holds on poses that took no part.

    Raises
    ------
    Undetermined
        A Python function of the model of ``fit`` raised.
    """
    columns = causes(fit.poses, covariates)
    fit = _with_lags(fit, columns)
    every = formulas(fit.poses, columns)
    every = [each for each in every if each.name not in fit.model.names]
    at = fit.equations.at_reading
    every = [each for each in every if np.isfinite(each.effect.evaluate(at)).all()]
    if not every:
        return None
    weights = np.array([-PER_TERM * each.length for each in every])
    priors = weights - np.logaddexp.reduce(weights) + np.log(CONSTANTS.odds_unknown)
    hypotheses = [Hypothesis(each.name, "listed", float(prior), each.effect)
                  for each, prior in zip(every, priors, strict=True)]
    n = len(hypotheses)
    hypotheses += listed_hypotheses(fit, covariates=covariates)[0]
    table = table_at(fit, hypotheses)
    density, _ = table.singles()
    odds = density[:n] + priors - np.logaddexp(*table.noise.nothing(table.chi2))
    likely = [int(j) for j in np.argsort(-odds) if odds[j] > max(0.0, odds[np.nanargmax(odds)]
                                                                 - CONSTANTS.negligible)]
    tried: list[_Tried] = []
    while likely and len(tried) < REFITTED:
        j = likely.pop(0)
        same = [k for k in table.aliases(j, likely) if k in likely]
        likely = [k for k in likely if k not in same]
        joint = refit(fit, [every[j].effect])
        if joint is not None:
            block = table.unit_block(j)
            rest = table.residual - block @ (block.T @ table.residual)
            gained = _log_noise(table, joint.fit.chi2) - _log_noise(table, float(rest @ rest))
            tried.append(_Tried(j, tuple(same), float(odds[j]) + gained, joint.fit))
    before = _left_out(fit)
    for one in sorted(tried, key=lambda each: -each.log_odds):
        after = _left_out(one.fit)
        if one.log_odds < ACCEPTED or not _holds(before, after):
            continue
        ranked = [n + int(k) for k in np.argsort(-density[n:]) if np.isfinite(density[n + k])]
        rivals = [*ranked[:1], *table.aliases(one.place, ranked)]
        effects = {hypotheses[k].name: held(hypotheses[k], 0) for k in rivals}
        if every[one.place].column == "time_s" and STEP not in fit.model.names:
            effects[STEP] = EFFECTS[STEP].within(at)
        name, listed = _listed(fit, effects.values(), after)
        rows = fit.equations.data_count
        rms = [float(np.sqrt(out.sum() / rows)) for out in (before, after, listed)]
        return Discovered(every[one.place], tuple(every[k] for k in one.same), one.log_odds,
                          rms[0], rms[1], one.fit, name, rms[2])
    return None


@dataclass(frozen=True, eq=False)
class _Tried:
    """A formula at its refit: its place in the table, those of what looks the same, its odds."""

    place: int
    same: tuple[int, ...]
    log_odds: float
    fit: Fit


def _log_noise(table: Table, chi2: float) -> float:
    """Log density of a residual that noise alone has left, stated or larger."""
    return float(np.logaddexp(*table.noise.nothing(chi2)))


def _with_lags(base: Fit, columns: Sequence[str]) -> Fit:
    """The fit to poses that have what follows ``columns`` with the time constants tried."""
    stated = base.poses.as_stated
    poses = with_lags(stated, lags(stated, columns))
    robust = bool((base.weight != 1).any())
    return base if poses is stated else solver.fit(poses, base.model, robust=robust)


def _listed(
    fit: Fit, rivals: Iterable[Effect], with_formula: FloatArray
) -> tuple[str | None, FloatArray]:
    """The best of listed ``rivals`` that predicts the folds (FOLDS,) as well as a formula does."""
    best, least = None, np.full(FOLDS, np.nan)
    for effect in rivals:
        joint = refit(fit, [effect])
        out = None if joint is None else _left_out(joint.fit)
        if out is None or not with_formula.sum() > (1 - LEAST_FALL) * out.sum():
            continue
        if best is None or out.sum() < least.sum():
            best, least = effect.name, out
    return best, least


def _holds(before: FloatArray, after: FloatArray) -> bool:
    """Whether sums of squares (FOLDS,) of what was left out fall in nearly every fold, and much."""
    fall = 1 - float(after.sum()) / float(before.sum())
    return int((after < before).sum()) >= FOLDS_BETTER and fall > LEAST_FALL


def _left_out(fit: Fit) -> FloatArray:
    """Sum of the squares of the whitened rows of each fold when it takes no part, (FOLDS,)."""
    fold = np.random.default_rng(len(fit.poses)).permutation(len(fit.poses)) % FOLDS
    of_row = fold[fit.equations.row_pose]
    root = np.sqrt(fit.weight)
    jacobian = fit.rows.jacobian @ fit.directions * root[:, None]
    out = left_out_residual(fit.rows.residual * root, jacobian, of_row)
    return np.asarray(np.bincount(of_row, out**2, minlength=FOLDS), float)
