"""One log in SI units, by the sensor of a configuration or by the guess of ``pipeline import``."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from calib.poses.imu_log import TRIADS, ImuLog
from pipeline.config.load import load_config
from pipeline.config.sensor import sensor_specs
from pipeline.errors import UnreadableInput
from pipeline.guess.config_text import open_scale_text
from pipeline.guess.files import guess_files
from pipeline.guess.session import guess_session
from pipeline.guess.units import per_deg_of
from pipeline.logs.clock import StatedClock
from pipeline.logs.read import read_log
from pipeline.stages.fittable import require_stated_units
from pipeline.text.names import command


def readings_in_si(
    log: Path, config: Path | None, rate_hz: float | None, gyroscope_scale: str | float | None,
    tell: Callable[[str], None],
) -> ImuLog:
    """The readings of a log in m/s² and rad/s, by the data sheet.

    Parameters
    ----------
    log : Path
    config : Path or None
        Its ``sensor`` states the units; None: the units are guessed.
    rate_hz : float or None
        Sample rate of a log without a column of times.
    gyroscope_scale : str or float or None
        Unit of the gyroscope, or its range in °/s, for the guess.
    tell : callable
        Receives a line about every guess.

    Raises
    ------
    ConfigError, MissingFiles, UnreadableInput
        The configuration is wrong, or does not state a triad of the log; the log cannot be read,
        or nothing shows the unit of its gyroscope.
    """
    if config is None:
        tables, _ = guess_files([log], rate_hz)
        guess = guess_session(tables, (), per_deg_of(gyroscope_scale))
        for triad in (guess.accelerometer, guess.gyroscope):
            if triad is not None:
                tell(f"{', '.join(triad.columns)} are in {triad.unit} ({triad.because})"
                     + (f"; not sure: {triad.doubt}" if triad.doubt else ""))
        if guess.scales:
            open_scale = open_scale_text(guess, "name a configuration whose `sensor` states it by "
                                                "--config")
            raise UnreadableInput(f"{log}: has a gyroscope, and {open_scale}.")
        readings = guess.tables[0].log()
        if readings is None:
            raise UnreadableInput(f"{log}: its readings or times are no log of samples. Type "
                                  f"`{command('import', log)}` to see what is there.")
        return readings
    session = load_config(config, files_may_be_missing=True)
    require_stated_units(session, [log])
    raw = read_log(log, None, StatedClock(rate_hz))
    nominal: dict[str, Any] = {}
    specs = sensor_specs(session.sensor)
    for name in TRIADS:
        spec = specs.get(name)
        if raw.has(name) and spec is not None:
            nominal[name] = spec.nominal(raw.readings(name))
        elif raw.has(name):
            raise UnreadableInput(f"{config}: `sensor` does not state the {name}, which {log} "
                                  f"holds. State it, or leave --config out to have it guessed.")
    return replace(raw, **nominal)
