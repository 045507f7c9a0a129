"""``pipeline paper [TABLE...]``."""

from collections.abc import Callable, Iterator
from pathlib import Path

import click

TABLES = ("table1", "table2", "table3", "mounting", "errata")


def _lines_of(table: str) -> Callable[[], Iterator[str]]:
    """The study behind a table, imported only when it is asked for."""
    if table == "table1":
        from pipeline.paper_table1 import table_1_lines

        return table_1_lines
    if table == "table2":
        from pipeline.paper_table2 import table_2_lines

        return table_2_lines
    if table == "table3":
        from pipeline.paper_table3 import table_3_lines

        return table_3_lines
    if table == "mounting":
        from pipeline.paper_mounting import mounting_lines

        return mounting_lines
    from pipeline.paper_errata import errata_lines

    return errata_lines


@click.command()
@click.argument("tables", nargs=-1, type=click.Choice(TABLES), metavar="[TABLE]...")
@click.option("--output", type=click.Path(path_type=Path, file_okay=False),
              help="Write figures 4 to 6 as PNG files into this folder.")
def command(tables: tuple[str, ...], output: Path | None) -> None:
    """Repeat the published experiments and print them beside the published numbers.

    TABLE is table1, table2, table3 (Angrisano et al.), mounting (Promrit et al.) or errata (of
    both); without any, all of them. Simulated sessions, from fixed seeds.
    """
    for i, table in enumerate(tables or TABLES):
        if i:
            click.echo()
        for line in _lines_of(table)():
            click.echo(line)
    if output is None:
        return
    from pipeline.figures_paper import paper_figures
    from pipeline.files import write_whole

    click.echo()
    for figure in paper_figures():
        path = output / f"{figure.stem}.png"
        write_whole(path, figure.png())
        click.echo(f"{path}: {figure.title}: {figure.ended}")
