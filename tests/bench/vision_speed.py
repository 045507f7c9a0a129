"""Wall time of ``pipeline rate`` against a bare decoding loop over the same clip, and its memory.

    python -m tests.bench.vision_speed [--seconds 10,20,40,60] [--sizes 640x480,1920x1080]
                                       [--minutes 10] [--rounds 5] [--keep DIR]

Also measured are a clip of a plate at rest, which is refused, and the longest one repeated (copied
without encoding again), for the memory; ``--minutes 0`` leaves that out.

All are whole processes, started in turn: the loop, the vision stage by itself, and the command as a
user types it. The figures are the best of the rounds, the ratio the median of those of the rounds.
CPU time is printed beside wall time: on a machine that does other work as well, it says how much of
the ratio is ours. The processes find their bytecode as those of an installed program do, whatever
the environment says about writing it.
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
REFUSED = 4  # exit code of the command
RATE = 2 * np.pi / 3  # a whole number of turns in 60 s: the clip repeats without a seam


def clip(folder: Path, seconds: float, size: tuple[int, int], rate_rad_s: float) -> Path:
    """At 30 frames per second; of a plate at rest where the rate is 0."""
    w, h = size
    path = folder / f"speed_{w}x{h}_{seconds:g}{'' if rate_rad_s else '_rest'}.mp4"
    if not path.exists():
        scene = Scene(width_px=w, height_px=h, centre_px=(0.48 * w, 0.5 * h), radius_px=0.4 * h)
        film(path, PlateMotion(rate_rad_s), scene, fps=30, seconds=seconds)
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
    """Run Python with these arguments and the clip, its bytecode beside the clip."""
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": str(path.parent / "bytecode")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    start = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, *arguments, str(path)],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment,
    )
    _, status, used = os.wait4(process.pid, 0)
    wall_s = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in (0, REFUSED):
        raise subprocess.CalledProcessError(process.returncode, process.args)
    return Cost(wall_s, used.ru_utime + used.ru_stime, used.ru_maxrss / 1e3)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", default="10,20,40,60")
    parser.add_argument("--sizes", default="640x480,1920x1080")
    parser.add_argument("--minutes", type=int, default=10)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    folder = options.keep or Path(tempfile.mkdtemp(prefix="speed_"))
    folder.mkdir(parents=True, exist_ok=True)
    lengths = [float(each) for each in options.seconds.split(",")]
    for text in options.sizes.split(","):
        w, h = map(int, text.split("x"))
        clips = [clip(folder, seconds, (w, h), RATE) for seconds in lengths]
        if options.minutes:
            clips.append(repeated(clips[-1], round(options.minutes * 60 / lengths[-1])))
        for path in (*clips, clip(folder, lengths[0], (w, h), 0.0)):
            report(path, options.rounds)


def report(path: Path, count: int) -> None:
    """Print what each process takes over a clip."""
    # The stage by itself ends in an error where the clip is refused; the command says so.
    names = [name for name in PROCESSES if name != "vision stage" or "rest" not in path.stem]
    for name in names:
        cost(PROCESSES[name], path)  # writes the bytecode
    rounds = [{name: cost(PROCESSES[name], path) for name in names} for _ in range(count)]
    print(path.name)
    for name in names:
        costs = [each[name] for each in rounds]
        ratio, cpu = (float(np.median([getattr(each[name], what) /
                                       getattr(each["bare cv2 loop"], what) for each in rounds]))
                      for what in ("wall_s", "cpu_s"))
        print(f"  {name:15s} {min(c.wall_s for c in costs):6.2f} s wall, "
              f"{min(c.cpu_s for c in costs):6.2f} s CPU, ratio {ratio:5.2f} wall {cpu:5.2f} CPU, "
              f"peak memory {max(c.peak_mb for c in costs):4.0f} MB", flush=True)


if __name__ == "__main__":
    main()
