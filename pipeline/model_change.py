"""A model change: one effect is added to the configuration or removed from it, and refitted.

A change ends in one of two ways. The configuration names one effect more (or fewer), and the
calibrations before and after are both known; or the change is refused with its reason and the
measurement that would allow it, and the file is not changed.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.next_measurement.advice import settling_block
from calib.diagnosis.next_measurement.chance import Rival, chance_of_a_name
from calib.effects.catalogue import BASE, EFFECTS, find_effect
from calib.effects.effect import OF_COLUMN
from calib.errors import CalibrationError, Undetermined
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.config.edit import add_item, remove_item
from pipeline.config.load import Config, config_from
from pipeline.config.yaml_text import PathTo
from pipeline.errors import ConfigError
from pipeline.stages.run import Outcome
from pipeline.stages.triads import TriadResult
from pipeline.text.formatting import DISPLAY
from pipeline.text.names import nearest_names

ALL_THE_SAME = "To add it all the same, for its upper limit or to compare, add --anyway."
RunConfig = Callable[[Config], Outcome]
CONSTANT_RATE = ("constant_rate",)


@dataclass(frozen=True)
class Target:
    """Place to which an effect is added: a triad, or a plate setting's phase track."""

    section: PathTo
    name: str

    @property
    def default(self) -> tuple[str, ...]:
        """The model where the configuration states none."""
        return CONSTANT_RATE if self.section[0] == "rate" else BASE

    def __str__(self) -> str:
        return ".".join([*map(str, self.section), self.name])


@dataclass(frozen=True, eq=False)
class ModelChange:
    """The added or removed effect, and the outcomes before and after."""

    target: Target
    before: Outcome
    after: Outcome


def read_target(config: Config, text: str) -> Target:
    """``TRIAD.NAME`` as in ``accelerometer.quadratic``, or ``rate.SETTING.TERM``.

    Raises
    ------
    ConfigError
        It names nothing that this configuration has.
    """
    head, _, rest = text.partition(".")
    if head in TRIAD_KINDS and rest:
        if head not in config.triads:
            raise ConfigError(
                f"{text}: {config.source.path} has no section '{head}', so there is no model to "
                f"change. It calibrates {' and '.join(config.triads)}. Write the section "
                f"first, with the poses or runs that were measured; `pipeline init` writes an "
                f"example."
            )
        return Target((head,), rest)
    setting, _, term = rest.rpartition(".")
    if head == "rate" and setting in config.rate and term:
        return Target(("rate", setting), term)
    raise ConfigError(
        f"{text}: names nothing that an effect can be added to{_meant(config, text)}. Write "
        f"accelerometer.NAME, gyroscope.NAME, or rate.SETTING.TERM, as `pipeline diagnose` names "
        f"them."
    )


def _meant(config: Config, text: str) -> str:
    """A target that ``text`` may mean, in brackets; empty where none is near."""
    head, _, rest = text.partition(".")
    setting, _, term = rest.rpartition(".")
    if head == "rate":
        near = nearest_names(setting or rest, config.rate)
        return f" (did you mean 'rate.{near[0]}.{term or 'TERM'}'?)" if near else ""
    if rest and (triad := nearest_names(head, config.triads)):
        name = next(iter(nearest_names(rest, (*EFFECTS, *config.effects))), rest)
        return f" (did you mean '{triad[0]}.{name}'?)"
    name = text if text.startswith(OF_COLUMN) else next(
        iter(nearest_names(text, (*EFFECTS, *config.effects))), "")
    if not name:
        return ""
    triads = TRIAD_KINDS if name in config.effects else find_effect(name).triads
    targets = [f"'{triad}.{name}'" for triad in triads if triad in config.triads]
    return f" (did you mean {' or '.join(targets)}?)" if targets else ""


def result_of(outcome: Outcome, target: Target) -> TriadResult | None:
    """The triad of ``target``; None for a plate setting."""
    return next((r for r in outcome.triads if (r.triad,) == target.section), None)


def edited_config(config: Config, target: Target, remove: bool, remark: str = "") -> Config:
    """``config`` with ``target`` added or removed, checked whole; nothing is written yet.

    An added effect has ``remark`` as a comment beside it, and replaces those that it contains.
    """
    model = _model(config, target)
    if remove and target.name not in model:
        listed = ", ".join(model)
        raise ConfigError(f"{target}: is not in the model, which is [{listed}].")
    if remove and len(model) == 1:
        raise ConfigError(f"{target}: is all that the model has; a model needs one effect.")
    if not remove and target.name in model:
        raise ConfigError(f"{target}: is in the model already.")
    source, whole = config.source, EFFECTS.get(target.name)
    if remove:
        return config_from(remove_item(source, target.section, target.name))
    for name in model:
        if whole is not None and name in whole.contains:
            source = remove_item(source, target.section, name)
    return config_from(add_item(source, target.section, target.name, target.default, remark))


def _model(config: Config, target: Target) -> tuple[str, ...]:
    if target.section[0] == "rate":
        return tuple(getattr(config.rate[str(target.section[1])], "model", CONSTANT_RATE))
    return tuple(getattr(config, str(target.section[0])).model)


def change_model(
    config: Config,
    target: Target,
    run: RunConfig,
    *,
    before: Outcome | None = None,
    remove: bool = False,
    anyway: bool = False,
    remark: str = "",
) -> ModelChange:
    """Change the model by ``target`` and run; nothing is written yet, ``remark`` beside it.

    Raises
    ------
    ConfigError, Undetermined
        The change is refused.
    """
    changed = edited_config(config, target, remove, remark)
    before = before or run(config)
    result = result_of(before, target)
    if result is not None and not remove:
        require_addable(result, target, anyway)
    change = ModelChange(target, before, run(changed))
    if not (remove or anyway):
        _require_seen(change)
    return change


def require_addable(result: TriadResult, target: Target, anyway: bool = False) -> None:
    """Refuse an effect that these data cannot determine, or cannot separate from another.

    ``anyway`` allows effects that they do not show or cannot separate, not those they cannot see.

    Raises
    ------
    Undetermined
        With the reason, and the measurement that would allow it.
    """
    diagnosis, name = result.diagnosis, target.name
    if name in diagnosis.unavailable:
        raise Undetermined(f"{target}: cannot be evaluated here: {diagnosis.unavailable[name]}.")
    if name in diagnosis.blind:
        raise Undetermined(
            f"{target}: these data cannot see it; bias, scale, misalignment and the effects in "
            f"the model take up all of it. {_next_measurement(result, [name])}"
        )
    # An effect that a verdict names can be added; `note_on` lists its alternatives.
    if anyway or not diagnosis.is_guess(name):
        return
    candidate = diagnosis.listed[name]
    if candidate.aliases:
        raise Undetermined(
            f"{target}: looks the same as {_quoted(candidate.aliases)} in these data; adding it "
            f"would be a guess. {_next_measurement(result, [name, *candidate.aliases])} To go on "
            f"with '{name}' all the same, add --anyway."
        )
    raise Undetermined(
        f"{target}: these data do not show it: the odds are "
        f"{np.exp(-candidate.log_evidence):.2g} : 1 against it. {ALL_THE_SAME}"
    )


def overruled(change: ModelChange) -> str:
    """Reason for which the effect would have been refused; empty if there is none."""
    before = result_of(change.before, change.target)
    try:
        if before is not None:
            require_addable(before, change.target)
        _require_seen(change)
    except Undetermined as refused:
        return str(refused).partition(" To go on with")[0].partition(f" {ALL_THE_SAME}")[0]
    return ""


def note_on(change: ModelChange) -> str:
    """Alternatives to an added effect of a named class; empty if there are none."""
    before, name = result_of(change.before, change.target), change.target.name
    if before is None:
        return ""
    others = [other for other in before.diagnosis.named_class(name) if other != name]
    if not others:
        return ""
    return (
        f"{change.target} looks the same as {_quoted(others)} in these poses: the correction is "
        f"valid under the conditions of this session. "
        f"{_next_measurement(before, [name, *others], 'What separates them')}"
    )


def _quoted(names: Collection[str]) -> str:
    return " and ".join(f"'{name}'" for name in names)


def _require_seen(change: ModelChange) -> None:
    """Refuse an effect that does not improve the prediction of left-out poses.

    Effects that a verdict names, and drawn effects, which predict no pose, are exempt.

    Raises
    ------
    Undetermined
        With both errors.
    """
    target = change.target
    results = [result_of(outcome, target) for outcome in (change.before, change.after)]
    if results[0] is None or results[1] is None:
        return
    before, after = results[0], results[1]
    effects = after.calibration.fit.model.effects
    effect = next(each for each in effects if each.name == target.name)
    if effect.drawn or before.diagnosis.named_class(target.name) or (
            after.comparison.predicts_better_than(before.comparison)):
        return
    unit, factor = DISPLAY[before.triad]
    error, error_before = (f"{each.comparison.loo_rms * factor:.3g} {unit}"
                           for each in (after, before))
    raise Undetermined(
        f"{target}: poses that take no part in the fit are predicted no better with it: the "
        f"leave-one-out error would be {error} and is {error_before}. {ALL_THE_SAME}"
    )


def _next_measurement(
    result: TriadResult, names: list[str], title: str = "What would allow it"
) -> str:
    """The measurement that would make ``names`` visible or separate them."""
    try:
        effects = [find_effect(name) for name in names]
    except CalibrationError:  # a user-defined effect has no page
        return "Record poses in which its columns change while everything else stays."
    listed = result.diagnosis.listed
    rivals = [Rival(effect, listed[effect.name].size if effect.name in listed else None)
              for effect in effects]
    advice = settling_block(
        result.calibration.fit, lambda then: chance_of_a_name(then, rivals),
        result.calibration.spec.full_scale,
    )
    if advice is not None and advice.is_worth_it:
        return f"{title}: record {advice.timed}."
    return f"{title}: {effects[0].page.separates}."
