"""A session from a configuration and the command line's options, filmed where there is a camera."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.config.load import Config
from pipeline.errors import ConfigError, DeviceError
from pipeline.record.serial_port import Port, SerialPort, only_port
from pipeline.record.session import Filming, OpenCamera, RecordingDisplay, Session
from vision.camera import Camera, CameraFailed, Watch

if TYPE_CHECKING:
    pass


class PoseCamera:
    """Films poses; see :class:`pipeline.record.session.Filming`.

    Parameters
    ----------
    number : int
        Number of the camera; 0 is the first.
    clock : callable
        The session's clock, which the sensor's log is kept on.
    watch : callable, optional
        Sees every frame.

    Raises
    ------
    DeviceError
        The camera cannot be opened.
    """

    def __init__(
        self, number: int, clock: Callable[[], float], watch: Watch | None = None
    ) -> None:
        try:
            self._camera = Camera(number, clock, watch)
        except CameraFailed as error:
            raise DeviceError(str(error)) from error

    def start(self, clip: Path) -> None:
        """Begin a clip."""
        self._camera.start(clip)

    def stop(self, keep: bool) -> str:
        """End the clip; returns a remark on it."""
        try:
            clip = self._camera.stop(keep)
        except CameraFailed as error:
            return f"; without a clip: {error}"
        if clip is None:
            return "; without a clip: the camera delivered no frame" if keep else ""
        return f"; filmed {clip.path.name}, {clip.frames} frames in {clip.seconds:.1f} s"

    def close(self) -> None:
        """Release the camera."""
        self._camera.close()


def open_session(
    config: Config,
    display: RecordingDisplay,
    port: str | None = None,
    baud: int | None = None,
    camera: int | None = None,
    watch: "Watch | None" = None,
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
    name = record.port or only_port()

    def open_port(speed: int) -> Port:
        return SerialPort(name, speed)

    return Session(chosen, open_port, display, _open_camera(record.camera, watch))


def _open_camera(number: int | None, watch: "Watch | None") -> OpenCamera | None:
    if number is None:
        return None

    def open_camera(clock: Callable[[], float]) -> Filming:
        from pipeline.record.start import PoseCamera

        return PoseCamera(number, clock, watch)

    return open_camera
