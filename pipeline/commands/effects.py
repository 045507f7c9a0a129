"""``pipeline effects [NAME]``."""

import click


@click.command()
@click.argument("name", required=False)
def command(name: str | None) -> None:
    """List the effects that can be added, or explain one: physics, size, what separates it."""
    from pipeline.console.effect_pages import catalogue_lines, page_lines

    for line in catalogue_lines() if name is None else page_lines(name):
        click.echo(line)
