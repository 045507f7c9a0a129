"""``pipeline ports``."""

import click

from pipeline.commands import examples


@click.command(epilog=examples("pipeline ports"))
def command() -> None:
    """List the serial ports, the probable device on each, and why one cannot be opened."""
    from pipeline.record.serial_port import find_ports, permission_advice

    ports = find_ports()
    if not ports:
        click.echo("No serial port was detected. Connect the sensor (a charging cable has no data "
                   "wires) and try again.")
        return
    for port in ports:
        description = "  ".join(part for part in (port.probably, port.description) if part)
        click.echo(f"{port.name}  {description}".rstrip())
        if not port.may_open:
            click.echo(f"  cannot be opened. {permission_advice(port.name)}")
    likely = next((port.name for port in ports if port.probably), ports[0].name)
    click.echo(f"next: set `port: {likely}` under `record:` in the configuration, then type "
               f"`pipeline record CONFIG`")
