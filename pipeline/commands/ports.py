"""``pipeline ports``."""

import click


@click.command()
def command() -> None:
    """List the serial ports, what is probably behind each, and what keeps you from opening it."""
    from pipeline.record.serial_port import find_ports, permission_advice

    ports = find_ports()
    if not ports:
        click.echo("no serial port is here: plug the sensor in (a cable that only charges has no "
                   "data wires), and look again")
        return
    for port in ports:
        says = "  ".join(part for part in (port.probably, port.description) if part)
        click.echo(f"{port.name}  {says}".rstrip())
        if not port.may_open:
            click.echo(f"  may not be opened. {permission_advice(port.name)}")
    named = next((port.name for port in ports if port.probably), ports[0].name)
    click.echo(f"next: set `port: {named}` under record: in the configuration, then "
               f"`pipeline record CONFIG`")
