"""User settings of the search for rests in a log."""

from dataclasses import dataclass


@dataclass(frozen=True)
class StillSearch:
    """User settings of the search: both None for the search itself.

    Parameters
    ----------
    seconds : float or None
        The shortest stop, s.
    threshold : float or None
        How noisy a stop may be: its noise amplitude in multiples of that of the quietest rest.
    """

    seconds: float | None = None
    threshold: float | None = None
