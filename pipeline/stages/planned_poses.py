"""What recording and planning know of a pose before it is calibrated: its length and its rate."""

import math

import numpy as np

from calib.poses.attitudes import WEDGE_DIRECTIONS, natural_directions
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, ImuLog
from pipeline.config.record_section import SECONDS_PER_POSE, RecordSection

FEWEST_TURNS = 3.0  #: turns of the plate in a pose: over whole turns its tilt averages out; chosen


def first_directions(count: int) -> FloatArray:
    """The first natural directions that are to face up, unit vectors, (count, 3).

    Of a part of the edges those come first that lie in different planes: three of them show all
    misalignments.
    """
    natural = natural_directions()
    is_edge = (natural != 0).sum(axis=1) == 2
    edges = natural[is_edge]
    plane = np.abs(edges).argmin(axis=1)
    turn = [int((plane[:i] == plane[i]).sum()) for i in range(len(edges))]  # which of its plane
    if count < WEDGE_DIRECTIONS:
        natural[is_edge] = edges[np.lexsort((plane, turn))]
    return natural[:count]


def pose_seconds(record: RecordSection | None, rate_rad_s: float | None) -> float:
    """How long a pose is recorded, s: as ``record`` states, and for ``FEWEST_TURNS`` of the plate.

    Parameters
    ----------
    record : RecordSection or None
        The usual length counts where the configuration has no such section.
    rate_rad_s : float or None
        Of the plate; 0 at rest, None where it is not known.
    """
    seconds = SECONDS_PER_POSE if record is None else record.seconds_per_pose
    return max(seconds, FEWEST_TURNS * 2 * math.pi / rate_rad_s) if rate_rad_s else seconds


def less_rest(reading: FloatArray, rest: FloatArray | None) -> FloatArray:
    """A gyroscope's reading (3,) without what it reads at rest (3,), rad/s; as it is without that.
    """
    return reading if rest is None else reading - rest


def sensed_rate(log: ImuLog, gyroscope: TriadSpec | None, rest: FloatArray | None) -> float:
    """The plate's rate as the gyroscope reads it in a log, rad/s; NaN where it was not logged.

    Parameters
    ----------
    log : ImuLog
    gyroscope : TriadSpec or None
        Its data sheet.
    rest : array, shape (3,), or None
        Its reading at rest, rad/s, where that is known.
    """
    if gyroscope is None or not log.has("gyroscope"):
        return math.nan
    return float(np.linalg.norm(less_rest(gyroscope.nominal(log.gyroscope).mean(axis=0), rest)))
