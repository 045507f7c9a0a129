"""``pipeline discover CONFIG``."""

import time
from pathlib import Path

import click

from pipeline.commands import examples, paragraph
from pipeline.commands.interaction.arguments import ConfigArgument
from pipeline.commands.interaction.output import python_option


@click.command(epilog=examples(
    "pipeline discover config.yaml",
    "pipeline discover config.yaml --write",
))
@click.argument("config", type=ConfigArgument())
@click.option("--write", is_flag=True,
              help="Write the formulas under `effects:` of CONFIG, for `pipeline add`.")
@python_option
def command(config: Path, write: bool, allow_python: bool) -> None:
    """Look for a formula of an error that no listed effect describes.

    Thousands of formulas are tried in every triad whose poses show a misfit: bias, gain, an error
    in proportion to the size, the square or the cube of the reading, the sensitivity to gravity and
    the memory of the pose before, each as a function of every logged column and of time: powers,
    bends, steps, bumps, waves, lags, play, products and quotients of two; and a dead band, a
    saturation, a bend and a wave of each axis. One is printed only if it predicts poses that took
    no part in its fit; where a listed effect predicts them as well, that effect is named instead.
    """
    from calib.diagnosis.verdict.decision import Code
    from calib.discovery.together import discover_each
    from pipeline.commands.interaction.run_with_progress import run_shown, say_waiting
    from pipeline.config.edit import add_entry
    from pipeline.config.load import config_from
    from pipeline.console.discovery_text import answer_lines
    from pipeline.console.next_step import next_line
    from pipeline.next_change import definition, effect_key, without_formula
    from pipeline.report.page import outputs_of
    from pipeline.session_folder import working_on, write_session
    from pipeline.text.names import command as typed

    with working_on(config, on_wait=say_waiting) as (session, folder):
        outcome = run_shown(session, folder, allow_python)
        changed = session
        listed: list[str] = []
        following: list[str] = []
        sought = [result for result in outcome.triads
                  if result.diagnosis.verdict is not Code.NOTHING_MISSING]
        begun = time.monotonic()
        formulas = discover_each([result.calibration.fit for result in sought], session.covariates)
        if sought:
            click.echo(f"formulas tried in {time.monotonic() - begun:.1f} s", err=True)
        for result in outcome.triads:
            if result not in sought:
                click.echo(f"{result.triad}: nothing is missing, and no formula is sought.")
        for result, formula in zip(sought, formulas, strict=True):
            sentence, *lines = answer_lines(result, formula)
            click.echo("\n".join([paragraph(sentence), *lines]))
            if formula is None:
                instead = without_formula(result)
                listed += [] if instead is None else [f"{result.triad}.{instead}"]
                continue
            if formula.listed is not None:
                listed.append(f"{result.triad}.{formula.listed}")
                continue
            name = effect_key(result.triad, formula, changed.effects)
            if write and name not in changed.effects:
                changed = config_from(add_entry(
                    changed.source, "effects", name, definition(result.triad, formula)))
            following.append(f"{result.triad}.{name}")
        if changed is not session:
            write_session(folder, outputs_of(outcome, folder), session, changed.source.text)
            click.echo(f"{config} was changed: `effects:` has the formula.")
    if following and not write and any(
            each.partition(".")[2] not in session.effects for each in following):
        click.echo(f"next: {typed('discover', config, '--write')}")
    elif following or listed:
        click.echo(f"next: {typed('add', config, *listed, *following)}")
    elif (line := next_line(outcome, folder)) != f"next: {typed('discover', config)}":
        click.echo(line)
