"""Wall time of the vision stage against a bare decoding loop over the same clip, and its memory.

    python -m tests.bench.vision_speed [--seconds 60] [--minutes 10] [--keep DIR]

Both are whole processes, started in turn, best of three. The long clip is the short one repeated
(copied without encoding again), for the memory.
"""

import argparse
import subprocess
import sys
import tempfile
import time
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
from vision.rate import measure_rate
from vision.timebase import Timebase
from vision.track import track_phase
rate = measure_rate(track_phase(sys.argv[1]), timebase=Timebase())
"""
PEAK = """
import resource
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3)
"""
ROUNDS = 3
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


def timed(code: str, path: Path) -> tuple[float, str]:
    """Wall seconds of a Python process, and what it prints."""
    start = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)], check=True, capture_output=True, text=True
    )
    return time.perf_counter() - start, done.stdout


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--minutes", type=int, default=10)
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    folder = options.keep or Path(tempfile.mkdtemp(prefix="speed_"))
    short = clip(folder, options.seconds)
    long = repeated(short, round(options.minutes * 60 / options.seconds))
    for path in (short, long):
        bare, stage = [], []
        for _ in range(ROUNDS):
            bare.append(timed(BARE, path)[0])
            stage.append(timed(STAGE, path)[0])
        peak = float(timed(STAGE + PEAK, path)[1])
        print(
            f"{path.name}: bare cv2 loop {min(bare):.2f} s, vision stage {min(stage):.2f} s, "
            f"ratio {min(stage) / min(bare):.2f}, peak memory {peak:.0f} MB",
            flush=True,
        )


if __name__ == "__main__":
    main()
