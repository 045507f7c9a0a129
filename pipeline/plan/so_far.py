"""Results of the poses recorded so far, the most valuable next pose, and refusals of plans."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from calib.errors import CalibrationError, Undetermined
from calib.planning.prospect import BestPose, Prospect
from calib.poses.attitudes import direction_name
from calib.poses.imu_log import TRIADS, Triad
from pipeline.config.load import Config, load_config
from pipeline.errors import PipelineError
from pipeline.plan.outlook import TriadPlan, plan_of
from pipeline.text.formatting import DISPLAY, relative

LITTLE = 0.02  #: share by which a further pose reduces the sds where the poses suffice; a judgement
KNOWN = 1.0  #: relative sd of a scale factor; definition: beyond it the factor is unknown


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
        """The most valuable pose; empty where none is missing."""
        if self.next is None:
            return ""
        falls = ("; the poses do not determine all of it yet" if np.isnan(self.scale_sd) else
                 f": all sds fall by {1 - self.next.shrinks:.0%} in {60 * self.next.minutes:.0f} s")
        return (f"{self.triad}: worth most per minute is {direction_name(self.next.up)}, plate "
                f"{self.next.run}{falls}")


def outlook_so_far(path: Path) -> list[SoFar]:
    """Results that the poses on disk of a configuration determine, triad by triad."""
    try:
        return [_so_far(plan) for plan in plan_of(load_config(path, files_may_be_missing=True))]
    except (PipelineError, CalibrationError):  # errors are reported where it is run
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
        self._lines, self._news = list[str](), list[str]()

    def after(self, said: str) -> list[SoFar]:
        """The results after the pose that ``said`` reports."""
        if said != self._said:
            self._said, self._triads = said, outlook_so_far(self._path)
            lines = [each.line for each in self._triads if each.line]
            self._lines, self._news = lines, [line for line in lines if line not in self._lines]
        return self._triads

    def lines_after(self, said: str) -> list[str]:
        """``said``, and a line for each triad whose results have changed."""
        self.after(said)
        return [said, *self._news]


def require_planned(config: Config) -> None:
    """Refuse a recording whose complete poses would not determine the model.

    Without a section ``record`` nothing is planned. Runs no Python: effects that are written in it
    are left out of the model that is judged.

    Raises
    ------
    Undetermined
        With what is missing, and what to change.
    ConfigError, UnreadableInput, UnusableLog
        As :func:`pipeline.plan.outlook.plan_of`.
    """
    if config.record is None:
        return
    require_sufficient(config.source.path, tuple(plan_of(_without_python(config))))


def require_sufficient(path: Path, plans: Sequence[TriadPlan], *, reasons: bool = True) -> None:
    """Refuse plans whose poses, recorded and missing, do not determine the model.

    Without ``reasons``, which were printed already, the message is one line.

    Raises
    ------
    Undetermined
        With what is missing, and what to change.
    """
    refused = {plan.triad: plan.complete for plan in plans if isinstance(plan.complete, str)}
    if refused:
        first, *others = refused
        why = f"({' and '.join(refused)})"
        if reasons:  # of one triad: those of the other are similar, and `plan` prints all
            why = " ".join([refused[first], *(
                f"The poses of the {triad} will not either." for triad in others)])
        raise Undetermined(
            f"{path}: the planned poses will not determine the model{':' * reasons} {why}"
            f"{'' if reasons else '.'} Record more poses (`record: {{poses: 18}}`), add a plate "
            f"setting, or fit a smaller model; `pipeline plan` shows what each would give.")


def _without_python(config: Config) -> Config:
    written = {name for name, effect in config.effects.items() if effect.python is not None}
    kept = {name: effect for name, effect in config.effects.items() if name not in written}
    changes: dict[str, object] = {"effects": kept}
    for triad in TRIADS:
        section = getattr(config, triad)
        if section is not None:
            model = tuple(name for name in section.model if name not in written)
            changes[triad] = section.model_copy(update={"model": model})
    return config.model_copy(update=changes)
