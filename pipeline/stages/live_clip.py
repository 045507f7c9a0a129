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


def opened_camera(
    number: int, clock: Callable[[], float], watch: Watch | None = None
) -> Camera:
    """The camera ``number`` on the session's ``clock``; ``watch`` sees every frame.

    Raises
    ------
    DeviceError
        It cannot be opened.
    """
    try:
        return Camera(number, clock, watch)
    except CameraFailed as error:
        raise DeviceError(str(error)) from error
