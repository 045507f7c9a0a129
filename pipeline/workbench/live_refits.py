"""Exact refits of an open session: with any set of effects, without any poses.

Each is made as in a run, from the configuration that the screen would write, so that its digits are
those of ``pipeline add``. Logs are read once; leaving a pose out leaves out its mean.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from threading import RLock
from typing import Any, TypeVar

from calib.effects.catalogue import BASE
from calib.errors import CalibrationError
from calib.fit.validation.leave_one_out import compare
from calib.poses.imu_log import ImuLog, Triad
from pipeline.config.load import load_config
from pipeline.config.types import STOPPED
from pipeline.config.yaml_text import YamlSource
from pipeline.errors import ConfigError
from pipeline.exclusion import placed_poses
from pipeline.report.triad.refit_table import changes_json
from pipeline.report.triad.refitted import Refitted, refitted_json
from pipeline.results.json_values import Json
from pipeline.stages.context import RunContext
from pipeline.stages.fittable import require_fittable
from pipeline.stages.plate_settings import measure_rates
from pipeline.stages.poses import average_recordings
from pipeline.stages.rate import SettingRate
from pipeline.stages.run import check_session
from pipeline.stages.session_logs import settings_of
from pipeline.stages.triads import TriadInput, triad_input
from pipeline.text.formatting import DISPLAY
from pipeline.workbench.held_out import HeldOut
from pipeline.workbench.state import Screen, TriadScreen, config_of, recordings_without, source_of

MOST_KEPT = 200_000  #: poses in the fits that are kept; about 300 bytes each. Chosen
T = TypeVar("T")


class OpenSession:
    """The configuration on disk, its averaged poses, and the requested refits.

    Raises
    ------
    PipelineError, CalibrationError, VisionError
        As a run of it.
    """

    def __init__(self, path: Path, cache: Path, allow_python: bool) -> None:
        self.config = load_config(path)
        self.context = RunContext(cache, allow_python=allow_python)
        self.rates: Mapping[str, SettingRate] = measure_rates(self.config, self.context)
        self._kept: dict[tuple[Any, ...], Any] = {}
        self.held_out: HeldOut | None = None
        self._lock = RLock()
        logs = check_session(self.config)
        self._turning_logs: dict[tuple[str, str], Sequence[ImuLog]] = {
            (triad, setting.rate): logs[setting].logs for triad in self.config.triads
            for setting in settings_of(self.config, triad) if setting.rate != STOPPED}
        self.recordings = average_recordings(self.config, logs, self.rates)
        placed = {triad: placed_poses(self.config, self.recordings, triad)
                  for triad in self.config.triads}
        self.sections = {triad: used for triad, (used, _) in placed.items()}
        self._excluded = {triad: out for triad, (_, out) in placed.items()}

    def turning_logs(self, triad: Triad, rate: str) -> Sequence[ImuLog]:
        """The logs of a triad's poses at a setting of the plate."""
        return self._turning_logs.get((triad, rate), ())

    def source(self, state: Screen) -> YamlSource:
        """The configuration that the screen would write."""
        return source_of(self.config, state, self.sections, self._excluded)

    def added(self, triad: Triad) -> tuple[str, ...]:
        """The added effects of the file's model."""
        return tuple(name for name in self.config.triads[triad].model if name not in BASE)

    def answer(self, state: Screen, triad: Triad, guesses: Sequence[str]) -> Json:
        """The refit of one triad on the screen, with the value of each change of its model.

        Raises
        ------
        CalibrationError, PipelineError
            Its poses do not determine it, or the state is none of this session.
        """
        answer = self._once(("answer", tuple(guesses), *_key(state, triad)),
                            lambda: self._answered(state, triad, guesses))
        return answer | self.predicted(state, triad)

    def predicted(self, state: Screen | None, triad: Triad) -> Json:
        """The poses of the held-out session by the model on the screen; nothing without one.

        Without a ``state`` the model is that of the file.

        Raises
        ------
        CalibrationError
            The poses of this session do not determine it.
        """
        if self.held_out is None:
            return {}
        of_file = self.refitted(self.as_run(), triad).calibration
        shown = of_file if state is None else self.refitted(state, triad).calibration
        return {"held_out": self.held_out.predicted(triad, shown.correction, of_file)
                | {"name": self.held_out.name}}

    def as_run(self) -> Screen:
        """The screen that shows the file."""
        return Screen({each: TriadScreen(self.added(each)) for each in self.sections}, {})

    def _answered(self, state: Screen, triad: Triad, guesses: Sequence[str]) -> Json:
        def refit_of(names: Sequence[str]) -> Refitted | None:
            now = replace(state.triads[triad], ticked=tuple(names))
            try:
                return self.refitted(replace(state, triads={**state.triads, triad: now}), triad)
            except (CalibrationError, ConfigError):
                return None

        ticked = state.triads[triad].ticked
        refitted = self.refitted(state, triad)
        steps = [refit_of(ticked[:k]) for k in range(len(ticked))] + [refitted]
        out, factor = state.triads[triad].out, DISPLAY[triad][1]
        answer = refitted_json(refitted) | {
            "steps": [] if None in steps else [
                {"chi2": each.fit.chi2, "dof": each.fit.dof} for each in steps if each],
            "left_out": [pose.left_out * factor for pose in refitted.comparison.poses],
        } | changes_json(refit_of, self.added(triad), ticked, refitted,
                         self.config.source.path, guesses)
        return answer | self._with_poses_out(answer, state, triad, out) if out else answer

    def _with_poses_out(
        self, answer: Json, state: Screen, triad: Triad, out: Sequence[str]
    ) -> Json:
        """Residuals of all poses of the page: left-out poses as predicted by the fit without them,
        None for a pose outside its run.
        """
        labels, factor = self.sections[triad], DISPLAY[triad][1]
        every = self.input_of(state, triad).recorded.excluded(self.refitted(state, triad).fit)
        predicted = {one.label: one.predicted.residual.residual for one in every if one.predicted}
        kept = [label for label in labels if label not in out]
        lost = {label: predicted[label] * factor if label in predicted else None for label in out}
        values = {key: lost | dict(zip(kept, answer[key], strict=True))
                  for key in ("residual", "left_out")}
        return {key: [each[label] for label in labels] for key, each in values.items()}

    def _once(self, key: tuple[Any, ...], make: Callable[[], T]) -> T:
        """What ``make`` gives, kept until there is much."""
        with self._lock:
            if len(self._kept) * sum(map(len, self.sections.values())) > MOST_KEPT:
                self._kept.clear()
            if key not in self._kept:
                self._kept[key] = make()
            kept: T = self._kept[key]
            return kept

    def refitted(self, state: Screen, triad: Triad) -> Refitted:
        """The refit of the triad.

        Raises
        ------
        CalibrationError
            The poses do not determine it.
        """
        def refit() -> Refitted:
            calibration = self.input_of(state, triad).calibrated(seek_mistakes=False)
            return Refitted(calibration, compare(calibration.fit))

        return self._once(("fit", *_key(state, triad)), refit)

    def input_of(self, state: Screen, triad: Triad) -> TriadInput:
        """Input of the triad's calibration on this screen, with its model.

        Raises
        ------
        CalibrationError, PipelineError
            The screen is none of this session.
        """
        config = config_of(self.config, state, self.sections)
        require_fittable(config)

        def read() -> TriadInput:
            beside = (self.refitted(state, "accelerometer").calibration
                      if triad != "accelerometer" and "accelerometer" in state.triads else None)
            plates = {name: rate.plate for name, rate in self.rates.items()}
            return triad_input(triad, config, plates,
                               recordings_without(self.recordings, self.config, config), beside,
                               allow_python=self.context.allow_python)

        from_poses = self._once(("input", *_key(state, triad, model=False)), read)
        return replace(from_poses, section=config.triads[triad])


def _key(state: Screen, triad: Triad, model: bool = True) -> tuple[Any, ...]:
    """Key of a fit of one triad: its own state, and for a gyroscope that of the accelerometer."""
    mine, other = state.triads[triad], state.triads.get("accelerometer")
    return (triad, mine.ticked if model else None, mine.out,
            other if triad == "gyroscope" else None)
