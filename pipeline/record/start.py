"""A session from a configuration and the command line's options."""

from pathlib import Path

from pipeline.config import Config
from pipeline.errors import ConfigError
from pipeline.record.line import Line, SerialLine, only_port
from pipeline.record.session import Filming, Session, Watcher


def open_session(
    config: Config,
    watcher: Watcher,
    port: str | None = None,
    baud: int | None = None,
    camera: int | None = None,
) -> Session:
    """The session of ``config``; options given here come before those of the file.

    Raises
    ------
    ConfigError
        There is no ``record`` section, or nothing that poses could be recorded for.
    DeviceError
        The port cannot be told.
    """
    path: Path = config.source.path
    if config.record is None:
        raise ConfigError(f"{path}: has no section `record`. Add one, as in\nrecord: {{device: "
                          "mpu-6050, seconds_per_pose: 10}\n`pipeline init` shows all its keys."
                          .replace("\n", " "))
    if config.accelerometer is None and config.gyroscope is None:
        raise ConfigError(f"{path}: names no poses to record; add the section accelerometer, "
                          "gyroscope or both, each with the pattern of its pose files.")
    options = {"baud": baud, "camera": camera, "port": port}
    record = config.record.model_copy(
        update={key: value for key, value in options.items() if value is not None})
    wanted = config.model_copy(update={"record": record})
    name = record.port or only_port()

    def open_line(speed: int) -> Line:
        return SerialLine(name, speed)

    return Session(wanted, open_line, watcher, _filming(wanted))


def _filming(_config: Config) -> Filming | None:
    return None
