"""``pipeline diagnose CONFIG``."""

from pathlib import Path

import click

from pipeline.commands import examples, paragraph
from pipeline.commands.interaction.arguments import ConfigArgument
from pipeline.commands.interaction.output import (
    echo_verdict,
    echo_whole,
    json_option,
    python_option,
    quiet_option,
    say,
)


@click.command(epilog=examples(
    "pipeline diagnose config.yaml",
    "pipeline diagnose config.yaml --json | jq .gyroscope.diagnosis.ranking",
))
@click.argument("config", type=ConfigArgument())
@python_option
@json_option("the results")
@quiet_option("the verdicts and the next command")
def command(config: Path, allow_python: bool, as_json: bool, quiet: bool) -> None:
    """Print what the model in CONFIG misses, how certain that is, and the next command to type.

    The command runs every stage and does not change the results or the history. Where no listed
    effect fits, it looks for a formula as `pipeline discover` does.
    """
    from calib.discovery.together import discover_each
    from pipeline.commands.interaction.run_with_progress import run_shown, say_waiting
    from pipeline.console.discovery_text import answer_lines
    from pipeline.console.next_step import next_line
    from pipeline.console.rate_text import verdict_lines
    from pipeline.console.run_text import misfit_lines, ranking_lines
    from pipeline.next_change import without_formula
    from pipeline.results.write import results_of, results_text
    from pipeline.session_folder import working_on
    from pipeline.text.names import command as typed

    with working_on(config, on_wait=say_waiting, replaces=None) as (session, folder):
        outcome = run_shown(session, folder, allow_python, lines=not (quiet or as_json),
                            bars=not quiet)
    if as_json:
        echo_whole(results_text(results_of(outcome)))
        return
    if quiet:
        for result in outcome.triads:
            echo_verdict(result)
        click.echo(next_line(outcome, folder))
        return
    instead: list[str] = []
    sought = [each for each in outcome.triads if each.diagnosis.explanation.step == "discover"]
    formulas = iter(discover_each([each.calibration.fit for each in sought], session.covariates))
    for result in outcome.triads:
        click.echo()
        echo_verdict(result)
        click.echo("\n".join([*misfit_lines(result), *ranking_lines(result)]))
        if result in sought:
            formula = next(formulas)
            sentence, *lines = answer_lines(result, formula)
            click.echo("\n".join([paragraph(sentence), *lines]))
            name = without_formula(result)
            if formula is None and name is not None:
                instead.append(f"{result.triad}.{name}")
    for line in verdict_lines(outcome.rates.values()):
        click.echo()
        say(paragraph(line), bold=True)
    click.echo()
    line = next_line(outcome, folder)
    if instead and line == f"next: {typed('discover', config)}":
        line = f"next: {typed('add', config, *instead)}"
    click.echo(line)
