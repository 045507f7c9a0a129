"""``pipeline export RESULTS --to FORMAT``."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import PathArgument
from pipeline.commands.interaction.output import echo_warnings, named_results, python_option
from pipeline.export.formats import FORMATS

if TYPE_CHECKING:
    from pipeline.export.parts import Export
    from pipeline.results.read import Stored

#: The list under the command's help; \b keeps its lines.
LISTED = "\b\nFormats:\n" + "\n".join(f"  {name:<11}  {holds}" for name, holds in FORMATS.items())
EXAMPLES = (
    "pipeline export config.run --to kalibr",
    "pipeline export config.run --to csv --output out",
    "pipeline export config.run --to kalibr --noise still.noise",
)


@click.command(epilog=f"{LISTED}\n\n{examples(*EXAMPLES)}")
@click.argument("results", type=PathArgument())
@click.option("--to", "form", required=True, metavar="FORMAT",
              help="One of the formats below.")
@click.option("--output", type=PathArgument(file_okay=False),
              help="Folder for the files; default: that of RESULTS.")
@click.option("--noise", type=PathArgument(),
              help="noise.json of `pipeline noise` (or its folder), for kalibr; default: that "
                   "beside RESULTS.")
@click.option("--force", is_flag=True, help="Replace files that this program did not write.")
@click.option("--anyway", is_flag=True,
              help="Export results whose data do not determine the calibration.")
@python_option
def command(
    results: Path, form: str, output: Path | None, noise: Path | None, force: bool,
    anyway: bool, allow_python: bool,
) -> None:
    """Write the calibration in RESULTS for another program.

    RESULTS is results.json, its folder, or the configuration that was run.
    The command prints what the format cannot store.
    """
    from pipeline.export.parts import of_gravity, stood_for
    from pipeline.export.write import EXPORTERS
    from pipeline.results.fitness import require_fit
    from pipeline.results.inputs import files_of_session
    from pipeline.results.written import write_output
    from pipeline.text.names import nearest_name

    if form not in EXPORTERS:
        raise click.UsageError(
            f"no format is named '{form}'{nearest_name(form, EXPORTERS)}; there are: "
            f"{', '.join(EXPORTERS)}"
        )
    if noise is not None and form != "kalibr":
        raise click.UsageError(f"--noise is for kalibr; {form} has no place for it")
    stored = named_results(results, allow_python)
    echo_warnings(require_fit(stored, anyway))
    export = _kalibr_with_noise(stored, noise) if form == "kalibr" else EXPORTERS[form](stored)
    echo_warnings((*export.loses, *stood_for(stored), *of_gravity(stored)), "note")
    for name, content in export.files.items():
        path = (output or stored.folder) / name
        write_output(stored.folder, path, content, force=force,
                     inputs=(results, *files_of_session(stored)))
        click.echo(path)


def _kalibr_with_noise(stored: "Stored", noise: Path | None) -> "Export":
    """Kalibr's file with the noise that is named, or stands beside the results."""
    from pipeline.export.robotics import to_kalibr
    from pipeline.results.noise import NOISE_NAME, load_noise

    beside = stored.folder / NOISE_NAME
    path = noise or (beside if beside.exists() else None)
    return to_kalibr(stored, None if path is None else load_noise(path))
