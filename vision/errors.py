"""What can go wrong with a clip, by what the user can do about it.

Every message is one paragraph: where, what was found, what was expected, what to do next.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
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
    """

    def __init__(self, message: str, history: "RateHistory | None" = None) -> None:
        super().__init__(message)
        self.history = history


class NothingMoves(RateRefused):
    """The frames of a stretch differ by the noise of the camera alone."""


def more_telling(first: RateRefused | None, later: RateRefused) -> RateRefused:
    """Of two refusals the first, unless nothing moved there and something did later."""
    if first is None or isinstance(first, NothingMoves) > isinstance(later, NothingMoves):
        return later
    return first
