"""Light that changes in bands or as a whole, told from what moves.

A rolling shutter reads each line of a frame at another phase of a lamp. With I the mean of the
frames, the lines of a frame are then a(y) I(x, y) + c(y), or the same in x if the camera stands
upright; a light that changes as a whole is the same with one a and c. What moves changes less than
half of a line, so the median along the line shows the light.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.numbers import SD_PER_MAD, median
from vision.video.reader import Luma
from vision.video.reduction import reduced

THIN = 4  # pixels of a block in which the light is looked for; a judgement: noise counts 1/4
#: Share of the change in the medians of lines from which the light is taken out. Tuned on 80 films:
#: 0.38 and more under a lamp in bands, 0.29 and less in any other.
LIT = 0.3
MOSTLY = 0.5  # squared correlation of two frames with one picture; it chooses the words


@dataclass(frozen=True, eq=False)
class Lamp:
    """The light of a stretch of frames.

    Attributes
    ----------
    mean : array of float32, shape (h, w)
        The frames' mean, I.
    along : int
        Axis along which the lines lie that share a light: 0 or 1.
    """

    mean: NDArray[np.float32]
    along: int

    def evened(self, image: Luma) -> Luma:
        """An image (h, w) each line of which has the light that it has in the mean."""
        level = self.mean.mean(axis=self.along, keepdims=True)
        contrast = self.mean - level
        power = np.maximum((contrast**2).sum(axis=self.along, keepdims=True), 1.0)
        gain = (contrast * image).sum(axis=self.along, keepdims=True) / power - 1
        more = image.mean(axis=self.along, keepdims=True) - level + gain * contrast
        return np.asarray(np.rint(np.clip(image - more, 0, 255)), np.uint8)


def changing_light(images: Sequence[Luma]) -> int | None:
    """The axis along which the lines lie that share a light: 0, 1, or None if none changes.

    Under another light the picture is the same; pictures that follow each other are not.

    Parameters
    ----------
    images : sequence of arrays of uint8, shape (h, w)
        In the order of time.
    """
    seen = np.stack([reduced(image, THIN) for image in images]).astype(np.float32)
    change = seen - seen.mean(axis=0)
    noise = SD_PER_MAD * float(median(np.abs(np.diff(change, axis=2)))) / np.sqrt(2)
    whole = float((change**2).sum()) - change.size * noise**2
    shares = [change.shape[1 + along] * float((median(change, axis=1 + along) ** 2).sum())
              for along in (0, 1)]
    along = int(np.argmax(shares))
    return along if shares[along] > LIT * max(whole, 0) and _same_picture(seen, along) else None


def in_even_light(images: Sequence[Luma], along: int | None) -> list[Luma]:
    """Images (h, w) in the light of their mean, by lines along an axis; as they are by none."""
    if along is None:
        return list(images)
    lamp = Lamp(np.mean(images, axis=0, dtype=np.float32), along)
    return [lamp.evened(image) for image in images]


def _same_picture(seen: NDArray[np.float32], along: int) -> bool:
    """Whether the frame that differs most from the first has the same contrast in its lines."""
    contrast = seen - seen.mean(axis=1 + along, keepdims=True)
    other = int(((seen - seen[0]) ** 2).sum(axis=(1, 2)).argmax())
    x, y = contrast[0].ravel(), contrast[other].ravel()
    return bool(float(x @ y) ** 2 >= MOSTLY * float(x @ x) * float(y @ y))
