"""The click group behind ``pipeline``: imports a command's module when the command is typed."""

from importlib import import_module

import click

from pipeline.commands import COMMANDS, KEPT, front_page
from pipeline.text.names import nearest_name, program_version
from pipeline.text.tables import WIDEST


class LazyGroup(click.Group):
    """A group whose commands are the table :data:`pipeline.commands.COMMANDS`."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Every command's name, in the order of the table."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of that name, imported now; None for a name not in the table."""
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = import_module(f"pipeline.commands.{cmd_name}").command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command typed; a wrong name is answered with the nearest right one."""
        args = [*KEPT.get(args[0], args[:1]), *args[1:]]
        if args and not args[0].startswith("-") and args[0] not in COMMANDS:
            raise click.UsageError(
                f"no command is named '{args[0]}'{nearest_name(args[0], COMMANDS)}; "
                f"`pipeline --help` lists all commands"
            )
        return super().resolve_command(ctx, args)

    def get_help(self, ctx: click.Context) -> str:
        """The same page as ``pipeline --help`` prints without click."""
        return front_page()


def print_version(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    """Callback of ``--version``."""
    if wanted:
        click.echo(f"pipeline {program_version()}")
        ctx.exit()


@click.group(cls=LazyGroup, context_settings={
    "help_option_names": ["-h", "--help"], "max_content_width": WIDEST})
@click.option("--version", is_flag=True, is_eager=True, expose_value=False,
              callback=print_version, help="Show the version.")
def root() -> None:
    """The group itself does nothing; the commands do."""
