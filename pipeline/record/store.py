"""The folder of a session is its state: data count once they are on disk.

    config.record/state.json            when the session began, the order of the poses
    config.record/raw/001.bin           every byte of the first connection, and of the next
    config.record/raw/001.arrivals.csv  how many bytes had come when, on the session's clock
    config.record/times/...             for each pose, device clock and arrival of every sample
    accelerometer/pose_01.csv ...       the poses, where the configuration names them

A pose appears whole or not at all. Nothing else records that a pose was taken, so a deleted file is
requested again.
"""

import json
import math
import os
import random
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from calib.poses.imu_log import FloatArray
from pipeline.config.load import Config
from pipeline.errors import UnreadableInput, UnwritableOutput
from pipeline.files import write_whole
from pipeline.logs.columns import ACCELEROMETER, GYROSCOPE, TIME
from pipeline.record.blocks import NumberedFiles, RecordingBlock
from pipeline.record.stream import TimedSample

FORMAT = 1  #: version of state.json; raised when its keys change


@dataclass(frozen=True)
class State:
    """Constants of a session: its beginning, and the seed of a random order."""

    began_unix_s: float
    seed: int


class Store:
    """Files of one session; made anew by every start of the command.

    Parameters
    ----------
    config : Config
    wall_clock : callable
        Seconds since 1970.
    """

    def __init__(self, config: Config, wall_clock: Callable[[], float] = time.time) -> None:
        source = config.source.path
        self.folder = source.parent / f"{source.stem}.record"
        self.state = self._load(wall_clock)
        # The wall clock is read once: the session's clock then runs evenly.
        self._offset_s = wall_clock() - self.state.began_unix_s - time.monotonic()

    def _load(self, wall_clock: Callable[[], float]) -> State:
        path = self.folder / "state.json"
        if not path.exists():
            state = State(wall_clock(), random.SystemRandom().randrange(2**31))
            write_whole(path, json.dumps({"format": FORMAT, **vars(state)}, indent=2) + "\n")
            return state
        try:
            read = json.loads(path.read_text(encoding="utf-8"))
            if read["format"] != FORMAT:
                raise ValueError(f"format {read['format']}")
            return State(float(read["began_unix_s"]), int(read["seed"]))
        except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
            raise UnreadableInput(
                f"{path}: is not the state of a session ({error}). The poses are not touched by "
                f"it: delete this file, and the session goes on with a clock of its own."
            ) from error

    def now_s(self) -> float:
        """Seconds since the session began."""
        return self.session_s(time.monotonic())

    def session_s(self, monotonic_s: float) -> float:
        """A reading of ``time.monotonic`` on the session's clock."""
        return monotonic_s + self._offset_s

    def not_before(self, time_s: float) -> None:
        """Continue the clock after ``time_s``, where the computer's clock was set back."""
        self._offset_s += max(0.0, time_s - self.now_s())

    def new_connection(self) -> "RawFile":
        """Files for the bytes of a new connection."""
        folder = self.folder / "raw"
        folder.mkdir(parents=True, exist_ok=True)
        number = 1 + max((int(path.stem) for path in folder.glob("*.bin")
                          if path.stem.isdecimal()), default=0)
        return RawFile(folder / f"{number:03d}.bin")

    def write_pose(
        self, block: RecordingBlock, rows: Sequence[TimedSample], time_s: FloatArray, comment: str
    ) -> Path:
        """Write a pose under the lowest free number, its times first; return its path."""
        path = block.poses.path(block.poses.next_number())
        text = ["sample,device_ticks,heard_s,time_s"]
        text += [f"{row.index},{'' if row.ticks is None else row.ticks},{row.heard_s:.6f},{t:.6f}"
                 for row, t in zip(rows, time_s.tolist(), strict=True)]
        relative = os.path.relpath(path, self.folder.parent).replace(os.sep, "_")
        write_whole(self.folder / "times" / relative, "\n".join(text) + "\n")
        write_whole(path, pose_text(rows, time_s, comment))
        return path

    def clear_halves(self, blocks: Sequence[RecordingBlock]) -> None:
        """Remove what a killed writer left: half poses and half clips."""
        for block in blocks:
            places = block.poses
            for path in places.folder.glob(f".{places.before}*{places.after}.*"):
                path.unlink(missing_ok=True)
            if isinstance(block.clips, NumberedFiles):
                for path in block.clips.folder.glob(f".filming-{block.clips.before}*"):
                    path.unlink(missing_ok=True)


def pose_text(rows: Sequence[TimedSample], time_s: FloatArray, comment: str) -> str:
    """A pose as CSV: time, the triads the device sends, and further columns all rows have."""
    triads = [(names, attribute) for names, attribute in
              ((ACCELEROMETER, "accelerometer"), (GYROSCOPE, "gyroscope"))
              if all(math.isfinite(x) for row in rows for x in getattr(row, attribute))]
    extra = [name for name, _ in rows[0].columns
             if all(name in dict(row.columns) for row in rows)]
    header = [TIME, *(name for names, _ in triads for name in names), *extra]
    lines = [f"# {comment}", ",".join(header)]
    for row, t in zip(rows, time_s.tolist(), strict=True):
        cells = [f"{t:.6f}", *(_number(x) for _, a in triads for x in getattr(row, a))]
        columns = dict(row.columns)
        lines.append(",".join([*cells, *(_number(columns[name]) for name in extra)]))
    return "\n".join(lines) + "\n"


def _number(value: float) -> str:
    return f"{value:.10g}"


class RawFile:
    """Every byte of one connection, on disk at once, and its time of arrival."""

    def __init__(self, path: Path) -> None:
        self.path = path
        # Unbuffered: written data survive the end of this process, however it ends.
        self._bytes: BinaryIO = path.open("xb", buffering=0)
        arrivals = path.with_suffix(".arrivals.csv")
        self._arrivals: BinaryIO = arrivals.open("xb", buffering=0)
        self._arrivals.write(b"bytes,heard_s\n")
        self._count = 0

    def keep(self, data: bytes, heard_s: float) -> None:
        """Append ``data``.

        Raises
        ------
        UnwritableOutput
            The disk is full; what was appended before stays.
        """
        if not data:
            return
        try:
            self._bytes.write(data)
            self._count += len(data)
            self._arrivals.write(f"{self._count},{heard_s:.6f}\n".encode())
        except OSError as error:
            raise UnwritableOutput(
                f"{self.path}: cannot be written ({error.strerror}). Recorded poses are kept. Free "
                f"the space, and go on with the same command."
            ) from error

    def close(self) -> None:
        """Close both files."""
        self._bytes.close()
        self._arrivals.close()
