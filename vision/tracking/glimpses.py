"""Whether anything moves in the colours of a clip that stands still in brightness.

Its colours are looked at in some of its frames. Where nothing moves, as with a plate at rest, this
costs little more than decoding: the frames in between are not converted to colours.
"""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from vision.plate.background import halved, stands_still
from vision.video.reader import ClipReader, Luma

EVERY = 7  # frames; a plate at a record speed and 15, 25 or 30 fps does not keep step with it
LOOKED_AT = 60  # glimpses at a time
MOST = 3600  # frames of the clip: those in which a plate is looked for


def nothing_moves(
    path: Path, on_progress: Callable[[int, int | None], None] | None
) -> bool:
    """Whether both colours change by the noise of the camera alone.

    Parameters
    ----------
    path : Path
    on_progress : callable (frames done, frames stated or None), optional
        Called often; what it raises ends the work.
    """
    planes: tuple[list[Luma], ...] = ([], [])
    done = 0
    with ClipReader(path, colours=True, every=EVERY) as clip:
        for batch in clip:
            for frame in batch:
                for plane, colour in zip(planes, cv2.split(frame.chroma), strict=True):
                    plane.append(halved(np.asarray(colour, np.uint8)))
                done += EVERY
            if on_progress is not None:
                on_progress(done, clip.frames_stated)
            if len(planes[0]) >= LOOKED_AT:
                if not all(map(_still, planes)):
                    return False
                planes = tuple(plane[-1:] for plane in planes)
            if done >= MOST:
                break
    return all(map(_still, planes))


def _still(plane: list[Luma]) -> bool:
    return len(plane) < 2 or stands_still(plane)
