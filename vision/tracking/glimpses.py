"""Whether anything moves in a clip, by its colours too, from some of its frames.

Where nothing moves, as with a plate at rest, this costs little more than decoding; the frames in
between are not converted to colours.
"""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from vision.plate.background import halved, stands_still
from vision.video import ClipReader, Luma

EVERY = 7  # frames; a plate at a record speed and 15, 25 or 30 fps does not keep step with it
LOOKED_AT = 60  # glimpses at a time
MOST = 3600  # frames of the clip: those in which a plate is looked for


def nothing_moves(
    path: Path, on_progress: Callable[[int, int | None], None] | None
) -> bool:
    """Whether brightness and both axes of colour change by the noise of the camera alone.

    Parameters
    ----------
    path : Path
    on_progress : callable (frames done, frames stated or None), optional
        Called often; what it raises ends the work.
    """
    planes: list[list[Luma]] = [[], [], []]
    done = 0
    with ClipReader(path, colours=True, every=EVERY) as clip:
        for batch in clip:
            done += EVERY * len(batch)
            if on_progress is not None:
                on_progress(done, clip.frames_stated)
            for frame in batch:
                seen = (frame.luma, *cv2.split(frame.chroma))
                for plane, image in zip(planes, seen, strict=True):
                    plane.append(halved(np.asarray(image, np.uint8)))
            if len(planes[0]) >= LOOKED_AT:
                if not all(map(stands_still, planes)):
                    return False
                planes = [plane[-1:] for plane in planes]
            if done >= MOST:
                break
    return len(planes[0]) < 2 or all(map(stands_still, planes))
