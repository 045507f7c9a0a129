"""The next change by ``--auto``: an effect that is named without doubt, or one for its class.

For a misfit of no listed shape it is a formula, or the effect that adds its size to the sds.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from calib.diagnosis.hypotheses.columns import causes
from calib.diagnosis.verdict.decision import Code
from calib.discovery.discover import Discovered
from calib.discovery.together import discover_each
from calib.effects.catalogue import STEP
from calib.errors import CalibrationError
from calib.fit.validation.elsewhere import mean_square_apart, mean_square_error
from pipeline.config.edit import add_entry
from pipeline.config.load import config_from
from pipeline.config.schema import EffectSection
from pipeline.config.yaml_syntax import yaml_word
from pipeline.model_change import ModelChange, RunConfig, Target, change_model, result_of
from pipeline.stages.run import Outcome
from pipeline.stages.triads import TriadResult

MOST_ALIKE = 3  #: formulas that look the same and are named; it chooses words only
MOST_CHANGES = 8
"""Largest number of changes by ``--auto``: no sensor in the catalogue's sources needs as many."""


def next_change(
    outcome: Outcome, run: RunConfig, refused: Collection[Target] = ()
) -> ModelChange | None:
    """The next change by ``--auto``: the first effect that a diagnosis names, if need be for its
    class.

    If the members of a class correct new attitudes equally, the choice among them does not matter
    for the correction; the file states that one represents all. ``refused`` are effects that were
    tried and did not lower the error.

    Raises
    ------
    ConfigError
        The configuration does not run with it.
    """
    for result in outcome.triads:
        if may_follow_a_column(result, outcome.config.covariates):
            continue  # for :func:`change_for_unknown`
        for named in (*result.diagnosis.addable, *result.diagnosis.names):
            name = result.diagnosis.offered(named)
            others = [each for each in result.diagnosis.named_class(name) if each != name]
            remark = f"{name} stands for its class: {', '.join(others)}" if others else ""
            if Target((result.triad,), name) in refused:
                continue
            try:
                first, *rest = (
                    change_model(outcome.config, Target((result.triad,), member), run,
                                 before=outcome, remark=remark if member == name else "")
                    for member in (name, *others)
                )
            except CalibrationError:
                continue
            if not rest or error_falls(first, beside=rest):
                return first
    return None


def error_falls(change: ModelChange, beside: Sequence[ModelChange] = ()) -> bool:
    """Whether a change lowers the expected error of corrected readings in new attitudes.

    The changes ``beside`` add the other members of a class; the differences of their corrections,
    weighted by their probabilities in the class, count as errors.
    """
    before, after = (result_of(outcome, change.target) for outcome in (change.before, change.after))
    if before is None or after is None:
        return True
    error = mean_square_error(after.calibration.fit)
    likely = {each.name: each.probability for each in before.diagnosis.ranking}
    whole = sum(likely.get(each.target.name, 0.0) for each in (change, *beside))
    for each in beside:
        other = result_of(each.after, each.target)
        if other is not None and whole:
            error += likely.get(each.target.name, 0.0) / whole * mean_square_apart(
                after.calibration, other.calibration)
    return error < mean_square_error(before.calibration.fit)


def effect_key(triad: str, found: Discovered, effects: Mapping[str, EffectSection]) -> str:
    """The key of a formula under ``effects:``: its name, and the triad if another has that name."""
    name = found.formula.name
    other = effects.get(name)
    return name if other is None or other.triad in (None, triad) else f"{name}_{triad}"


def definition(triad: str, found: Discovered) -> str:
    """The value of the effect's key in a configuration, on one line."""
    formula = found.formula
    alike = ", ".join(yaml_word(each.expression) for each in found.alike[:MOST_ALIKE])
    return (f"{{expression: {yaml_word(formula.expression)}, per: {formula.per}, "
            f"unit: {yaml_word(formula.effect.unit)}, triad: {triad}"
            + (f", alike: [{alike}]}}" if alike else "}"))


def may_follow_a_column(result: TriadResult, covariates: Sequence[str] | None) -> bool:
    """Whether a step in time is named that may be the step of an error along a logged column."""
    poses = result.calibration.fit.poses
    return result.diagnosis.name == STEP and any(
        np.ptp(poses.columns[name]) > 0 for name in causes(poses, covariates))


def without_formula(result: TriadResult) -> str | None:
    """The effect that is added where no formula holds: a step in time that is named, or what adds
    the error to the sds; None where neither is searched."""
    diagnosis = result.diagnosis
    if diagnosis.name == STEP:
        return STEP
    name = "bias_wander" if diagnosis.name == "time_s" else "extra_noise"
    if diagnosis.verdict is Code.NOISE:
        name = diagnosis.name or name
    sought = diagnosis.explanation.step == "discover"
    return name if sought and name not in result.calibration.fit.model.names else None


def change_for_unknown(
    outcome: Outcome, run: RunConfig, refused: Collection[Target] = ()
) -> ModelChange | None:
    """The change that ``--auto`` makes where a formula is searched: the one that is discovered.

    If there is no formula, the effect that adds the error to the sds. ``refused`` are effects that
    were tried and did not lower the error.

    Raises
    ------
    ConfigError
        The configuration cannot be read with the formula.
    Undetermined
        A Python function of the model raised.
    """
    sought = [result for result in outcome.triads
              if result.diagnosis.explanation.step == "discover"
              or may_follow_a_column(result, outcome.config.covariates)]
    fits = [result.calibration.fit for result in sought]
    formulas = discover_each(fits, outcome.config.covariates)
    for result, best in zip(sought, formulas, strict=True):
        config = outcome.config
        name = without_formula(result) if best is None else (
            best.listed or effect_key(result.triad, best, config.effects))
        if name is None or Target((result.triad,), name) in refused:
            continue
        if best is not None and best.listed is None and name not in config.effects:
            config = config_from(add_entry(
                config.source, "effects", name, definition(result.triad, best)))
        try:
            return change_model(
                config, Target((result.triad,), name), run, before=outcome, anyway=True)
        except CalibrationError:
            continue
    return None


def is_noise(change: ModelChange) -> bool:
    """Whether the added effect corrects nothing, and adds to the sds alone."""
    result = result_of(change.after, change.target)
    return result is not None and any(
        each.drawn and each.name == change.target.name
        for each in result.calibration.fit.model.effects)


def without_noise(
    outcome: Outcome, noise: Target, run: RunConfig, refused: Collection[Target] = ()
) -> Outcome | None:
    """``outcome`` without a noise that was added before its effects; None where it has to stay.

    A noise stands for all that is not named yet, and hides the shape of what remains once some of
    it is named. It goes where nothing is missing without it, or where an effect would be next.

    Raises
    ------
    ConfigError
        The configuration cannot be read without it.
    """
    try:
        after = change_model(outcome.config, noise, run, before=outcome, remove=True).after
    except CalibrationError:
        return None
    result = result_of(after, noise)
    if result is None:
        return None
    if result.diagnosis.verdict is Code.NOTHING_MISSING:
        return after
    alone = replace(after, triads=(result,))
    change = next_change(alone, run, refused) or change_for_unknown(alone, run, refused)
    return after if change is not None and not is_noise(change) else None
