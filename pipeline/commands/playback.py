"""``pipeline playback CONFIG``."""

from pathlib import Path

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import LONGEST_S, ConfigArgument, Finite, PathArgument
from pipeline.playback import PROTOCOLS, Protocol

SHARE = Finite(min=0, max=1)  #: range by definition


@click.command(epilog=examples(
    "pipeline playback data/example/config.yaml --protocol xsens-mti",
    "pipeline playback config.yaml --lost 0.01 --link /tmp/sensor",
))
@click.argument("config", type=ConfigArgument())
@click.option("--protocol", type=click.Choice(PROTOCOLS), default="sketch",
              show_default=True, help="Protocol of the simulated device.")
@click.option("--hold", type=Finite(min=0.1, max=LONGEST_S), default=15.0, show_default=True,
              help="Duration of each pose in seconds.")
@click.option("--speed", type=Finite(min=0.01, max=1000), default=1.0, show_default=True,
              help="Speed relative to the recording.")
@click.option("--lost", type=SHARE, default=0.0, help="Share of samples that are lost on the line.")
@click.option("--flipped", type=SHARE, default=0.0, help="Share of samples with one inverted bit.")
@click.option("--garbage", type=SHARE, default=0.0,
              help="Share of samples with random bytes before them.")
@click.option("--unplug-every", type=Finite(min=0.1, max=LONGEST_S),
              help="Disconnect the device after this number of seconds, repeatedly.")
@click.option("--link", type=PathArgument(), help="Symbolic link to the port.")
@click.option("--seed", type=click.IntRange(min=0, max=2**63 - 1), default=0,
              help="Random seed of the motion between poses and of the faults.")
def command(
    config: Path, protocol: Protocol, hold: float, speed: float, lost: float, flipped: float,
    garbage: float, unplug_every: float | None, link: Path | None, seed: int,
) -> None:
    """Play the recorded poses of CONFIG on a simulated serial port.

    The command prints the name of the port. Record from it in another terminal with another
    configuration: `pipeline record other.yaml --port NAME`. The poses are repeated in order, with
    the motion of a hand between them. Ctrl-C ends the command.
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
    click.echo(f"{len(poses)} poses, {rate_hz:g} samples/s, {protocol}; Ctrl-C ends the command",
               err=True)
    port.play(device, rate_hz * speed, unplug_every)
