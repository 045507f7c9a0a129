"""Search for the formula that the poses support: a closed-form screen, then left-out poses.

Each formula has log odds by its evidence against no formula, with a prior that falls by
``PER_TERM`` with every term, so that a longer one must gain more; the numbers in the likeliest are
refined, at a price. They are compared with the listed effects and refitted. A formula is accepted
if its odds at the refit are high against none and against a wandering bias (beside a strong signal
a linear score is off by more than noise), if it predicts left-out poses, fold by fold, better than
the model without it, and if new attitudes are expected to have a smaller error with it. A listed
effect that predicts them as well is preferred: a formula is for what no effect describes.
"""

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.columns import causes
from calib.diagnosis.hypotheses.courses import by_clock
from calib.diagnosis.hypotheses.listed import Hypothesis, held, listed_hypotheses
from calib.diagnosis.search.refit import refit
from calib.diagnosis.search.table import Table
from calib.diagnosis.search.table_at import table_at
from calib.discovery.functions import Function
from calib.discovery.grammar import Formula, formulas
from calib.discovery.screen import FormulaScreen
from calib.effects.catalogue import STEP
from calib.effects.effect import EFFECTS, Effect
from calib.fit.least_squares import solver
from calib.fit.least_squares.result import Fit
from calib.fit.validation.elsewhere import mean_square_error
from calib.fit.validation.leave_one_out import left_out_residual
from calib.poses.imu_log import FloatArray
from calib.poses.past import Past, with_pasts

PER_TERM = float(np.log(4.0))
"""Cost of each further term of a formula in log odds. Derived: with every term about four times as
many formulas can be built, and all of one length are as likely as all of the next."""

ACCEPTED = float(np.log(100.0))
"""Log odds of a formula against none from which it is accepted. Derived: 100 to 1, one false
formula in a hundred."""

FOLDS = 5  #: parts of the poses, each of which is left out in turn; a judgement, as elsewhere
FOLDS_BETTER = 4
"""Number of folds that a formula must predict better. Derived: by chance 3 of 16 do."""

LEAST_FALL = 0.05
"""Relative fall of the chi-square of the left-out poses. A judgement: no user would want to keep a
formula that gains less."""

BENT = 0.1
"""Share of the log odds of the likeliest formula that a refit can make up beside. Derived: the
error of the linearisation grows with the signal."""

REFITTED = 6  #: the likeliest formulas, of different classes, that are refitted; a limit of time
TABLED = 200  #: the likeliest formulas, compared with the listed effects; a limit of time

REFINED = 12  #: the likeliest families whose numbers are refined; a limit of time
SHARPENED = 3  #: searches for the numbers at a formula's own solution; a limit of time
HALVINGS = 10  #: most halvings of the steps between numbers; derived: four digits are written


@dataclass(frozen=True, eq=False)
class Discovered:
    """A formula that the poses support.

    Attributes
    ----------
    formula : Formula
    alike : tuple of Formula
        Formulas that are equivalent in these poses, the likeliest first.
    log_odds : float
        Against no formula, its prior included.
    left_out_before, left_out_after : float
        Root mean square, in sds, of the rows of left-out poses, without and with it.
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


def discover(
    fit: Fit, covariates: Sequence[str] | None = None, known: Collection[Function] = ()
) -> Discovered | None:
    """The likeliest formula for what the model of ``fit`` misses.

    Parameters
    ----------
    fit : Fit
    covariates : sequence of str or None
        Logged columns that may cause an error; None for all that do not follow attitude or clock.
    known : collection of Function
        What other triads of the session follow; this one does so with odds of 20 to 1.

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
    every = [each for each in formulas(fit.poses, columns, known)
             if each.name not in fit.model.names]
    likely_ones = _likeliest(FormulaScreen(fit), every)
    if not likely_ones:
        return None
    every, priors = map(list, zip(*likely_ones, strict=True))
    fit = _with_pasts(fit, [past for each in every for past in each.effect.pasts])
    at = fit.equations.at_reading
    hypotheses = [Hypothesis(each.name, "listed", prior, each.effect)
                  for each, prior in likely_ones]
    n = len(hypotheses)
    hypotheses += listed_hypotheses(fit, covariates=covariates)[0]
    wanders = [each for each in by_clock(fit) if each.kind == "drawn"]
    table = table_at(fit, [*hypotheses, *wanders])
    density, _ = table.singles()
    without = np.logaddexp.reduce([*table.noise.nothing(table.chi2), *(
        each.log_prior + density[len(hypotheses) + k] for k, each in enumerate(wanders))])
    density = density[: len(hypotheses)]
    odds = density[:n] + priors - without
    tried = _tried(fit, table, every, odds, known)
    before = _left_out(fit)
    for one in sorted(tried, key=lambda each: -each.log_odds):
        after = _left_out(one.fit)
        if one.log_odds < ACCEPTED or not _holds(before, after) or (
                mean_square_error(one.fit) >= mean_square_error(fit)):
            continue
        ranked = [n + int(k) for k in np.argsort(-density[n:]) if np.isfinite(density[n + k])]
        rivals = [*ranked[:1], *table.aliases(one.place, ranked)]
        effects = {hypotheses[k].name: held(hypotheses[k], 0) for k in rivals}
        if every[one.place].column == "time_s" and STEP not in fit.model.names:
            effects[STEP] = EFFECTS[STEP].within(at)
        name, listed = _listed(fit, effects.values(), after)
        rows = fit.equations.data_count
        rms = [float(np.sqrt(out.sum() / rows)) for out in (before, after, listed)]
        return Discovered(one.formula, tuple(every[k] for k in one.same), one.log_odds,
                          rms[0], rms[1], one.fit, name, rms[2])
    return None


@dataclass(frozen=True, eq=False)
class _Tried:
    """A formula at its refit: its index in the table, those of its equivalents, its odds."""

    formula: Formula
    place: int
    same: tuple[int, ...]
    log_odds: float
    fit: Fit


def _tried(
    fit: Fit, table: Table, every: Sequence[Formula], odds: FloatArray, known: Collection[Function]
) -> list[_Tried]:
    """The likeliest formula with a function that is ``known``, and the likeliest and the shortest
    of each class of equivalent formulas, at their refits."""
    best = float(odds[np.nanargmax(odds)])
    bar = max(0.0, best - CONSTANTS.negligible - BENT * best)
    order = [int(j) for j in np.argsort(-odds)]
    likely = [j for j in order if odds[j] > bar]
    of_others = {function.expression for function in known}
    tried: list[_Tried] = []

    def at_refit(k: int, same: Iterable[int], bonus: float = 0.0) -> None:
        joint = refit(fit, [every[k].effect])
        if joint is None:
            return
        block = table.unit_block(k)
        rest = table.residual - block @ (block.T @ table.residual)
        formula, whole, paid = (every[k], joint.fit, 0.0) if bonus else _sharper(
            fit, every[k], joint.fit)
        with_it, linear = (float(np.logaddexp(*table.noise.nothing(chi2)))
                           for chi2 in (whole.chi2, float(rest @ rest)))
        log_odds = float(odds[k]) + with_it - linear - paid + bonus
        tried.append(_Tried(formula, k, tuple(i for i in same if i != k), log_odds, whole))

    for k in [j for j in order if every[j].function.expression in of_others][:1]:
        at_refit(k, table.aliases(k, likely), CONSTANTS.told_apart)
    for _ in range(REFITTED):
        if not likely:
            break
        j = likely.pop(0)
        same = [k for k in table.aliases(j, likely) if k in likely]
        likely = [k for k in likely if k not in same]
        shortest = min([j, *same], key=lambda k: every[k].length)
        for k in dict.fromkeys((j, shortest)):
            at_refit(k, (j, *same))
    return tried


def _likeliest(screen: FormulaScreen, every: Sequence[Formula]) -> list[tuple[Formula, float]]:
    """The likeliest formulas that are not ruled out, each with its log prior.

    The likeliest families are present with refined numbers too: these share the prior of one
    formula of the grid.
    """
    if not every:
        return []
    weights = np.array([-PER_TERM * each.length for each in every])
    priors = weights - np.logaddexp.reduce(weights) + np.log(CONSTANTS.odds_unknown)
    odds = screen.log_densities(every) + priors - screen.nothing()
    order = [int(j) for j in np.argsort(-odds)[:TABLED] if odds[j] > -CONSTANTS.negligible]
    likely = {every[j].name: (every[j], float(priors[j])) for j in order}
    families: dict[object, int] = {}
    for j in order:
        one = every[j]
        if one.function.varied:
            families.setdefault((one.factor, one.per, one.function.text), j)
    for j in list(families.values())[:REFINED]:
        one, paid = _refined(screen, every[j])
        likely.setdefault(one.name, (one, float(priors[j]) - paid))
    return list(likely.values())


def _refined(screen: FormulaScreen, formula: Formula) -> tuple[Formula, float]:
    """``formula`` with the likeliest numbers within a step of its own, and their log share.

    The steps are halved as long as that gains more than twice as many numbers cost.
    """
    best, least = formula, float(screen.log_densities([formula])[0])
    cost, paid = formula.function.varied * math.log(2), 0.0
    for k in range(1, HALVINGS + 1):
        for _ in range(formula.function.varied):  # one number after the other
            near = [replace(best, function=one) for one in best.function.finer(0.5**k)]
            density = screen.log_densities(near)
            if not float(density.max()) > least + cost * k - paid:
                break
            best, least, paid = near[int(density.argmax())], float(density.max()), cost * k
    return best, paid


def _sharper(base: Fit, formula: Formula, joint: Fit) -> tuple[Formula, Fit, float]:
    """``formula`` with the numbers that are likeliest at its own solution, its fit, and the price.

    Beside a strong signal the numbers from the rows of ``base`` are off by more than noise.
    """
    price = 0.0
    for _ in range(SHARPENED):
        finer, paid = _refined(FormulaScreen(joint, (formula.name,)), formula)
        again = refit(_with_pasts(base, finer.effect.pasts), [finer.effect])
        if again is None or not again.fit.chi2 < joint.chi2 - 2 * paid or not paid:
            break
        formula, joint, price = finer, again.fit, price + paid
    return formula, joint, price


def _with_pasts(base: Fit, pasts: Sequence[Past]) -> Fit:
    """The fit to poses that include the columns computed from the past."""
    stated = base.poses.as_stated
    poses = with_pasts(stated, pasts)
    robust = bool((base.weight != 1).any())
    return base if poses is stated else solver.fit(poses, base.model, robust=robust)


def _listed(
    fit: Fit, rivals: Iterable[Effect], with_formula: FloatArray
) -> tuple[str | None, FloatArray]:
    """Best listed effect of ``rivals`` that predicts the folds (FOLDS,) as well as a formula."""
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
    """Whether left-out sums of squares (FOLDS,) fall in nearly every fold, and by much in total."""
    fall = 1 - float(after.sum()) / float(before.sum())
    return int((after < before).sum()) >= FOLDS_BETTER and fall > LEAST_FALL


def _left_out(fit: Fit) -> FloatArray:
    """Sum of the squares of the whitened rows of each fold when it is left out, (FOLDS,)."""
    fold = np.random.default_rng(len(fit.poses)).permutation(len(fit.poses)) % FOLDS
    of_row = fold[fit.equations.row_pose]
    residual = fit.rows.residual * np.sqrt(fit.weight)
    out = left_out_residual(residual, fit.weighted_jacobian, of_row)
    return np.asarray(np.bincount(of_row, out**2, minlength=FOLDS), float)
