"""What the program makes of a session on disk, beside the truth that the session was made from."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from calib.errors import CalibrationError
from pipeline.config.load import load_config
from pipeline.errors import PipelineError, exit_code_of
from pipeline.stages.context import RunContext
from pipeline.stages.run import Outcome, run_stages
from tests.world.imu import FloatArray
from tests.world.session import Session

CHANCE = 1.0  #: stated sds that a mistake moves a parameter by at least


@dataclass(frozen=True, eq=False)
class Judged:
    """One run.

    Attributes
    ----------
    code : int
        As the command would end.
    refusal : str
        The message of a refusal; empty where there is a result.
    warnings : tuple of str
    verdicts, texts : mapping of triad to str
        Codes of the verdicts, and what they say.
    off : mapping of triad to array, shape (3, 3)
        Estimate less truth over the stated sd; rows misalignment, bias and scale, columns x, y, z.
    """

    code: int
    refusal: str = ""
    warnings: tuple[str, ...] = ()
    verdicts: Mapping[str, str] = field(default_factory=dict)
    texts: Mapping[str, str] = field(default_factory=dict)
    off: Mapping[str, FloatArray] = field(default_factory=dict)

    @property
    def said(self) -> str:
        """Everything that a user reads of it."""
        return " ".join([self.refusal, *self.warnings, *self.texts.values()])

    @property
    def worst(self) -> float:
        """The largest error of a parameter in stated sds; 0 where there is no result."""
        return max((float(np.nanmax(np.abs(each))) for each in self.off.values()), default=0.0)

    def less(self, sound: "Judged") -> "Judged":
        """The same with the errors that the sound session does not have by chance."""
        return replace(self, off={
            triad: np.where(np.abs(off - sound.off[triad]) < CHANCE, 0.0, off)
            for triad, off in self.off.items()})

    @property
    def is_silent(self) -> bool:
        """Whether it says that nothing is missing of every triad, and warns of nothing."""
        return (not self.refusal and not self.warnings
                and all(each == "nothing_missing" for each in self.verdicts.values()))


def judge(config: Path, session: Session) -> Judged:
    """Run the stages of a configuration.

    Parameters
    ----------
    config : Path
    session : Session
        What it was made from.
    """
    try:
        outcome = run_stages(load_config(config), RunContext())
    except (PipelineError, CalibrationError) as error:
        return Judged(exit_code_of(error), str(error))
    return Judged(
        0, "", tuple(outcome.warnings),
        {each.triad: str(each.diagnosis.verdict) for each in outcome.triads},
        {each.triad: each.diagnosis.text for each in outcome.triads},
        _off(outcome, session),
    )


def _off(outcome: Outcome, session: Session) -> dict[str, FloatArray]:
    off = {}
    for each in outcome.triads:
        found, true = each.calibration.parameters, getattr(session, each.triad)
        differences = np.array([
            found.misalignment_rad - true.misalignment_rad,
            found.bias_counts - true.bias_counts,
            found.scale_counts_per_unit - true.scale_counts_per_unit,
        ])
        off[each.triad] = differences / np.array(found.sd)
    return off
