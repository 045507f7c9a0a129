"""``pipeline.load("config.yaml")``: the calibrations of a session as objects of a notebook."""

from dataclasses import dataclass
from pathlib import Path

from calib.notebook.calibration import Calibration
from calib.poses.imu_log import Triad
from pipeline.config.load import load_config
from pipeline.stages.context import CACHE_NAME, RunContext
from pipeline.stages.rate import SettingRate
from pipeline.stages.run import Outcome, run_stages
from pipeline.stages.user_effects import user_effects


@dataclass(frozen=True, eq=False, repr=False)
class LoadedSession:
    """A session that was run; None for a triad that it does not calibrate.

    ``rates`` are those of the plate settings by name.
    """

    outcome: Outcome
    accelerometer: Calibration | None
    gyroscope: Calibration | None

    @property
    def rates(self) -> dict[str, SettingRate]:
        """The plate settings by name."""
        return dict(self.outcome.rates)

    def __repr__(self) -> str:
        every = [each for each in (self.accelerometer, self.gyroscope) if each is not None]
        return "\n\n".join(map(repr, every)) or "no triad is calibrated"


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

    def calibration(triad: Triad) -> Calibration | None:
        result = outcome.triad(triad)
        if result is None:
            return None
        defined = user_effects(loaded, triad, allow_python)
        names = getattr(loaded, triad).model
        return Calibration(result.calibration.fit.poses,
                           tuple(defined.get(name, name) for name in names), result)

    return LoadedSession(outcome, calibration("accelerometer"), calibration("gyroscope"))
