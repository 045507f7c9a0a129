"""Repeat the published experiments and print them beside the published numbers.

Run: python -m tests.studies.angrisano [TABLE...] [--output DIR]

TABLE is table1, table2, table3 (Angrisano et al.), mounting (Promrit et al.) or errata (of both);
without any, all of them. The sessions are simulated, from fixed seeds.
"""

from pathlib import Path

import click

from pipeline.files import write_whole
from tests.studies.angrisano.errata import errata_lines
from tests.studies.angrisano.figures import paper_figures
from tests.studies.angrisano.mounting import mounting_lines
from tests.studies.angrisano.table1 import table_1_lines
from tests.studies.angrisano.table2 import table_2_lines
from tests.studies.angrisano.table3 import table_3_lines

TABLES = {
    "table1": table_1_lines,
    "table2": table_2_lines,
    "table3": table_3_lines,
    "mounting": mounting_lines,
    "errata": errata_lines,
}


@click.command(help=__doc__)
@click.argument("tables", nargs=-1, type=click.Choice(tuple(TABLES)), metavar="[TABLE]...")
@click.option("--output", type=click.Path(path_type=Path, file_okay=False),
              help="Write figures 4 to 6 as PNG files into this folder.")
def command(tables: tuple[str, ...], output: Path | None) -> None:
    """Print the tables; draw the figures where a folder is given."""
    for i, table in enumerate(tables or TABLES):
        if i:
            click.echo()
        for line in TABLES[table]():
            click.echo(line)
    if output is None:
        return
    click.echo()
    for figure in paper_figures():
        path = output / f"{figure.stem}.png"
        write_whole(path, figure.png())
        click.echo(f"{path}: {figure.title}: {figure.ended}")


if __name__ == "__main__":
    command()
