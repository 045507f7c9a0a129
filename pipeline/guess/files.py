"""Files as they are named on the command line to the guess of a session."""

from collections.abc import Sequence
from pathlib import Path

from pipeline.errors import UnreadableInput
from pipeline.guess.raw_tables import raw_tables
from pipeline.guess.session import SessionGuess, guess_session
from pipeline.guess.table_guess import TableGuess, guess_table


def guess_files(
    files: Sequence[Path], rate_hz: float | None
) -> tuple[SessionGuess, tuple[str, ...]]:
    """The guess of all tables of ``files``, and a note on each table that is no log.

    Parameters
    ----------
    files : sequence of Path
    rate_hz : float or None
        The sample rate as the user states it.

    Raises
    ------
    UnreadableInput
        A file cannot be read, or no table of any file holds a triad.
    """
    guesses: list[TableGuess] = []
    passed_over: list[str] = []
    for path in files:
        for table in raw_tables(path):
            guess = guess_table(table, rate_hz)
            if guess is None:
                shown = ", ".join(list(table.columns)[:8])
                passed_over.append(f"{table.path}: no accelerometer and no gyroscope among its "
                                   f"columns ({shown}); not used.")
            else:
                guesses.append(guess)
    if not guesses:
        raise UnreadableInput(
            f"{passed_over[0]} An accelerometer's readings are as long as gravity in every "
            "attitude. Name the columns in a configuration, as `pipeline init` shows."
        )
    return guess_session(guesses), tuple(passed_over)
