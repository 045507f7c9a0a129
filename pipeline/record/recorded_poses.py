"""What of a session is on disk already: poses, the directions they cover, the gyroscope at rest."""

from dataclasses import dataclass

import numpy as np

from calib.errors import CalibrationError
from calib.poses.attitudes import NEAR_COSINE
from calib.poses.averaging import PoseMean, average_pose
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, ImuLog
from pipeline.config.load import Specs
from pipeline.errors import PipelineError
from pipeline.logs.read import read_log
from pipeline.record.block_files import Block


@dataclass(frozen=True, eq=False)
class Taken:
    """The poses of a block.

    ``covered`` are indices of wanted directions, ``means`` the averaged poses, ``end_s`` the
    latest time in them, ``unusable`` says of each file that is no pose why.
    """

    covered: tuple[int, ...]
    means: tuple[PoseMean, ...]
    end_s: float
    unusable: tuple[str, ...]


def taken_poses(block: Block, wanted: FloatArray, specs: Specs, rest: FloatArray | None) -> Taken:
    """Read the poses of ``block`` that are there; ``wanted`` (n, 3) are the directions asked."""
    covered, means, unusable, end_s = [], [], [], 0.0
    for path in block.poses.there():
        try:
            log = read_log(path)
            mean = average_pose(log, *specs, rate_of_pose(block, log, specs[1], rest))
        except (PipelineError, CalibrationError) as error:
            unusable.append(str(error))
            continue
        end_s = max(end_s, float(log.time_s[-1]))
        means.append(mean)
        direction = up_of(mean, rest)
        cosine = wanted @ direction
        if cosine.max() >= NEAR_COSINE:
            covered.append(int(np.argmax(cosine)))
    return Taken(tuple(covered), tuple(means), end_s, tuple(unusable))


def rate_of_pose(
    block: Block, log: ImuLog, gyroscope: TriadSpec | None, rest: FloatArray | None
) -> float:
    """About how fast the plate turned in a pose: as stated, else as the gyroscope feels it."""
    if block.rate_rad_s is not None:
        return block.rate_rad_s
    if gyroscope is None or not log.has("gyroscope"):
        return 0.0
    felt = gyroscope.nominal(log.gyroscope).mean(axis=0)
    return float(np.linalg.norm(felt - (np.zeros(3) if rest is None else rest)))


def up_of(mean: PoseMean, rest: FloatArray | None) -> FloatArray:
    """Unit vector (3,) of the side that faces up in a pose."""
    vector = mean.accelerometer.mean
    if not np.isfinite(vector).all():
        vector = mean.gyroscope.mean - (np.zeros(3) if rest is None else rest)
    return np.asarray(vector / max(float(np.linalg.norm(vector)), 1e-300))


def rest_of(means: tuple[PoseMean, ...]) -> FloatArray | None:
    """What the gyroscope reads at rest, (3,), by poses at rest; None where none was logged."""
    gyro = np.array([mean.gyroscope.mean for mean in means])
    if len(gyro) == 0 or not np.isfinite(gyro).all():
        return None
    return np.asarray(np.median(gyro, axis=0))
