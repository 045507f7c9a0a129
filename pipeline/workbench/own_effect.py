"""An effect of the user's own, tried while its expression is typed."""

from dataclasses import replace

from calib.effects.catalogue import BASE
from calib.effects.expression import KNOWN_NAMES, BadExpression, read_expression
from calib.effects.units import coefficient_unit
from calib.effects.user_defined import PARAMETERS, Per, user_effect
from calib.fit.validation.leave_one_out import compare
from calib.poses.imu_log import Triad
from pipeline.config.edit import add_entry, add_item
from pipeline.config.yaml_syntax import yaml_word
from pipeline.config.yaml_text import YamlSource
from pipeline.errors import ConfigError
from pipeline.report.triad.refit_table import judged_effect
from pipeline.report.triad.refitted import Refitted, refitted_json
from pipeline.results.json_values import Json
from pipeline.text.names import nearest_name
from pipeline.workbench.live_refits import OpenSession
from pipeline.workbench.state import Screen

NAME = "own_effect"  #: name of the effect until the user writes it into the configuration


def tried_expression(
    session: OpenSession, screen: Screen, triad: Triad, text: str, per: str
) -> Json:
    """The refit of the screen with an expression as one more effect, and that without it.

    Returns
    -------
    dict
        The figures of both fits, a judgement, the lines of the configuration that define the
        effect; or ``problem`` and ``at``, the character of the expression that it concerns.

    Raises
    ------
    CalibrationError, PipelineError
        The poses do not determine it, or the screen is none of this session.
    """
    kind: Per | None = next((each for each in PARAMETERS if each == per), None)
    if kind is None:
        raise ConfigError(f"'{per}' is none of {', '.join(PARAMETERS)}.")
    try:
        expression = read_expression(text)
    except BadExpression as error:
        return {"problem": f"{error}{nearest_name(error.wrong, error.right)}.",
                "at": _place(text, error)}
    from_poses = session.input_of(screen, triad)
    poses = from_poses.recorded.used
    known = poses.conditions(poses.reading).columns
    for name in expression.columns:
        if name not in known:
            logged = [each for each in known if each.isidentifier() and each not in KNOWN_NAMES]
            return {"problem": f"'{name}' is neither a logged column nor a name"
                               f"{nearest_name(name, (*logged, *KNOWN_NAMES))}. The logs have: "
                               f"{', '.join(logged) or 'none'}; names are "
                               f"{', '.join(KNOWN_NAMES)}.", "at": text.find(name)}
    unit = coefficient_unit(expression, triad)
    effect = user_effect(NAME, expression, kind, unit, triad)
    section = from_poses.section
    tried = replace(from_poses, defined={**from_poses.defined, NAME: effect},
                    section=section.model_copy(update={"model": (*section.model, NAME)}))
    calibration = tried.calibrated(seek_mistakes=False)
    with_it = Refitted(calibration, compare(calibration.fit))
    without = session.refitted(screen, triad)
    judged = judged_effect(NAME, with_it, without)
    return {
        "with": refitted_json(with_it), "without": refitted_json(without),
        "words": "" if judged is None else judged.text(False, True),
        "helps": judged is not None and judged.helps,
        "lines": f"effects:\n  {NAME}: {_definition(text, kind, triad)}",
    }


def with_own_effect(source: YamlSource, effect: Json, triad: Triad) -> YamlSource:
    """The configuration's file with a tried effect, in ``effects`` and in the model.

    Raises
    ------
    ConfigError
        It has an effect of this name, or the expression is none.
    """
    name, text = (str(effect.get(key, "")) for key in ("name", "expression"))
    if ("effects", name) in source.spans:
        raise ConfigError(source.problem(("effects", name), "is there already. Name it otherwise"))
    try:
        defined = _definition(text, str(effect.get("per")), triad)
    except BadExpression as error:
        raise ConfigError(f"{error}.") from error
    return add_item(add_entry(source, "effects", name, defined), (triad,), name, BASE)


def _definition(text: str, per: str, triad: Triad) -> str:
    unit = coefficient_unit(read_expression(text), triad)
    return (f"{{expression: {yaml_word(text)}, per: {yaml_word(per)}, unit: {yaml_word(unit)}, "
            f"triad: {triad}}}")


def _place(text: str, error: BadExpression) -> int:
    """Index from 0 of the character at which an expression cannot be read."""
    if isinstance(error.__cause__, SyntaxError):
        lead = len(text) - len(text.lstrip())
        return lead + (error.__cause__.offset or len(text.strip()) + 1) - 1  # 0: its end
    return max(text.find(error.wrong), 0) if error.wrong else 0
