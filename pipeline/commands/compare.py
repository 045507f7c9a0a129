"""``pipeline compare A B [C...]``."""

import math
from collections.abc import Sequence
from pathlib import Path

import click

from pipeline.commands import examples, paragraph
from pipeline.commands.interaction.arguments import PathArgument
from pipeline.commands.interaction.output import (
    echo_json,
    json_option,
    named_results,
    python_option,
)
from pipeline.results.names import RESULTS_NAME


@click.command(epilog=examples(
    "pipeline compare monday.yaml tuesday.yaml",
    "pipeline compare 2025-*/config.yaml --limit accelerometer=20",
    "pipeline compare base.run cubic.run --json | jq '.gyroscope.error_on_poses'",
))
@click.argument("sessions", nargs=-1, required=True, metavar="A B [C...]", type=PathArgument())
@click.option("--limit", "limits", multiple=True, metavar="TRIAD=VALUE",
              help="Error that corrected magnitudes may have, in mm/s² or °/s, as in "
                   "accelerometer=20: when it will be passed. Default: twice the last one's.")
@python_option
@json_option("the comparison")
def command(
    sessions: tuple[Path, ...], limits: tuple[str, ...], allow_python: bool, as_json: bool
) -> None:
    """Compare calibrations of one sensor: sessions, or runs of one session with different models.

    A, B and more are configurations that were run, results.json or their folders. The command
    prints the parameters side by side, each with its distance from A in sds, and what every
    calibration errs by on the poses of each session. Of sessions on different days it prints what
    moved, and when the sensor should be calibrated again.
    """
    from pipeline.console.comparison_text import ageing_text, comparison_lines, conclusions
    from pipeline.results.ageing import ageing_of, recorded_at
    from pipeline.results.comparison import compare_calibrations, comparison_json

    if len(sessions) < 2:
        raise click.UsageError(f"only {sessions[0]} was named; name two sessions or more.")
    results = [named_results(path, allow_python) for path in sessions]
    compared = compare_calibrations(results)
    allowed = dict(map(_limit, limits))
    times = [recorded_at(stored) for stored in results]
    ageing = {one.triad: ageing_of(one, times, allowed.get(one.triad)) for one in compared}
    if as_json:
        echo_json(comparison_json(results, compared, ageing))
        return
    if not compared:
        raise click.UsageError("no triad was calibrated in two of these sessions.")
    names = _names(sessions)
    for triad in compared:
        click.echo("\n".join(comparison_lines(triad, names)))
        click.echo()
    for triad in compared:
        for line in conclusions(triad, names):
            click.echo(paragraph(line))
    for one in compared:
        if (seen := ageing[one.triad]) is not None:
            click.echo(paragraph(f"{one.triad}: {ageing_text(seen, one.triad)}"))
        elif one.triad in allowed:
            click.echo(paragraph(
                f"{one.triad}: when it passes the limit is not known. That takes two sessions of "
                f"one model and one data sheet, of other poses, half a day apart or more."))


def _limit(text: str) -> tuple[str, float]:
    """``accelerometer=20`` as the triad and its limit, SI."""
    from calib.poses.imu_log import TRIADS
    from pipeline.text.formatting import DISPLAY

    triad, _, value = text.partition("=")
    try:
        limit = float(value)
    except ValueError:
        limit = 0.0
    if triad not in TRIADS or not 0 < limit < math.inf:
        raise click.BadParameter(
            f"found '{text}', expected a triad and a positive number, as in accelerometer=20 "
            f"(mm/s²) or gyroscope=0.1 (°/s).", param_hint="--limit")
    return triad, limit / DISPLAY[triad][1]


def _names(sessions: Sequence[Path]) -> list[str]:
    """Distinct names of the sessions: their paths without common beginnings and endings."""
    folders = [path.parent if path.name == RESULTS_NAME else path for path in sessions]
    parts = [list(folder.absolute().with_suffix("").parts) for folder in folders]
    for end in (0, -1):
        while all(len(path) > 1 for path in parts) and len({path[end] for path in parts}) == 1:
            for path in parts:
                del path[end]
    names = ["/".join(path) for path in parts]
    return names if len(set(names)) == len(names) else [str(path) for path in sessions]
