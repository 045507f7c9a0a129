"""A live camera: a clip of the turning plate to be measured like any other, or one of each pose."""

import time
from collections.abc import Callable
from pathlib import Path

from pipeline.errors import DeviceError
from vision.camera import Camera, CameraFailed, Watch

LOOK_S = 0.1  #: s between two looks at the progress; chosen


def film_clip(
    source: int | Path,
    seconds: float,
    clip: Path,
    on_progress: Callable[[str, int, int | None], None],
) -> Path:
    """Film for ``seconds``; ``source`` is a camera's number, or a clip that stands for one.

    Parameters
    ----------
    clip : path
        The Matroska file (.mkv) to write; its time stamps stand beside it as ``.times.csv``.
    on_progress : callable (name, seconds done, seconds in all)

    Raises
    ------
    DeviceError
        There is no such camera, or it delivers no more frames.
    """
    try:
        camera = Camera(source)
        try:
            camera.start(clip)
            begun = time.monotonic()
            while (done := time.monotonic() - begun) < seconds:
                on_progress(clip.stem, int(done), round(seconds))
                time.sleep(min(LOOK_S, seconds - done))
            kept = camera.stop(keep=True)
        finally:
            camera.close()
    except CameraFailed as error:
        raise DeviceError(str(error)) from error
    if kept is None:
        raise DeviceError(
            f"camera {source} delivered fewer than two frames in {seconds:g} s. Close other "
            f"programs that use it, or choose another camera (--camera)."
        )
    return kept.path


class PoseCamera:
    """A camera that films poses, each in a clip of its own.

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
