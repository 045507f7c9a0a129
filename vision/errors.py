"""What can go wrong with a clip, by what the user can do about it.

Every message is one paragraph: where, what was found, what was expected, what to do next.
"""


class VisionError(Exception):
    """Base of all expected failures of this package."""


class UnreadableVideo(VisionError):
    """The file is not a video that can be decoded, or has too few pictures."""


class RateRefused(VisionError):
    """The clip is readable, but no honest constant rate can be given from it."""
