"""The camera of a guided recording: one clip for each pose on the turning plate."""

from collections.abc import Callable
from pathlib import Path

from pipeline.errors import DeviceError
from vision.camera import Camera, CameraFailed, Watch


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
        """End the clip; what to say of it."""
        try:
            clip = self._camera.stop(keep)
        except CameraFailed as error:
            return f"; without a clip: {error}"
        if clip is None:
            return "; without a clip: the camera delivered no frame" if keep else ""
        return f"; filmed {clip.path.name}, {clip.frames} frames in {clip.seconds:.1f} s"

    def close(self) -> None:
        """Give the camera back."""
        self._camera.close()
