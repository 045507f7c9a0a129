"""What the poses recorded so far determine, in a line after each pose."""

from pathlib import Path

import numpy as np

from calib.errors import CalibrationError
from calib.planning.prospect import Prospect
from pipeline.config.load import load_config
from pipeline.errors import PipelineError
from pipeline.plan.outlook import TriadPlan, plan_of
from pipeline.text.formatting import DISPLAY, relative

LITTLE = 0.02  #: share by which a further pose reduces the sds where the poses suffice; a judgement


def outlook_lines(path: Path) -> list[str]:
    """A line for each triad that the poses on disk determine by now."""
    try:
        plans = tuple(plan_of(load_config(path, files_may_be_missing=True)))
    except (PipelineError, CalibrationError):  # what is wrong is said where it is asked for
        return []
    return [line for plan in plans if (line := _line(plan))]


def _line(plan: TriadPlan) -> str:
    prospect = plan.at_hand
    if not isinstance(prospect, Prospect) or plan.noise == "unknown":
        return ""
    unit, factor = DISPLAY[plan.triad]
    missing = sum(len(setting.missing) for setting in plan.settings)
    scale, bias = float(np.nanmax(prospect.sd[2])), float(np.nanmax(prospect.sd[1])) * factor
    enough = ""
    if not missing:
        enough = "; complete"
    elif 1 - plan.next_pose.shrinks < LITTLE and prospect.dof >= 1:
        enough = f"; good enough: another pose reduces the sds by less than {LITTLE:.0%}"
    return (f"  {plan.triad}: scale to {relative(scale)}, bias to {bias:.2g} {unit} by "
            f"{plan.recorded} poses{enough}")
