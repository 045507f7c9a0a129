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
from calib.effects.catalogue import EFFECTS, STEP
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
) -> Sequence[ModelChange]:
    """The next changes by ``--auto``: all effects that a diagnosis names, or the first of them.

    What is named together explains the misfit together: one alone is fitted to what the others
    leave, and may correct new attitudes worse than none. If the members of a class correct new
    attitudes equally, the choice among them does not matter for the correction; the file states
    that one represents all. Members that these poses cannot determine beside the model, such as a
    curve of as many parameters as there are equations, have no correction to compare. ``refused``
    are effects that were tried and did not lower the error.

    Raises
    ------
    ConfigError
        The configuration does not run with it.
    """
    for result in outcome.triads:
        if may_follow_a_column(result, outcome.config.covariates):
            continue  # for :func:`change_for_unknown`
        diagnosis = result.diagnosis
        alone = [(name,) for name in (*diagnosis.addable, *diagnosis.names)]
        for named in ([diagnosis.names] if len(diagnosis.names) > 1 else []) + alone:
            names = [diagnosis.offered(name) for name in named]
            if any(Target((result.triad,), name) in refused or _is_of_the_bench_or_not(result, name)
                   for name in names):
                continue
            changes = _in_turn(outcome, result, names, run)
            beside = _beside(outcome, result, names, run) if changes else []
            if changes and ((len(names) == 1 and not beside)
                            or error_falls(whole(changes), beside)):
                return changes
    return ()


def whole(changes: Sequence[ModelChange]) -> ModelChange:
    """``changes`` in turn as one, by the target of the last."""
    return replace(changes[-1], before=changes[0].before)


def _in_turn(
    outcome: Outcome, result: TriadResult, names: Sequence[str], run: RunConfig
) -> Sequence[ModelChange]:
    """The changes that add ``names`` one after the other; empty where one is refused."""
    changes: list[ModelChange] = []
    for name in names:
        others = _others(result, name)
        remark = f"{name} stands for its class: {', '.join(others)}" if others else ""
        before = changes[-1].after if changes else outcome
        try:
            changes.append(change_model(
                before.config, Target((result.triad,), name), run, before=before, remark=remark,
                anyway=len(names) > 1))  # all are named, which holds for all together
        except CalibrationError:
            return ()
    return changes


def _is_of_the_bench_or_not(result: TriadResult, name: str) -> bool:
    """Whether one member of the class of ``name`` is an error of the bench and another is none.

    The first leaves the correction of a log alone, and says of the stated rate when it held.
    """
    members = (name, *_others(result, name))
    return len({EFFECTS[each].belongs_to == "bench" for each in members if each in EFFECTS}) > 1


def _others(result: TriadResult, name: str) -> Sequence[str]:
    return [each for each in result.diagnosis.named_class(name) if each != name]


def _beside(
    outcome: Outcome, result: TriadResult, names: Sequence[str], run: RunConfig
) -> Sequence[tuple[float, ModelChange]]:
    """What adds another member of a class in place of one of ``names``, and its probability."""
    likely = result.diagnosis.by_itself
    beside = []
    for place, name in enumerate(names):
        others = _others(result, name)
        every = sum(map(likely, (name, *others)))
        for other in others:
            changes = _in_turn(
                outcome, result, [*names[:place], other, *names[place + 1:]], run)
            if changes and every:
                beside.append((likely(other) / every, whole(changes)))
    return beside


def error_falls(
    change: ModelChange, beside: Sequence[tuple[float, ModelChange]] = ()
) -> bool:
    """Whether a change lowers the expected error of corrected readings in new attitudes.

    The changes ``beside`` add another member of a class; the differences of their corrections,
    weighted by their probabilities in the class, count as errors.
    """
    before, after = (result_of(outcome, change.target) for outcome in (change.before, change.after))
    if before is None or after is None:
        return True
    error = mean_square_error(after.calibration.fit)
    for share, each in beside:
        other = result_of(each.after, each.target)
        if other is not None:
            error += share * mean_square_apart(after.calibration, other.calibration)
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
    named = next_change(alone, run, refused)
    change = named[0] if named else change_for_unknown(alone, run, refused)
    return after if change is not None and not is_noise(change) else None
