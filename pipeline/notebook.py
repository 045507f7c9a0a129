"""``pipeline.load("config.yaml")``: the calibrations of a session as objects of a notebook."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from calib.notebook.calibration import Calibration
from calib.poses.imu_log import Triad
from pipeline.config.load import load_config
from pipeline.stages.context import CACHE_NAME, RunContext
from pipeline.stages.rate import SettingRate
from pipeline.stages.run import Outcome, run_stages


@dataclass(frozen=True, eq=False, repr=False)
class LoadedSession:
    """A session that was run; ``triads`` are its calibrations by name."""

    outcome: Outcome
    triads: Mapping[Triad, Calibration]

    @property
    def accelerometer(self) -> Calibration | None:
        """The calibrated accelerometer; None where the session has none."""
        return self.triads.get("accelerometer")

    @property
    def gyroscope(self) -> Calibration | None:
        """The calibrated gyroscope; None where the session has none."""
        return self.triads.get("gyroscope")

    @property
    def rates(self) -> dict[str, SettingRate]:
        """The plate settings by name."""
        return dict(self.outcome.rates)

    def __repr__(self) -> str:
        return "\n\n".join(map(repr, self.triads.values())) or "no triad is calibrated"

    def _repr_html_(self) -> str:
        return "".join(one._repr_html_() for one in self.triads.values()) or repr(self)


def load(config: str | Path, *, allow_python: bool = False) -> LoadedSession:
    """Run a configuration and give its calibrations.

    Parameters
    ----------
    config : path
        A configuration, or the folder that holds ``config.yaml``.
    allow_python : bool
        Whether Python files that it names for user-defined effects may run.

    Raises
    ------
    PipelineError, CalibrationError, VisionError
        As ``pipeline run`` refuses the session.
    """
    path = Path(config)
    path = path / "config.yaml" if path.is_dir() else path
    loaded = load_config(path)
    folder = loaded.output_folder / CACHE_NAME
    outcome = run_stages(loaded, RunContext(folder if folder.is_dir() else None,
                                            allow_python=allow_python))

    triads = {}
    for result in outcome.triads:
        defined = result.made_from.defined
        triads[result.triad] = Calibration(
            result.calibration.fit.poses,
            tuple(defined.get(name, name) for name in result.made_from.section.model), result,
            tuple(defined.values()), result.made_from.options)
    return LoadedSession(outcome, triads)
