"""``pipeline record CONFIG``."""

from pathlib import Path

import click


@click.command()
@click.argument("config", type=click.Path(path_type=Path))
@click.option("--port", help="Serial port, instead of record.port.")
@click.option("--baud", type=int, help="Speed of the line, instead of record.baud.")
@click.option("--camera", type=int, help="Film the poses on the turning plate with this camera.")
def command(config: Path, port: str | None, baud: int | None, camera: int | None) -> None:
    """Record the poses of CONFIG live, led through them one by one.

    Poses are written as they are taken; interrupt at any time and type the same command to go on.
    Every byte of the line is kept beside them. Without a sensor: `pipeline playback --help`.
    """
    from pipeline.config.load import load_config
    from pipeline.record.start import open_session

    loaded = load_config(config, files_may_be_missing=True)
    from pipeline.commands.recording_display import watcher

    display = watcher()
    try:
        done = open_session(loaded, display, port=port, baud=baud, camera=camera).run()
    except KeyboardInterrupt:
        display.say(f"Stopped. What is taken is kept; go on with: pipeline record {config}")
        raise
    finally:
        display.close()
    for block in done:
        click.echo(f"{block.rate}: {block.recorded} of {block.wanted} poses")
    click.echo(f"next: pipeline plan {config}, then pipeline run {config}")
