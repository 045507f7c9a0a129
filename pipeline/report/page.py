"""Everything a run leaves in its folder; report.html is one file that needs no network."""

import json
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from pipeline.console.mounting_text import mounting_text
from pipeline.console.run_text import triad_figures
from pipeline.report.added_variable import added_variable_figure
from pipeline.report.axis_charts import axis_charts
from pipeline.report.effect_cards import effect_cards
from pipeline.report.glossary import TERMS, with_terms
from pipeline.report.history_chart import staircase
from pipeline.report.pose_charts import (
    covariate_figures,
    coverage_figure,
    residual_figure,
    run_legend,
)
from pipeline.report.pose_sphere import how_to_exclude, pose_rows, sphere_json
from pipeline.report.rate_charts import rate_view
from pipeline.report.refit_data import constants_json, refit_json
from pipeline.report.summary import Answer, answer_for, overall_verdict
from pipeline.report.tables import budget_rows, parameter_groups
from pipeline.results.history import Step
from pipeline.results.json_values import Json
from pipeline.stages.certificate import compare_with_certificate
from pipeline.stages.run import Outcome
from pipeline.stages.triads import TriadResult
from pipeline.stages.user_effects import user_effects

TEMPLATE_NAME = "report.html"


def report_html(outcome: Outcome, history: Sequence[Step], folder: Path | None = None) -> str:
    """The whole page.

    Parameters
    ----------
    outcome : Outcome
        Result of the run.
    history : sequence of Step
        Every run so far, this one included.
    folder : Path, optional
        Folder of the results, for the commands on the page; by default that of the configuration.
    """
    environment = Environment(
        loader=PackageLoader("pipeline.report", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["terms"] = with_terms
    drawings = tuple(environment.get_template("drawings.html").module.__dict__)
    where = str(folder or outcome.config.output_folder)
    config = shlex.quote(str(outcome.config.source.path))
    rates = [rate_view(rate, config) for rate in outcome.rates.values()]
    answers = [answer_for(result, outcome, where) for result in outcome.triads]
    views = [
        _triad_view(outcome, result, answer, history, drawings)
        for result, answer in zip(outcome.triads, answers, strict=True)
    ]
    return environment.get_template(TEMPLATE_NAME).render(
        title=outcome.config.title or outcome.config.source.path.stem,
        sensor=outcome.config.sensor.name,
        config=str(outcome.config.source.path),
        verdict=overall_verdict(answers, rates),
        rates=rates,
        glossary=TERMS,
        triads=views,
        warnings=outcome.warnings,
        installation=_installation_view(outcome),
        payload=_script_json({
            "config": config,
            "constants": constants_json(),
            "triads": [view["payload"] for view in views],
        }),
    )


def _triad_view(
    outcome: Outcome, result: TriadResult, answer: Answer, history: Sequence[Step],
    drawings: Sequence[str],
) -> dict[str, Any]:
    """What the page shows of one triad."""
    # Python code among them has run before in this run, or there would be no outcome.
    defined = user_effects(outcome.config, result.triad, allow_python=True)
    payload = refit_json(result, defined) | {"poses": sphere_json(outcome, result)}
    certificate = compare_with_certificate(outcome.config, result)
    calibration = result.calibration
    return {
        "name": result.triad,
        "answer": answer,
        "line": triad_figures(result),
        "text": result.diagnosis.text,
        "model": ", ".join(calibration.fit.model.names),
        "groups": parameter_groups(result, certificate),
        "certified": certificate is not None,
        "budget": budget_rows(result),
        "widening": calibration.widening,
        "gravity": result.gravity,
        "payload": payload,
        "effects": payload["effects"],
        "cards": effect_cards(result, payload, defined, drawings),
        "residual": residual_figure(result),
        "legend": run_legend(result),
        "axes": axis_charts(result),
        "covariates": tuple(covariate_figures(result)),
        "coverage": coverage_figure(result),
        "pose_rows": pose_rows(result),
        "exclude": how_to_exclude(outcome, result),
        "added": added_variable_figure(result, payload),
        "staircase": staircase(result.triad, history),
    }


def _installation_view(outcome: Outcome) -> dict[str, Any] | None:
    """What the page shows of the mounting; None if it was not measured."""
    mounting = outcome.installation
    if mounting is None:
        return None
    return {
        "text": mounting_text(mounting),
        "before": mounting.before.tolist(),
        "after": mounting.after.tolist(),
        "notes": mounting.notes,
    }


def _script_json(payload: Json) -> str:
    """JSON that can stand inside a script element: no text in it ends the element."""
    text = json.dumps(payload, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return text.replace("<", "\\u003c")
