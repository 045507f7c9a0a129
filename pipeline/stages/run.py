"""Runs the stages of a configuration one after the other."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from calib.mounting.mounting import Mounting
from pipeline.config.load import Config
from pipeline.stages.context import Workplace
from pipeline.stages.poses import Recordings
from pipeline.stages.rate import SettingRate
from pipeline.stages.table import STAGES
from pipeline.stages.triads import TriadResult, require_fittable

OnStage = Callable[[str, Any], None]


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a run has made: one artefact for each stage of :data:`pipeline.stages.table.STAGES`."""

    config: Config
    rates: Mapping[str, SettingRate]
    recordings: Recordings
    accelerometer: TriadResult | None
    gyroscope: TriadResult | None
    installation: Mounting | None

    @property
    def triads(self) -> tuple[TriadResult, ...]:
        """The triads that were calibrated, accelerometer first."""
        return tuple(each for each in (self.accelerometer, self.gyroscope) if each is not None)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the user should know, a paragraph each, in the order of the stages."""
        of_rates = tuple(w for rate in self.rates.values() for w in rate.warnings)
        of_triads = tuple(w for triad in self.triads for w in triad.warnings)
        of_mounting = self.installation.notes if self.installation else ()
        return of_rates + self.recordings.warnings + of_triads + of_mounting


def run_stages(config: Config, workplace: Workplace, on_stage: OnStage) -> Outcome:
    """Run every stage; ``on_stage`` is told each artefact as soon as it is made.

    Raises
    ------
    PipelineError, CalibrationError, VisionError
        The first stage that refuses ends the run.
    """
    require_fittable(config)
    made: dict[str, Any] = {}
    for stage in STAGES:
        made[stage.name] = stage.make(config, workplace, *(made[name] for name in stage.needs))
        on_stage(stage.name, made[stage.name])
    return Outcome(config, **made)
