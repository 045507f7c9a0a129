"""Requirements of a block, and results of the pose detector."""

from dataclasses import dataclass
from typing import Literal

from calib.poses.data_sheet import Specs
from calib.poses.imu_log import FloatArray
from pipeline.record.stream import TimedSample

Phase = Literal["moving", "unsteady", "taking", "repeats", "between", "wrong", "taken"]


@dataclass(frozen=True, eq=False)
class Status:
    """State to show.

    ``reading`` (6,) is the mean of the last hop in nominal SI units, ``direction`` names the side
    that faces up, ``progress`` runs from 0 to 1 while a pose is taken.
    """

    phase: Phase
    message: str
    direction: str
    progress: float
    reading: FloatArray


@dataclass(frozen=True)
class Refused:
    """A pose that was begun and not completed; ``message`` gives the reason."""

    message: str


@dataclass(frozen=True)
class Complete:
    """The rows of a whole pose, and the index of the wanted direction that it covers."""

    rows: list[TimedSample]
    direction: int


@dataclass(frozen=True, eq=False)
class Task:
    """Requirements of a block.

    Parameters
    ----------
    wanted : array, shape (n, 3)
        Directions to be covered, in the order in which they are suggested.
    specs : mapping of triad to TriadSpec
        Data sheets.
    seconds : float
        Length of a pose.
    rate_rad_s : float or None
        0 at rest; else about how fast the plate turns, None where that is not known.
    rest_rad_s : array, shape (3,), or None
        What the gyroscope reads at rest, where poses at rest show it.
    """

    wanted: FloatArray
    specs: Specs
    seconds: float
    rate_rad_s: float | None
    rest_rad_s: FloatArray | None

    @property
    def turns(self) -> bool:
        """Whether the plate should turn."""
        return self.rate_rad_s != 0.0
