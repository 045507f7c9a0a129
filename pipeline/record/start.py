"""A session from a configuration and the command line's options, filmed where there is a camera."""

from functools import partial
from pathlib import Path

from pipeline.config.load import Config
from pipeline.errors import ConfigError
from pipeline.record.serial_port import SerialPort, only_port
from pipeline.record.session import RecordingDisplay, Session
from pipeline.stages.live_clip import opened_camera
from vision.camera import Watch


def open_session(
    config: Config,
    display: RecordingDisplay,
    port: str | None = None,
    baud: int | None = None,
    camera: int | None = None,
    watch: Watch | None = None,
) -> Session:
    """The session of ``config``; the options overrule the file, ``watch`` sees the frames.

    Raises
    ------
    ConfigError
        There is no ``record`` section, or nothing that poses could be recorded for.
    DeviceError
        The configuration names no port, and there is not exactly one that it could be.
    """
    path: Path = config.source.path
    if config.record is None:
        raise ConfigError(f"{path}: has no section `record`. Add one, as in `record: {{device: "
                          f"mpu-6050, seconds_per_pose: 10}}`; `pipeline init` shows all its keys.")
    if not config.triads:
        raise ConfigError(f"{path}: names no poses to record; add the section accelerometer, "
                          "gyroscope or both, each with the pattern of its pose files.")
    options = {"baud": baud, "camera": camera, "port": port}
    record = config.record.model_copy(
        update={key: value for key, value in options.items() if value is not None})
    chosen = config.model_copy(update={"record": record})
    open_camera = None if record.camera is None else partial(
        opened_camera, record.camera, watch=watch)
    return Session(chosen, partial(SerialPort, record.port or only_port()), display, open_camera)
