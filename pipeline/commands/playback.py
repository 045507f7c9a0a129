"""``pipeline playback CONFIG``."""

from pathlib import Path

import click

from pipeline.playback import PROTOCOLS, Protocol


@click.command()
@click.argument("config", type=click.Path(path_type=Path))
@click.option("--protocol", type=click.Choice(PROTOCOLS), default="sketch",
              show_default=True, help="What the device speaks.")
@click.option("--hold", default=15.0, show_default=True, help="Seconds each pose is held.")
@click.option("--speed", default=1.0, show_default=True, help="Times as fast as it was recorded.")
@click.option("--lost", default=0.0, help="Share of samples that get lost on the line.")
@click.option("--flipped", default=0.0, help="Share of samples with a bit flipped.")
@click.option("--garbage", default=0.0, help="Share of samples with garbage before them.")
@click.option("--unplug-every", type=float, help="Seconds after which the cable is pulled.")
@click.option("--link", type=click.Path(path_type=Path), help="A lasting name for the port.")
@click.option("--seed", default=0, help="Of the hand's motion and the faults.")
def command(
    config: Path, protocol: Protocol, hold: float, speed: float, lost: float, flipped: float,
    garbage: float, unplug_every: float | None, link: Path | None, seed: int,
) -> None:
    """Play the recorded poses of CONFIG as if their sensor were on a serial port.

    The port's name is printed; record from it in another terminal, with a configuration of your
    own: `pipeline record my.yaml --port NAME`. The poses come one after another, over and over,
    with a hand's motion in between. Ctrl-C ends it.
    """
    from pipeline.config.load import load_config
    from pipeline.playback.device import Faults, PlaybackDevice
    from pipeline.playback.pseudo_port import PseudoPort
    from pipeline.playback.session import both_specs, played_poses

    loaded = load_config(config)
    poses, rate_hz = played_poses(loaded)
    device = PlaybackDevice(protocol, poses, rate_hz, hold, both_specs(loaded), seed,
                            Faults(lost, flipped, garbage))
    port = PseudoPort(link)
    click.echo(f"{link or port.name}")
    click.echo(f"{len(poses)} poses, {rate_hz:g} samples/s, {protocol}; Ctrl-C ends it", err=True)
    port.play(device, rate_hz * speed, unplug_every)
