"""What can go wrong with a clip, by what the user can do about it.

Every message is one paragraph: where, what was found, what was expected, what to do next.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vision.image_return import ImageReturn
    from vision.phase_track import RateHistory


class VisionError(Exception):
    """Base of all expected failures of this package."""


class UnreadableVideo(VisionError):
    """The file is not a video that can be decoded, or has too few frames."""


class RateRefused(VisionError):
    """The clip is readable, but no honest constant rate can be given from it.

    Attributes
    ----------
    history : RateHistory or None
        Rate against time, where the plate was followed but does not turn steadily.
    returns : ImageReturn or None
        What the picture repeats after, where it does.
    """

    def __init__(
        self, message: str, history: "RateHistory | None" = None,
        returns: "ImageReturn | None" = None,
    ) -> None:
        super().__init__(message)
        self.history, self.returns = history, returns


class NoSuchPart(RateRefused):
    """The clip has no frames, or too few, in the part that was stated."""


class NothingMoves(RateRefused):
    """The frames of a stretch differ by the noise of the camera alone."""


class NoPlate(RateRefused):
    """Much changes in the picture, and nothing of it comes back, or what does so cannot turn."""


class OnlyShifts(NoPlate):
    """What is seen shifts in one direction: the camera moves, or something passes by it."""


def more_telling(first: RateRefused | None, later: RateRefused) -> RateRefused:
    """The first of two refusals, unless nothing moved there and something did later.

    Without its traceback, which would hold on to the frames that were looked at.
    """
    if first is None or isinstance(first, NothingMoves) > isinstance(later, NothingMoves):
        return later.with_traceback(None)
    return first
