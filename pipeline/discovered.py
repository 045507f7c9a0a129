"""Changes of a session's model for a misfit of no listed shape: a formula, or its size."""

from collections.abc import Collection

from calib.diagnosis.verdict.decision import Code
from calib.discovery.discover import Discovered, discover
from calib.errors import CalibrationError
from pipeline.config.edit import add_effect
from pipeline.config.load import parse_config
from pipeline.config.yaml_syntax import yaml_word
from pipeline.model_change import ModelChange, RunConfig, Target, change_model
from pipeline.stages.run import Outcome
from pipeline.stages.triads import TriadResult


def definition(triad: str, found: Discovered) -> str:
    """The value of the effect's key in a configuration, on one line."""
    formula = found.formula
    return (f"{{expression: {yaml_word(formula.expression)}, per: {formula.per}, "
            f"unit: {yaml_word(formula.effect.unit)}, triad: {triad}}}")


def without_formula(result: TriadResult) -> str | None:
    """The effect that adds an error without a formula to the sds; None where none is searched."""
    diagnosis = result.diagnosis
    name = "bias_wander" if diagnosis.name == "time_s" else "extra_noise"
    if diagnosis.verdict is Code.NOISE:
        name = diagnosis.name or name
    sought = diagnosis.explanation.step == "discover"
    return name if sought and name not in result.calibration.fit.model.names else None


def change_for_unknown(
    outcome: Outcome, run: RunConfig, refused: Collection[Target] = ()
) -> ModelChange | None:
    """The change that ``--auto`` makes where a formula is searched: the result of :func:`discover`.

    If there is no formula, the effect that adds the error to the sds. ``refused`` are effects that
    were tried and did not lower the error.

    Raises
    ------
    ConfigError
        The configuration cannot be read with the formula.
    Undetermined
        A Python function of the model raised.
    """
    for result in outcome.triads:
        if result.diagnosis.explanation.step != "discover":
            continue
        config = outcome.config
        best = discover(result.calibration.fit, config.covariates)
        name = without_formula(result) if best is None else best.listed or best.formula.name
        if name is None or Target((result.triad,), name) in refused:
            continue
        if best is not None and best.listed is None and name not in config.effects:
            text = add_effect(config.source, name, definition(result.triad, best))
            config = parse_config(config.source.path, text)
        try:
            return change_model(
                config, Target((result.triad,), name), run, before=outcome, anyway=True)
        except CalibrationError:
            continue
    return None
