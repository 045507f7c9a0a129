"""Files that a run leaves in its folder; report.html is one file that needs no network."""

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

from calib.diagnosis.verdict.decision import Code
from calib.rounding import two_digits
from pipeline.console.answers import RATES, Answer, answers_of, headline
from pipeline.console.run_text import limit_rows, triad_figures
from pipeline.report.mounting_view import mounting_view
from pipeline.report.page_templates import TERMS, page_templates, script_json
from pipeline.report.plate.rate_charts import rate_view
from pipeline.report.triad.axis_charts import axis_charts, lead_panel
from pipeline.report.triad.charts import residual_figure, run_legend, staircase
from pipeline.report.triad.effect_cards import effect_cards
from pipeline.report.triad.pose_sphere import excluded_rows, pose_rows, sphere_json
from pipeline.report.triad.refit_table import CONSTANTS, refit_json
from pipeline.report.triad.refitted import Refits
from pipeline.report.triad.tables import RANKED, budget_rows, candidate_rows, parameter_groups
from pipeline.results.history import HISTORY_NAME, history_text, read_history, with_step
from pipeline.results.names import REPORT_NAME, RESULTS_NAME
from pipeline.results.schema.noise import HistoryLine
from pipeline.results.write import config_sha256, results_of, results_text
from pipeline.stages.run import Outcome
from pipeline.stages.triads import TriadResult
from pipeline.text.names import program_version, word

TEMPLATE_NAME = "report.html"
HASH_DIGITS = 12  #: digits of the configuration's SHA-256 in the head of the page


def report_html(
    outcome: Outcome, history: Sequence[HistoryLine], folder: Path | None = None,
    when: datetime | None = None,
) -> str:
    """The whole page.

    Parameters
    ----------
    outcome : Outcome
        Result of the run.
    history : sequence of Step
        Every run so far, this one included.
    folder : Path, optional
        Folder of the results, for the commands on the page; by default that of the configuration.
    when : datetime, optional
        Local time of the run, for the head of the page. Nothing else on the page depends on it.
    """
    environment = page_templates()
    drawings = tuple(environment.get_template("drawings.html").module.__dict__)
    where = str(folder or outcome.config.output_folder)
    config = outcome.config.source.path
    clocks = outcome.recordings.clocks
    rates = [rate_view(rate, clocks.get(name)) for name, rate in outcome.rates.items()]
    # In the order of the headline, which lists the triads first.
    answers = sorted(answers_of(outcome, where), key=lambda answer: answer.subject == RATES)
    views: dict[str, dict[str, Any]] = {
        result.triad: _triad_view(outcome, result, history, drawings)
        for result in outcome.triads}
    order = [answer.subject for answer in answers if answer.subject != RATES]
    return environment.get_template(TEMPLATE_NAME).render(
        title=outcome.config.title or outcome.config.source.path.stem,
        title_css=css_text(outcome.config.title or outcome.config.source.path.stem),
        head=head_lines(outcome, Path(where), when),
        verdict=headline(answers),
        answers=[_answer_view(answer, views) for answer in answers],
        rates=rates,
        glossary=TERMS,
        ranked=RANKED,
        triads=[views[triad] for triad in order],
        warnings=outcome.warnings,
        installation=mounting_view(outcome.installation),
        payload=script_json({
            "config": word(config),
            "made_in": Path(where).absolute().as_uri(),
            "constants": CONSTANTS,
            "triads": [views[triad]["payload"] for triad in order],
            "rates": [rate.terms for rate in rates if rate.terms],
        }),
    )


def head_lines(
    outcome: Outcome, folder: Path, when: datetime | None
) -> tuple[tuple[str, str], ...]:
    """Identification of the page, which is in ``folder``: names and values."""
    is_relative = not outcome.config.source.path.is_absolute()
    typed = f"; its commands are typed in {Path.cwd()}" if is_relative else ""
    lines = [("sensor", outcome.config.sensor.name)]
    if when is not None:
        lines.append(("calibrated", f"{when:%Y-%m-%d %H:%M}"))
    lines += [
        ("configuration", str(outcome.config.source.path)),
        ("SHA-256", config_sha256(outcome)[:HASH_DIGITS]),
        ("program", f"pipeline {program_version()}"),
        ("made in", f"{folder.absolute()}{typed}"),
    ]
    return tuple((name, value) for name, value in lines if value)


def css_text(text: str) -> str:
    """``text`` inside a CSS string: all but letters and digits as escapes.

    >>> css_text('a"b')
    'a\\\\22 b'
    """
    return "".join(c if c.isalnum() and c.isascii() else f"\\{ord(c):x} " for c in text)


def _answer_view(answer: Answer, views: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """An answer with its figure: the influence of the missing effect, or the residuals."""
    view = views.get(answer.subject)
    figure = view and answer.standing != "good" and (view["lead"] or view["residual"])
    return {"of": answer, "figure": figure or None, "effect": view and view["lead_effect"],
            "anchor": answer.subject if view else "rates"}


def _triad_view(
    outcome: Outcome, result: TriadResult, history: Sequence[HistoryLine], drawings: Sequence[str]
) -> dict[str, Any]:
    """Contents of the page on one triad."""
    refits = Refits(result)
    payload = refit_json(refits, outcome.config.source.path) | {
        "poses": sphere_json(outcome, result)}
    calibration = result.calibration
    axes = axis_charts(refits)
    lead, lead_effect = lead_panel(result, axes)
    return {
        "name": result.triad,
        "is_good": result.diagnosis.verdict is Code.NOTHING_MISSING,
        "line": triad_figures(result),
        "text": result.diagnosis.text,
        "model": ", ".join(calibration.fit.model.names),
        "groups": tuple(parameter_groups(result)),
        "certified": result.certificate is not None,
        "budget": budget_rows(result),
        "unseen": tuple(result.unseen),
        "widening": two_digits(calibration.widening) if calibration.is_widened else None,
        "gravity": result.gravity,
        "payload": payload,
        "effects": payload["effects"],
        "cards": effect_cards(refits, payload["effects"], drawings),
        "residual": residual_figure(result),
        "legend": run_legend(result),
        "axes": axes,
        "lead": lead,
        "lead_effect": lead_effect,
        "pose_rows": pose_rows(result),
        "excluded_rows": excluded_rows(result),
        "staircase": staircase(result.triad, history),
        "candidates": candidate_rows(result),
        "limits": limit_rows(result),
        "blind": result.undetermined,
    }


def outputs_of(outcome: Outcome, folder: Path) -> dict[str, str]:
    """Results, history and report by their names in ``folder``, which contains the history so far.

    Raises
    ------
    UnreadableInput
        The history there is damaged.
    """
    results = results_of(outcome)
    history, now = read_history(folder), datetime.now().astimezone()
    if outcome.triads:
        history = with_step(history, results, now)
    texts = {RESULTS_NAME: results_text(results)}
    if outcome.triads:
        texts[HISTORY_NAME] = history_text(history)
    return texts | {REPORT_NAME: report_html(outcome, history, folder, now)}
