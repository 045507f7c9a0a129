"""``pipeline effects [NAME]``."""

import click

from pipeline.commands import examples


@click.command(epilog=examples("pipeline effects", "pipeline effects g_sensitivity"))
@click.argument("name", required=False)
def command(name: str | None) -> None:
    """List all effects, or print the page of one effect.

    A page states the physics, the formula, the typical size, the effects that it is confused with,
    and the measurement that separates them.
    """
    from pipeline.console.effect_pages import WIDTH, catalogue_lines, page_lines
    from pipeline.text.tables import prose_width

    for line in catalogue_lines() if name is None else page_lines(name, prose_width() or WIDTH):
        click.echo(line)
