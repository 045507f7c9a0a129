"""Failures of a clip, by what the user can do about them.

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
        Rate against time, if the plate was tracked but does not turn steadily.
    returns : ImageReturn or None
        Period of the picture, if it repeats.
    """

    def __init__(
        self, message: str, history: "RateHistory | None" = None,
        returns: "ImageReturn | None" = None,
    ) -> None:
        super().__init__(message)
        self.history, self.returns = history, returns


class NoSuchPart(RateRefused):
    """The clip has no frames, or too few, in the stated part."""


class NothingMoves(RateRefused):
    """The frames of a stretch differ by the noise of the camera alone."""


class OnlyLight(NothingMoves):
    """The light of a stretch changes, in bands or as a whole, and nothing that turns is seen."""


class NoPlate(RateRefused):
    """Much changes in the picture, and nothing repeats, or the repeating part cannot turn."""


class OnlyShifts(NoPlate):
    """The picture moves without turning: the camera moves, or something passes in front of it."""


class TooShortToReturn(NoPlate):
    """Nothing repeats in a clip in which a slow plate does not turn twice."""


class EqualReturns(NoPlate):
    """The picture returns after a part of a turn: blades, spokes, equal marks."""


def more_telling(first: RateRefused | None, later: RateRefused) -> RateRefused:
    """The first of two refusals, unless nothing moved there and something did later.

    Its traceback is removed, because that would keep the frames in memory.
    """
    if first is None or isinstance(first, NothingMoves) > isinstance(later, NothingMoves):
        return later.with_traceback(None)
    return first
