"""Further logs and clips of an open session: shown with the errors before and after, then written.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import count
from pathlib import Path

from pipeline.config.load import Config, config_from
from pipeline.config.yaml_text import YamlSource
from pipeline.console.further_text import HEAD, further_rows, place_text
from pipeline.console.next_step import next_line
from pipeline.console.run_text import pose_change_lines
from pipeline.errors import ConfigError
from pipeline.further.logs import FurtherLog, Known, further_logs, unused_clips
from pipeline.further.text import Place, places_for, with_further
from pipeline.guess.agreement import implausible
from pipeline.guess.files import is_clip, measured_clips, rates_of_clips
from pipeline.guess.plate import MeasuredClip
from pipeline.results.json_values import Json
from pipeline.stages.run import Outcome, run_stages
from pipeline.workbench.dropped import Dropped
from pipeline.workbench.live_refits import OpenSession

FOLDER = "further_{}"  #: the folder beside the configuration in which the logs are kept


class FurtherFiles(Dropped):
    """Files dropped for an open session, by default those of none."""

    def forget(self) -> None:
        """Remove the dropped files."""
        self._seen: tuple[list[Path], list[FurtherLog], list[MeasuredClip]] = [], [], []
        super().forget()

    def _logs(self, session: OpenSession) -> tuple[list[FurtherLog], list[MeasuredClip]]:
        """The dropped logs and the rates of the dropped clips, each read once."""
        files = self.files
        if not self.logs:
            raise ConfigError("no log is there yet: drop the logs of the new poses.")
        if files != self._seen[0]:
            films = [file for file in files if is_clip(file)]
            clips = measured_clips(rates_of_clips(films, session.context))
            state = session.as_run()
            fits = {triad: session.refitted(state, triad).calibration for triad in state.triads}
            known = Known.of(session.config, fits, session.rates, session.recordings)
            logs = further_logs(session.config, known, self.logs, clips)
            self._seen = files, logs, clips
        return self._seen[1:]

    def looked_at(
        self, session: OpenSession, config: Config, left_out: Collection[str]
    ) -> Json:
        """The poses, the runs that they may join, and what the fit makes of them.

        Parameters
        ----------
        session : OpenSession
        config : Config
            As the screen shows it.
        left_out : collection of str
            Keys of the runs that they are not to join.

        Raises
        ------
        PipelineError, CalibrationError, VisionError
            A log or the session with it is refused.
        """
        with self.by_their_names():
            logs, clips = self._logs(session)
            places = places_for(config, logs)
            shown = {
                "head": HEAD, "rows": [*further_rows(logs, self.root)],
                "notes": [*unused_clips(clips, logs)],
                "places": [{"key": _key(place), "says": place_text(place, logs),
                            "on": _key(place) not in left_out} for place in places]}
            return shown | self._fitted(session, config, logs, left_out)

    def _fitted(
        self, session: OpenSession, config: Config, logs: Sequence[FurtherLog],
        left_out: Collection[str],
    ) -> Json:
        with_them = config_from(with_further(config, logs, _on(config, logs, left_out)))
        averaged = Outcome(session.config, session.rates, session.recordings, (), None)
        before = run_stages(config, session.context, before=averaged)
        after = run_stages(with_them, session.context)
        if fault := implausible(after):
            raise ConfigError(f"with these logs {fault}")
        folder = session.context.cache.parent if session.context.cache else config.output_folder
        return {"figures": [*pose_change_lines(before, after), next_line(after, folder)]}

    @contextmanager
    def kept_in(
        self, session: OpenSession, config: Config, left_out: Collection[str]
    ) -> Iterator[YamlSource]:
        """The file of ``config`` with the logs, in a folder of their own beside it, while a block
        runs it, and for good after that.

        Raises
        ------
        ConfigError
            No run takes a log.
        """
        with self.by_their_names():
            logs, _ = self._logs(session)
            target = next(each for each in (self.folder / FOLDER.format(n) for n in count(1))
                          if not each.exists())
            moved: Mapping[Path, Path] = {
                file: target / file.relative_to(self.root) for file in self.files}
            with self.kept_as(target):
                yield with_further(config, logs, _on(config, logs, left_out), moved)


def _key(place: Place) -> str:
    return f"{place.triad} {place.rate}"


def _on(
    config: Config, logs: Sequence[FurtherLog], left_out: Collection[str]
) -> list[Place]:
    return [place for place in places_for(config, logs) if _key(place) not in left_out]
