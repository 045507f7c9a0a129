"""A guided recording from the first pose to the last, through interruptions of every kind."""

import random
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from calib.errors import CalibrationError
from calib.poses.attitudes import direction_name
from calib.poses.averaging.average_pose import average_pose
from calib.poses.imu_log import FloatArray, ImuLog
from pipeline.config.load import Config
from pipeline.config.sensor import sensor_specs
from pipeline.errors import DeviceError
from pipeline.record.blocks import (
    Complete,
    NumberedFiles,
    RecordingBlock,
    Refused,
    Status,
    Task,
    recording_blocks,
    require_clip_names,
)
from pipeline.record.connection import SILENT_S, Connection, OpenPort
from pipeline.record.pose_detector import PoseDetector
from pipeline.record.recorded_poses import (
    introduction,
    loss_of,
    pose_rate,
    read_recorded_poses,
)
from pipeline.record.serial_port import PortLost
from pipeline.record.store import Store
from pipeline.record.stream import Stream, TimedSample
from pipeline.stages.pose_means import first_directions, rest_reading
from vision.camera import Camera, CameraFailed

RETRY_S, GIVE_UP_S = 0.5, 120.0  #: after the device has vanished


@dataclass(frozen=True, eq=False)
class RecordingView:
    """Contents of a display; ``wanted`` (n, 3) are the unit vectors of the block's directions."""

    block: RecordingBlock
    wanted: FloatArray
    covered: frozenset[int]
    status: Status
    rate_hz: float
    bad: int

    @property
    def next_wanted(self) -> FloatArray | None:
        """The first unit vector (3,) of those that are still to be recorded; None without one."""
        return next((direction for i, direction in enumerate(self.wanted)
                     if i not in self.covered), None)


class RecordingDisplay(Protocol):
    """Output of a recording."""

    def say(self, text: str) -> None:
        """Show a line that stays."""
        ...

    def show(self, view: RecordingView) -> None:
        """Show the present state; called several times a second."""
        ...

    def recorded(self, text: str) -> None:
        """Show a recorded pose: a line that stays, and a signal."""
        ...


#: Makes the camera that films on the session's clock.
OpenCamera = Callable[[Callable[[], float]], Camera]


@dataclass(frozen=True)
class BlockProgress:
    """Number of recorded poses of a block, and of wanted ones."""

    rate: str
    recorded: int
    wanted: int


def wanted_directions(config: Config, seed: int, block: int) -> FloatArray:
    """Unit vectors (n, 3) that a block should cover, in the suggested order."""
    assert config.record is not None
    directions = first_directions(config.record.poses)
    if config.record.order == "random":
        order = list(range(len(directions)))
        random.Random(seed * 1000 + block).shuffle(order)
        directions = directions[order]
    return directions


class Session:
    """The recording described by a configuration.

    Parameters
    ----------
    config : Config
        Loaded with ``files_may_be_missing``; with a ``record`` section.
    open_port : callable
        Opens the port at a speed; called again after the device was gone.
    display : RecordingDisplay
    open_camera : callable, optional
        Makes a camera on the session's clock; it films the poses on the turning plate.
    sleep : callable
        Waits between tries to reach a device that is gone.
    """

    def __init__(
        self,
        config: Config,
        open_port: OpenPort,
        display: RecordingDisplay,
        open_camera: OpenCamera | None = None,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._config, self._open_port, self._display = config, open_port, display
        self._sleep = sleep
        self._blocks = recording_blocks(config)
        if open_camera is not None:
            require_clip_names(config, self._blocks)
        self._specs = sensor_specs(config.sensor)
        self._store = Store(config)
        self._connection: Connection | None = None
        self._filming = open_camera(self._store.now_s) if open_camera else None

    def run(self) -> tuple[BlockProgress, ...]:
        """Record every block to its end; poses that are on disk are not requested again.

        Raises
        ------
        DeviceError
            The device does not answer, or did not come back.
        """
        self._store.clear_halves(self._blocks)
        done, rest = [], None
        try:
            for i, block in enumerate(self._blocks):
                wanted = wanted_directions(self._config, self._store.state.seed, i)
                recorded = read_recorded_poses(block, wanted, self._specs, rest)
                self._store.not_before(recorded.end_s)
                for message in recorded.unusable:
                    self._display.say(f"not counted: {message}")
                if len(set(recorded.covered)) < len(wanted):
                    self._record(block, wanted, set(recorded.covered), rest)
                    recorded = read_recorded_poses(block, wanted, self._specs, rest)
                if not block.turns:
                    rest = rest_reading(recorded.means)
                done.append(BlockProgress(block.rate, len(set(recorded.covered)), len(wanted)))
        finally:
            if self._connection is not None:
                self._connection.close()
            if self._filming is not None:
                self._filming.close()
        return tuple(done)

    def _record(
        self, block: RecordingBlock, wanted: FloatArray, covered: set[int], rest: FloatArray | None
    ) -> None:
        """Record the missing poses of one block, over as many connections as it takes."""
        self._display.say(introduction(block, len(wanted) - len(covered), len(covered)))
        task = Task(wanted, self._specs, block.seconds, block.rate_rad_s, rest)
        while True:
            try:
                self._connection = self._connection or Connection(
                    self._config, self._open_port, self._store, self._display.say)
                self._lead_poses(self._connection, block, task, covered)
                return
            except PortLost as gone:
                self._stop_filming(keep=False)
                self._display.say(f"{gone} The recorded poses are kept; waiting for the device.")
                self._reconnect(gone)

    def _reconnect(self, gone: PortLost) -> None:
        """Wait until the device is back."""
        if self._connection is not None:
            self._connection.close()
            self._connection = None
        until = time.monotonic() + GIVE_UP_S
        while time.monotonic() < until:
            self._sleep(RETRY_S)
            try:
                self._connection = Connection(
                    self._config, self._open_port, self._store, self._display.say)
            except DeviceError:
                continue
            self._display.say("the device is back")
            return
        raise DeviceError(f"{gone} It did not come back within {GIVE_UP_S:.0f} s. Everything "
                          "recorded is kept: type the same command to go on.") from gone

    def _lead_poses(
        self, connection: Connection, block: RecordingBlock, task: Task, covered: set[int]
    ) -> None:
        detector: PoseDetector | None = None
        phase, restarts = "", connection.stream.restarts
        while detector is None or detector.next_direction is not None:
            rows = connection.rows()
            rate_hz = connection.stream.rate_hz
            if detector is None:
                if rate_hz is None:
                    continue
                detector = PoseDetector(task, rate_hz, tuple(covered))
            if connection.stream.restarts > restarts:  # its clock no longer shows the gap
                restarts = connection.stream.restarts
                rows = []
                self._stop_filming(keep=False)
                detector.begin_again()
                self._display.say("the device started anew; a pose that was begun starts again")
            for event in detector.feed(rows):
                self._handle_event(event, detector, connection.stream, block, task, covered)
            phase, before = detector.status.phase, phase
            if self._filming and block.turns and phase == "taking" and before != "taking":
                assert isinstance(block.clips, NumberedFiles)  # ensured by require_clip_names
                self._filming.start(block.clips.path(block.poses.next_number()))
            status = detector.status
            if connection.silent_s > SILENT_S:
                status = Status("wrong", f"no reading for {connection.silent_s:.0f} s: check the "
                                "cable", "", 0.0, status.reading)
            self._display.show(RecordingView(block, task.wanted, frozenset(covered), status,
                                    rate_hz or 0.0, connection.stream.parser.bad))

    def _handle_event(
        self,
        event: Refused | Complete,
        detector: PoseDetector,
        stream: Stream,
        block: RecordingBlock,
        task: Task,
        covered: set[int],
    ) -> None:
        if isinstance(event, Refused):
            self._stop_filming(keep=False)
            self._display.say(f"not taken: {event.message}")
            return
        time_s = stream.times(event.rows)
        path = block.poses.path(block.poses.next_number())
        name = direction_name(task.wanted[event.direction])
        try:
            self._check(path.name, event.rows, time_s, block, task.rest_rad_s)
        except CalibrationError as error:
            self._stop_filming(keep=False)
            detector.reject()
            self._display.say(f"not taken: {error}")
            return
        filmed = self._stop_filming(keep=True)
        comment = (f"pipeline record: {name}, plate {block.rate}, time by {stream.clock_name()}, "
                   f"{stream.parser.bad} damaged so far")
        self._store.write_pose(block, event.rows, time_s, comment)
        detector.accept(event.direction)
        covered.add(event.direction)
        self._display.recorded(
            f"taken {len(covered)} of {len(task.wanted)}: {name} ({path.name}){filmed}"
            f"{loss_of(event.rows, stream)}")

    def _check(
        self, label: str, rows: list[TimedSample], time_s: FloatArray, block: RecordingBlock,
        rest: FloatArray | None,
    ) -> None:
        """Refuse a pose that the calibration would refuse."""
        log = ImuLog(
            label, time_s,
            np.array([row.accelerometer for row in rows], dtype=float),
            np.array([row.gyroscope for row in rows], dtype=float),
        )
        average_pose(log, self._specs, pose_rate(block, log, self._specs.get("gyroscope"), rest))

    def _stop_filming(self, keep: bool) -> str:
        """End the clip of a pose; a remark on it."""
        if self._filming is None:
            return ""
        try:
            clip = self._filming.stop(keep)
        except CameraFailed as error:
            return f"; without a clip: {error}"
        if clip is None:
            return "; without a clip: the camera delivered no frame" if keep else ""
        return f"; filmed {clip.path.name}, {clip.frames} frames in {clip.seconds:.1f} s"
