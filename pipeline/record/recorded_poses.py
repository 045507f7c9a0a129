"""The recorded poses of a session, and the messages on a block and on a pose."""

from dataclasses import dataclass
from math import isnan

import numpy as np

from calib.errors import CalibrationError
from calib.numbers import NO_LENGTH
from calib.poses.attitudes import NEAR_COSINE
from calib.poses.averaging.average_pose import average_pose
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.data_sheet import Specs, TriadSpec
from calib.poses.imu_log import FloatArray, ImuLog
from calib.poses.runs.ideal_ring import ADVISED_TILT
from pipeline.errors import PipelineError
from pipeline.logs.read import read_log
from pipeline.record.blocks import RecordingBlock
from pipeline.record.stream import Stream, TimedSample
from pipeline.stages.pose_means import less_rest, sensed_rate
from pipeline.text.formatting import count

LOST_SHARE = 0.02  #: share of a pose's samples from which the loss is reported


def introduction(block: RecordingBlock, missing: int, recorded: int) -> str:
    """Instruction for a block, in a line."""
    so_far = f", {recorded} are recorded" if recorded else ""
    where = f"on the plate turning at '{block.rate}'" if block.turns else "with the plate stopped"
    where += f", with {ADVISED_TILT}" if block.leans else ""
    return (f"{count(missing, 'pose')} of {block.seconds:g} s {where}{so_far}. Ctrl-C stops; "
            f"nothing is lost.")


def loss_of(rows: list[TimedSample], stream: Stream) -> str:
    """Message on samples lost within a pose; empty if there are none to speak of."""
    first, last = rows[0].ticks, rows[-1].ticks
    clock, rate_hz = stream.parser.clock, stream.rate_hz
    if first is None or last is None or clock is None or rate_hz is None:
        return ""
    sent = last - first + 1 if clock.tick_s is None else (last - first) * clock.tick_s * rate_hz + 1
    share = 1 - len(rows) / sent
    return f"; {100 * share:.0f} % of its samples were lost" if share > LOST_SHARE else ""


@dataclass(frozen=True, eq=False)
class RecordedPoses:
    """The poses of a block.

    ``covered`` are indices of wanted directions, ``means`` the averaged poses, ``end_s`` the latest
    time in them, ``unusable`` gives a reason for each file that is not a pose.
    """

    covered: tuple[int, ...]
    means: tuple[PoseMean, ...]
    end_s: float
    unusable: tuple[str, ...]


def read_recorded_poses(
    block: RecordingBlock, wanted: FloatArray, specs: Specs, rest: FloatArray | None
) -> RecordedPoses:
    """Read the poses of ``block`` that exist; ``wanted`` (n, 3) are the directions to cover."""
    covered, means, unusable, end_s = [], [], [], 0.0
    for path in block.poses.existing():
        try:
            log = read_log(path)
            mean = average_pose(log, specs, pose_rate(block, log, specs.get("gyroscope"), rest))
        except (PipelineError, CalibrationError) as error:
            unusable.append(str(error))
            continue
        end_s = max(end_s, float(log.time_s[-1]))
        means.append(mean)
        direction = up_direction(mean, rest)
        cosine = wanted @ direction
        if cosine.max() >= NEAR_COSINE:
            covered.append(int(np.argmax(cosine)))
    return RecordedPoses(tuple(covered), tuple(means), end_s, tuple(unusable))


def pose_rate(
    block: RecordingBlock, log: ImuLog, gyroscope: TriadSpec | None, rest: FloatArray | None
) -> float:
    """The plate's approximate rate in a pose, rad/s: as stated, else by the gyroscope.

    0 without either.
    """
    if block.rate_rad_s is not None:
        return block.rate_rad_s
    rate = sensed_rate(log, gyroscope, rest)
    return 0.0 if isnan(rate) else rate


def up_direction(mean: PoseMean, rest: FloatArray | None) -> FloatArray:
    """Unit vector (3,) of the side that faces up in a pose, in the sensor's axes.

    By the accelerometer; by the turning gyroscope where no accelerometer was logged, ``rest`` (3,)
    being its reading at rest in rad/s.
    """
    vector = mean.accelerometer.mean
    if not np.isfinite(vector).all():
        vector = less_rest(mean.gyroscope.mean, rest)
    return np.asarray(vector / max(float(np.linalg.norm(vector)), NO_LENGTH))
