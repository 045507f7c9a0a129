"""Dropped logs and clips: kept apart, interpreted and shown, then made a session of the folder."""

import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path
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
from pipeline.stages.context import RunContext
from pipeline.stages.rate import ClipToFollow, SettingRate
from pipeline.stages.run import run_stages
from pipeline.text.formatting import DISPLAY
from pipeline.workbench.clip_player import ClipToPlay, PlateReading
from pipeline.workbench.dropped import Dropped, checked_name
from pipeline.workbench.session_files import followed_clip

CONFIG_NAME = "config.yaml"
DRAWN = 400  #: samples of a plot, one for each of its pixels; layout


class Brought(Dropped):
    """Files dropped for one new session of the folder."""

    def forget(self) -> None:
        """Remove the dropped files."""
        self._rates: dict[Path, SettingRate] = {}
        self._guess: SessionGuess | None = None
        super().forget()

    def guessed(self, per_deg: float | None) -> Json:
        """Interpretation of the files in words, with plots; ``scales`` where one must be chosen.

        Raises
        ------
        PipelineError, CalibrationError, VisionError
            A file cannot be read, or none is a log.
        """
        with self.by_their_names():
            return self._shown(per_deg)

    def _shown(self, per_deg: float | None) -> Json:
        clips = self._measured()
        seen = [f"{each.path.name}: the plate turns at {each.rate_rad_s / RPM:+.4f} rpm in it."
                for each in clips]
        self._guess = None
        if not self.logs and not clips:
            raise ConfigError("nothing is there yet: drop the logs of the sensor, and the clip.")
        if not self.logs:
            return {"lines": seen, "passed_over": ["Drop the logs of the sensor too."],
                    "plots": [], "scales": [], "is_session": False}
        guess, passed_over = self._guessed(per_deg)
        self._guess = guess
        shown = [source.tables[0] for source in guess.sources]
        return {
            "lines": [line.replace(f"{self.root}/", "") for line in [*guess_lines(guess), *seen]],
            "passed_over": [line.replace(f"{self.root}/", "") for line in passed_over],
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
                self._rates |= rates_of_clips([clip], RunContext())
        return measured_clips(self._rates)

    def _guessed(self, per_deg: float | None) -> tuple[SessionGuess, Sequence[str]]:
        if not self.logs:
            raise ConfigError("no log is there yet: drop the logs of the sensor too.")
        tables, passed_over = guess_files(self.logs, None)
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
        config = self.root / CONFIG_NAME
        if config.exists():
            raise UnwritableOutput(f"{CONFIG_NAME} is the name of one of the logs. Rename it.")
        site = None if latitude is None else site_text(latitude, height_m)
        with TemporaryDirectory() as cache, self.by_their_names():
            context = RunContext(Path(cache))
            checked = checked_config(guess, config, Choices(site),
                                     lambda each: run_stages(each, context))
        with self.kept_as(target):
            write_whole(target / CONFIG_NAME, checked.text)
        return {"path": str(target / CONFIG_NAME), "text": checked.text,
                "changes": list(checked.changes), "fault": checked.fault}


def _turning(tables: Sequence[TableGuess], k: int) -> PlateReading:
    """Readings of the k-th table's gyroscope in the unit that was guessed."""
    log = tables[k].log()
    if log is None:
        raise ConfigError(f"{tables[k].path.name}: has no times to draw it against.")
    return PlateReading(log.time_s, np.linalg.norm(log.gyroscope, axis=1), "as guessed", math.nan)


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
