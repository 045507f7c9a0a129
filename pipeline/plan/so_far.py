"""What the poses recorded so far determine, and which one is worth most next."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from calib.errors import CalibrationError
from calib.planning.prospect import BestPose, Prospect
from calib.poses.attitudes import direction_name
from calib.poses.imu_log import Triad
from pipeline.config.load import load_config
from pipeline.errors import PipelineError
from pipeline.plan.outlook import TriadPlan, plan_of
from pipeline.text.formatting import DISPLAY, relative

LITTLE = 0.02  #: share by which a further pose reduces the sds where the poses suffice; a judgement


KNOWN = 1.0  #: relative sd of a scale factor; definition: beyond it nothing is known of it


@dataclass(frozen=True, eq=False)
class SoFar:
    """One triad after a pose.

    Attributes
    ----------
    triad : str
    poses : int
        Recorded ones.
    scale_sd : float
        Largest of the axes, relative; NaN where the poses do not determine it.
    bias_sd : float
        The same of the bias, in the shown unit.
    next : BestPose or None
        The missing pose that is worth most per minute; None where none is missing.
    enough : str
        Why more no longer pays; empty where it does.
    """

    triad: Triad
    poses: int
    scale_sd: float
    bias_sd: float
    next: BestPose | None
    enough: str

    @property
    def line(self) -> str:
        """The sds in a line; empty where there are none yet."""
        if np.isnan(self.scale_sd):
            return ""
        return (f"  {self.triad}: scale to {relative(self.scale_sd)}, bias to {self.bias_sd:.2g} "
                f"{DISPLAY[self.triad][0]} by {self.poses} poses"
                f"{'; ' if self.enough else ''}{self.enough}")

    @property
    def advice(self) -> str:
        """The pose that is worth most; empty where none is missing."""
        if self.next is None:
            return ""
        falls = ("; the poses do not determine all of it yet" if np.isnan(self.scale_sd) else
                 f": all sds fall by {1 - self.next.shrinks:.0%} in {60 * self.next.minutes:.0f} s")
        return (f"{self.triad}: worth most per minute is {direction_name(self.next.up)}, plate "
                f"{self.next.run}{falls}")


def outlook_so_far(path: Path) -> list[SoFar]:
    """What the poses on disk of a configuration determine, triad by triad."""
    try:
        return [_so_far(plan) for plan in plan_of(load_config(path, files_may_be_missing=True))]
    except (PipelineError, CalibrationError):  # what is wrong is said where it is asked for
        return []


def _so_far(plan: TriadPlan) -> SoFar:
    prospect, following = plan.at_hand, plan.next_planned
    scale = bias = np.nan
    enough = ""
    if isinstance(prospect, Prospect) and plan.noise != "unknown":
        scale = float(np.nanmax(prospect.sd[2]))
        bias = float(np.nanmax(prospect.sd[1])) * DISPLAY[plan.triad][1]
    if not scale < KNOWN:
        scale = bias = np.nan
    elif following is None:
        enough = "complete"
    elif isinstance(prospect, Prospect) and prospect.dof and 1 - following.shrinks < LITTLE:
        enough = f"good enough: another pose reduces the sds by less than {LITTLE:.0%}"
    return SoFar(plan.triad, plan.recorded, scale, bias, following if plan.recorded else None,
                 enough)


class Outlook:
    """The outlook after each pose, read from the disk once for all displays of it."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._said, self._triads = "", list[SoFar]()

    def after(self, said: str) -> list[SoFar]:
        """What the poses determine after the pose of which ``said`` tells."""
        if said != self._said:
            self._said, self._triads = said, outlook_so_far(self._path)
        return self._triads
