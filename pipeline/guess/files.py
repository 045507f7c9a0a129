"""Files as they are named on the command line to the guess of a session."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from pipeline.errors import UnreadableInput
from pipeline.guess.plate import MeasuredClip
from pipeline.guess.raw_tables import raw_tables
from pipeline.guess.table_guess import TableGuess, guess_tables, why_no_log
from pipeline.stages.context import RunContext
from pipeline.stages.rate import ClipToFollow, SettingRate, follow_clips, measure_setting

#: Ends of the names of clips; fact.
CLIPS = {".mp4", ".mov", ".avi", ".mkv", ".webm", ".m4v", ".mpg", ".mpeg", ".mts", ".3gp", ".wmv"}


def guess_files(
    files: Sequence[Path], rate_hz: float | None
) -> tuple[list[TableGuess], tuple[str, ...]]:
    """What all tables of ``files`` are, and a note on each table that holds no triad.

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
    tables = [table for path in files for table in raw_tables(path)]
    every = guess_tables(tables, rate_hz)
    guesses = [guess for guess in every if guess is not None]
    passed_over = [f"{table.path}: {why_no_log(table)}; not used."
                   for table, guess in zip(tables, every, strict=True) if guess is None]
    if not guesses:
        raise UnreadableInput(
            f"{passed_over[0]} An accelerometer's readings are as long as gravity in every "
            "attitude. Name the columns in a configuration, as `pipeline init` shows."
        )
    return guesses, tuple(passed_over)


def is_clip(path: Path) -> bool:
    """Whether a file is a clip by its name."""
    return path.suffix.lower() in CLIPS


def rates_of_clips(clips: Sequence[Path], context: RunContext) -> list[SettingRate]:
    """The rate of the plate in each clip, which is a setting of its own.

    Raises
    ------
    UnreadableInput, UnreadableVideo, RateRefused
        Of the first clip, in their order, that shows no turning plate.
    """
    if not clips:
        return []
    from vision.rate.timebase import CLOCK_PPM, Timebase  # OpenCV, where there is a clip

    tracks = follow_clips([ClipToFollow(path) for path in clips], context)
    timebase = Timebase("container", None, CLOCK_PPM["container"])
    return [measure_setting(path.stem, [track], timebase)
            for path, track in zip(clips, tracks, strict=True)]


def measured_clips(rates: Mapping[Path, SettingRate]) -> list[MeasuredClip]:
    """The signed rate of each clip, of which ``rates`` has the setting."""
    return [MeasuredClip(path, -rate.rate_rad_s if rate.plate.direction == "cw"
                         else rate.rate_rad_s) for path, rate in rates.items()]
