"""Logs of formats that state their units, against the sensor that a configuration states."""

from collections.abc import Iterable
from pathlib import Path

from pipeline.config.load import Config
from pipeline.config.sensor import AccelerometerSheet, GyroscopeSheet
from pipeline.errors import ConfigError
from pipeline.logs.formats.kinds import kind_of, split_member

#: Triad -> what a configuration states of readings in SI units, and how people write it.
SI_UNITS = {"accelerometer": ("m_s2", "m/s²"), "gyroscope": ("rad_s", "rad/s")}
WRITE = "`sensor: {accelerometer: {unit: m_s2}, gyroscope: {unit: rad_s}}`"


def require_stated_units(config: Config, paths: Iterable[Path]) -> None:
    """Refuse logs in SI units of a sensor that is stated in counts or other units.

    Parameters
    ----------
    config : Config
    paths : iterable of Path
        Logs that are read with the sensor of ``config``.

    Raises
    ------
    ConfigError
        With the line of the sensor, the unit of the format, and what to write.
    UnreadableInput
        A file cannot be read.
    """
    for path in paths:
        file, _ = split_member(path)
        kind = kind_of(file)
        if kind is None or not kind.si:
            continue
        for triad, (unit, words) in SI_UNITS.items():
            sheet = getattr(config.sensor, triad)
            if sheet is not None and sheet.unit != unit:
                raise ConfigError(config.source.problem(("sensor",), (
                    f"{path.name} is a {kind.name}, whose {triad} is in {words}; the sensor is "
                    f"stated with {_stated(sheet)}. Write {WRITE}, or name logs of raw counts")))


def _stated(sheet: AccelerometerSheet | GyroscopeSheet) -> str:
    """The first key of a data sheet as it is written."""
    stated = sheet.model_dump(exclude_none=True)
    name, value = min(stated.items(), key=lambda item: item[0] in ("bits", "encoding"))
    return f"`{name}: {value:g}`" if isinstance(value, float) else f"`{name}: {value}`"
