"""What a user says of the search for rests in a log."""

from dataclasses import dataclass


@dataclass(frozen=True)
class StillSearch:
    """What the user says of the search: both None for the search itself.

    ``seconds`` is the shortest stop; ``threshold`` how noisy a stop may be, as a multiple of the
    noise amplitude of the quietest rest.
    """

    seconds: float | None = None
    threshold: float | None = None
