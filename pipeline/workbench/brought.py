"""Dropped logs and clips: kept apart, interpreted and shown, then made a session of the folder."""

import math
import shutil
from collections.abc import AsyncIterator, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory

import numpy as np

from calib.numbers import RPM
from calib.poses.imu_log import TRIADS
from pipeline.config.template import site_text
from pipeline.console.import_text import guess_lines
from pipeline.errors import ConfigError, UnwritableOutput
from pipeline.files import write_whole
from pipeline.guess.checked import checked_config
from pipeline.guess.config_text import Choices
from pipeline.guess.files import guess_files, is_clip, measured_clips, rates_of_clips
from pipeline.guess.plate import MeasuredClip
from pipeline.guess.session import SessionGuess, guess_session
from pipeline.guess.table_guess import TableGuess
from pipeline.results.json_values import Json
from pipeline.served.serve import REFUSED
from pipeline.stages.context import RunContext
from pipeline.stages.rate import ClipToFollow, SettingRate
from pipeline.stages.run import run_stages
from pipeline.text.formatting import DISPLAY
from pipeline.workbench.clip_player import ClipToPlay, PlateReading
from pipeline.workbench.session_files import followed_clip

CONFIG_NAME = "config.yaml"
DEEPEST = 4  #: parts of a file's path in a dropped folder; chosen
LONGEST_NAME = 120  #: characters of a file's name; chosen
MOST_FILES = 2000  #: files of one session; chosen
MOST_BYTES = 1 << 32  #: bytes of a session: the clips of an evening; chosen
PART = ".part"  #: end of the name of a file that is not whole yet
DRAWN = 400  #: samples of a plot, one for each of its pixels; layout


class Brought:
    """Files dropped for one session of ``folder``; they stay hidden there until they are used."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._place: TemporaryDirectory[str] | None = None
        self.forget()

    def forget(self) -> None:
        """Remove the dropped files."""
        self._rates: dict[Path, SettingRate] = {}
        self._guess: SessionGuess | None = None
        self._bytes = 0
        if self._place is not None:
            self._place.cleanup()

    @property
    def files(self) -> list[Path]:
        """The dropped files, in the order of the names."""
        return sorted(path for path in self._root.rglob("*")
                      if path.is_file() and path.suffix != PART)

    @property
    def _root(self) -> Path:
        if self._place is None or not Path(self._place.name).is_dir():
            try:
                self._place = TemporaryDirectory(prefix=".brought-", dir=self.folder)
            except OSError as error:
                raise UnwritableOutput(
                    f"{self.folder}: cannot be written ({error.strerror}). Open a folder of your "
                    f"own.") from error
        return Path(self._place.name)

    async def save(self, name: str, chunks: AsyncIterator[bytes]) -> None:
        """Keep one file.

        Raises
        ------
        ConfigError
            It is neither log nor clip, its name leads elsewhere, or all of them are too many.
        """
        path = self._root / checked_name(name)
        if not (is_clip(path) or path.suffix.lower() in LOGS):
            raise ConfigError(f"{name}: is neither a log nor a clip by its name; not taken.")
        if path.exists() or len(self.files) >= MOST_FILES:
            raise ConfigError(f"{name}: is there already, or there are {MOST_FILES} files.")
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_name(f"{path.name}{PART}")
        try:
            with part.open("wb") as file:
                async for chunk in chunks:
                    self._bytes += len(chunk)
                    if self._bytes > MOST_BYTES:
                        raise ConfigError(f"{name}: with it the files are larger than "
                                          f"{MOST_BYTES >> 30} GB.")
                    file.write(chunk)
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)

    def guessed(self, per_deg: float | None) -> Json:
        """Interpretation of the files in words, with plots; ``scales`` where one must be chosen.

        Raises
        ------
        PipelineError, CalibrationError, VisionError
            A file cannot be read, or none is a log.
        """
        with self._by_their_names():
            return self._shown(per_deg)

    @contextmanager
    def _by_their_names(self) -> Iterator[None]:
        """Refusals that name the files as they were dropped."""
        try:
            yield
        except REFUSED as error:
            raise ConfigError(str(error).replace(f"{self._root}/", "")) from error

    @property
    def _logs(self) -> list[Path]:
        return [path for path in self.files if not is_clip(path)]

    def _shown(self, per_deg: float | None) -> Json:
        clips = self._measured()
        seen = [f"{each.path.name}: the plate turns at {each.rate_rad_s / RPM:+.4f} rpm in it."
                for each in clips]
        self._guess = None
        if not self._logs and not clips:
            raise ConfigError("nothing is there yet: drop the logs of the sensor, and the clip.")
        if not self._logs:
            return {"lines": seen, "passed_over": ["Drop the logs of the sensor too."],
                    "plots": [], "scales": [], "is_session": False}
        guess, passed_over = self._guessed(per_deg)
        self._guess = guess
        shown = [source.tables[0] for source in guess.sources]
        return {
            "lines": [line.replace(f"{self._root}/", "") for line in [*guess_lines(guess), *seen]],
            "passed_over": [line.replace(f"{self._root}/", "") for line in passed_over],
            "plots": [plot for table in shown for plot in plots_of(table)],
            "scales": [{"per_deg": each.per_deg, "says": each.says} for each in guess.scales],
            "is_session": True,
        }

    def clips(self) -> list[ClipToPlay]:
        """The dropped clips, each beside the logs in which the plate turns."""
        tables = [] if self._guess is None else [
            table for table in self._guess.tables if table.gyroscope and table.turning_rad_s]
        return [ClipToPlay(path.stem, path, rate.clips[0],
                           partial(followed_clip, ClipToFollow(path), RunContext()),
                           [table.path.name for table in tables], 0, partial(_turning, tables))
                for path, rate in self._rates.items()]

    def _measured(self) -> list[MeasuredClip]:
        """The rate of the plate in each clip; each is measured once."""
        for clip in filter(is_clip, self.files):
            if clip not in self._rates:
                self._rates[clip], = rates_of_clips([clip], RunContext())
        return measured_clips(self._rates)

    def _guessed(self, per_deg: float | None) -> tuple[SessionGuess, Sequence[str]]:
        if not self._logs:
            raise ConfigError("no log is there yet: drop the logs of the sensor too.")
        tables, passed_over = guess_files(self._logs, None)
        return guess_session(tables, self._measured(), per_deg), passed_over

    def use(
        self, name: str, latitude: float | None, height_m: float, per_deg: float | None
    ) -> Json:
        """Make the files a session ``name`` of the folder, with a configuration that was tried.

        Raises
        ------
        ConfigError, UnwritableOutput
            The name is none, or is there already.
        PipelineError, CalibrationError, VisionError
            As :meth:`guessed`.
        """
        target = self.folder / checked_name(name)
        if target.parent != self.folder:
            raise ConfigError(f"'{name}' is no name of a folder.")
        if target.exists() or target.is_symlink():
            raise UnwritableOutput(f"{target}: exists and is left as it is. Choose another name.")
        guess, _ = self._guessed(per_deg)
        config = self._root / CONFIG_NAME
        if config.exists():
            raise UnwritableOutput(f"{CONFIG_NAME} is the name of one of the logs. Rename it.")
        site = None if latitude is None else site_text(latitude, height_m)
        with TemporaryDirectory() as cache, self._by_their_names():
            context = RunContext(Path(cache))
            checked = checked_config(guess, config, Choices(site),
                                     lambda each: run_stages(each, context))
        write_whole(config, checked.text)
        shutil.move(self._root, target)  # within the folder: instantly
        target.chmod(0o755)
        self.forget()
        return {"path": str(target / CONFIG_NAME), "text": checked.text,
                "changes": list(checked.changes), "fault": checked.fault}


def checked_name(name: str) -> Path:
    """A relative path whose parts are plain names.

    Raises
    ------
    ConfigError
        It leads elsewhere, is hidden, or no file system holds it.
    """
    parts = PurePosixPath(name).parts
    if not 1 <= len(parts) <= DEEPEST or not all(
            part.isprintable() and len(part) <= LONGEST_NAME and not part.startswith(".")
            and not set(part) & set('/\\:*?"<>|') for part in parts):
        raise ConfigError(f"{name!r} is no name of a file of a session.")
    return Path(*parts)


def _turning(tables: Sequence[TableGuess], k: int) -> PlateReading:
    """Readings of the k-th table's gyroscope in the unit that was guessed."""
    log = tables[k].log()
    if log is None:
        raise ConfigError(f"{tables[k].path.name}: has no times to draw it against.")
    return PlateReading(log.time_s, np.linalg.norm(log.gyroscope, axis=1), "as guessed", math.nan)


LOGS = {".csv", ".txt", ".log", ".tsv", ".dat", ".gz", ".zip", ".json", ".jsonl", ".ndjson", ".mat",
        ".npy", ".npz", ".h5", ".hdf5", ".parquet", ".bag", ".mcap", ".db3", ".ulg", ".bin",
        ".xml", ".sens", ".out", ".asc", ".tab", ".prn"}
"""Extensions of logs. Fact: those that :mod:`pipeline.logs` reads and that loggers use."""


def plots_of(table: TableGuess) -> list[Json]:
    """The readings of a table against its times, in shown units, for each triad."""
    log = table.log()
    if log is None or table.are_means:
        return []
    at = np.unique(np.linspace(0, len(log.time_s) - 1, DRAWN).astype(int))
    plots = []
    for triad in TRIADS:
        unit, factor = ("m/s²", 1.0) if triad == "accelerometer" else DISPLAY[triad]
        values = log.readings(triad)[at] * factor
        if getattr(table, triad) is not None and np.isfinite(values).all():
            plots.append({
                "name": table.path.name, "triad": triad, "unit": unit,
                "time_s": (log.time_s[at] - log.time_s[0]).tolist(), "values": values.T.tolist()})
    return plots
