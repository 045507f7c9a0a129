"""``pipeline export RESULTS --to FORMAT``."""

from pathlib import Path

import click

from pipeline.export.formats import FORMATS

#: The list under the command's help; \b keeps its lines.
LISTED = "\b\nFormats:\n" + "\n".join(f"  {name:<8}  {says}" for name, says in FORMATS.items())


@click.command(epilog=LISTED)
@click.argument("results", type=click.Path(path_type=Path))
@click.option("--to", "form", required=True, metavar="FORMAT",
              help="Program or format, one of the list below.")
@click.option("--output", type=click.Path(path_type=Path, file_okay=False),
              help="Folder for the files, instead of that of RESULTS.")
@click.option("--force", is_flag=True, help="Replace files that no command wrote.")
@click.option("--allow-python", is_flag=True,
              help="Let Python files of user-defined effects run.")
def command(
    results: Path, form: str, output: Path | None, force: bool, allow_python: bool
) -> None:
    """Write the calibration in RESULTS (results.json, or its folder) for another program."""
    from pipeline.export.write import EXPORTERS
    from pipeline.names import nearest_name
    from pipeline.results.read import load_results
    from pipeline.results.written import write_output

    if form not in EXPORTERS:
        raise click.UsageError(
            f"no format is named '{form}'{nearest_name(form, EXPORTERS)}; there are: "
            f"{', '.join(EXPORTERS)}"
        )
    stored = load_results(results, allow_python)
    made = EXPORTERS[form](stored)
    for says in made.loses:
        click.secho(f"note: {says}", fg="yellow", err=True)
    for name, text in made.files.items():
        path = (output or stored.folder) / name
        write_output(stored.folder, path, text, force=force, inputs=(stored.path,))
        click.echo(path)
