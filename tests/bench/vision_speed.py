"""Wall time of ``pipeline rate`` against a bare decoding loop over the same clip, and its memory.

    python -m tests.bench.vision_speed [--seconds 60] [--minutes 10] [--rounds 5] [--keep DIR]

All are whole processes, started in turn: the loop, the vision stage by itself, and the command as
a user types it. The figures are the best of the rounds. CPU time is printed beside wall time: on a
machine that does other work as well, it says how much of the ratio is ours. The long clip is the
short one repeated (copied without encoding again), for the memory.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import av
import numpy as np

from tests.world.film import film
from tests.world.plate import PlateMotion
from tests.world.scene import Scene

BARE = """
import sys, cv2
capture = cv2.VideoCapture(sys.argv[1])
while capture.read()[0]:
    pass
"""
STAGE = """
import sys
from vision.rate.measure import measure_rate
from vision.rate.timebase import Timebase
from vision.tracking.track import track_phase
rate = measure_rate(track_phase(sys.argv[1]), timebase=Timebase())
"""
PROCESSES = {
    "bare cv2 loop": ("-c", BARE),
    "vision stage": ("-c", STAGE),
    "pipeline rate": ("-m", "pipeline", "rate"),
}
RATE = 2 * np.pi / 3  # a whole number of turns in 60 s: the clip repeats without a seam


def clip(folder: Path, seconds: float) -> Path:
    """640x480 at 30 frames per second."""
    path = folder / f"speed_{seconds:g}.mp4"
    if not path.exists():
        scene = Scene(width_px=640, height_px=480, centre_px=(310, 240), radius_px=190)
        film(path, PlateMotion(RATE), scene, fps=30, seconds=seconds)
    return path


def repeated(source: Path, times: int) -> Path:
    """The clip several times in a row."""
    path = source.with_name(f"{source.stem}_x{times}.mp4")
    if path.exists():
        return path
    with av.open(str(path), "w") as new:
        stream, shift = None, 0
        for _ in range(times):
            with av.open(str(source)) as old:
                track = old.streams.video[0]
                if stream is None:
                    stream = new.add_stream_from_template(track)
                for packet in old.demux(track):
                    if packet.dts is None:
                        continue
                    packet.pts += shift
                    packet.dts += shift
                    packet.stream = stream
                    new.mux(packet)
                shift += track.duration
    return path


@dataclass(frozen=True)
class Cost:
    """What a process took."""

    wall_s: float
    cpu_s: float
    peak_mb: float


def cost(arguments: tuple[str, ...], path: Path) -> Cost:
    """Run Python with these arguments and the clip."""
    start = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, *arguments, str(path)],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )
    _, status, used = os.wait4(process.pid, 0)
    wall_s = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, process.args)
    return Cost(wall_s, used.ru_utime + used.ru_stime, used.ru_maxrss / 1e3)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--minutes", type=int, default=10)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    folder = options.keep or Path(tempfile.mkdtemp(prefix="speed_"))
    short = clip(folder, options.seconds)
    long = repeated(short, round(options.minutes * 60 / options.seconds))
    for path in (short, long):
        rounds = [
            {name: cost(arguments, path) for name, arguments in PROCESSES.items()}
            for _ in range(options.rounds)
        ]
        bare_s = min(each["bare cv2 loop"].wall_s for each in rounds)
        print(path.name)
        for name in PROCESSES:
            costs = [each[name] for each in rounds]
            wall_s = min(each.wall_s for each in costs)
            print(
                f"  {name:15s} {wall_s:6.2f} s wall, {min(c.cpu_s for c in costs):6.2f} s CPU, "
                f"ratio {wall_s / bare_s:5.2f}, "
                f"peak memory {max(c.peak_mb for c in costs):4.0f} MB",
                flush=True,
            )


if __name__ == "__main__":
    main()
