"""Effects of a calibration that the samples of another log do not tell, in sentences."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

from calib.effects.effect import Effect
from calib.rounding import two_digits
from pipeline.text.formatting import DISPLAY


def untold_notes(
    triad: str, effects: Sequence[Effect], by_untold: Mapping[str, float | None],
    session_clock: bool = False,
) -> Iterator[str]:
    """What a correction does about such effects of a model, a sentence or two for each kind.

    Parameters
    ----------
    triad : str
    effects : sequence of Effect
        Of the model.
    by_untold : mapping of str to float
        Expected error by each that does not stay as it is, root mean square, SI.
    session_clock : bool
        The clock of the session is that of the log, which tells what follows it.
    """
    whole_poses = [one.name for one in effects
                   if one.acts_on == "sensor" and one.told_by == "nothing"]
    if whole_poses:
        yield (f"{triad}: no sample of a log tells {' and '.join(whole_poses)}, which whole poses "
               f"have: corrections of a log leave {'it' if len(whole_poses) == 1 else 'them'} out"
               f"{_error(triad, map(by_untold.get, whole_poses))}.")
    timed = [] if session_clock else [
        one.name for one in effects if one.acts_on == "sensor" and one.told_by == "clock"]
    moving = [name for name in timed if by_untold.get(name)]
    steps = [name for name in timed if name not in moving]
    levels = [f"{' and '.join(names)} {how}" for names, how in (
        (steps, "at the last level"),
        (moving, f"at the end of the session{_error(triad, map(by_untold.get, moving))}"),
    ) if names]
    if levels:
        yield (f"{triad}: a log of another time than the session is corrected with "
               f"{', and with '.join(levels)}. What moved on since adds to the error; if the "
               f"time_s of the log counts on the clock of the session, add --session-clock.")


def _error(triad: str, sizes: Iterable[float | None]) -> str:
    """What corrected magnitudes err by without them, as the end of a clause."""
    unit, factor = DISPLAY[triad]
    error = math.hypot(*(size or 0.0 for size in sizes))
    return (f", and corrected magnitudes err by {two_digits(error * factor)} {unit} for that (rms "
            f"over the session)") if error else ""
