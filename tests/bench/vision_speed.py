"""Wall time of ``pipeline rate`` against a bare decoding loop over the same clip, and its memory.

    python -m tests.bench.vision_speed [--seconds 10,20,40,60] [--sizes 640x480,1920x1080]
                                       [--minutes 10] [--enlarged 3840x2160] [--rounds 5]
                                       [--keep DIR]

Also measured are a clip of a plate at rest, which is refused, and, for the memory, the longest one
repeated (copied without encoding again; ``--minutes 0`` leaves that out) and the shortest of the
last size enlarged and encoded with three reference frames (``--enlarged ''`` leaves that out).

All are whole processes, started in turn: the loop, the vision stage by itself, and the command as a
user types it. The figures are the best of the rounds, the ratio the median of those of the rounds.
CPU time is printed beside wall time: on a machine that does other work as well, it says how much of
the ratio is ours. The processes find their bytecode as those of an installed program do, whatever
the environment says about writing it. Clips are rendered in a process of their own: the peak
memory of a process begins with that of the one that started it.
"""

import argparse
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

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


def made(path: Path, make: Callable[..., None], *arguments: object) -> Path:
    """The clip, made in a process of its own where it is not there yet."""
    if not path.exists():
        process = multiprocessing.get_context("spawn").Process(target=make, args=(path, *arguments))
        process.start()
        process.join()
        if process.exitcode:
            raise ChildProcessError(f"{path} could not be made")
    return path


def clip(folder: Path, seconds: float, size: tuple[int, int], rate_rad_s: float) -> Path:
    """At 30 frames per second; of a plate at rest where the rate is 0."""
    w, h = size
    path = folder / f"speed_{w}x{h}_{seconds:g}{'' if rate_rad_s else '_rest'}.mp4"
    return made(path, render, seconds, size, rate_rad_s)


def render(path: Path, seconds: float, size: tuple[int, int], rate_rad_s: float) -> None:
    """Film the plate."""
    from tests.world.film import film
    from tests.world.plate import PlateMotion
    from tests.world.scene import Scene

    w, h = size
    scene = Scene(width_px=w, height_px=h, centre_px=(0.48 * w, 0.5 * h), radius_px=0.4 * h)
    film(path, PlateMotion(rate_rad_s), scene, fps=30, seconds=seconds)


def enlarge(path: Path, source: Path, size: tuple[int, int]) -> None:
    """The clip in another size, three reference frames and three in between, as phones do."""
    import av

    with av.open(str(source)) as old, av.open(str(path), "w") as new:
        track = old.streams.video[0]
        stream = new.add_stream("libx264", rate=track.average_rate)
        stream.width, stream.height = size
        stream.pix_fmt, stream.options = "yuv420p", {"crf": "28", "preset": "medium"}
        stream.codec_context.time_base = track.time_base
        for frame in old.decode(track):
            larger = frame.reformat(*size, interpolation="BILINEAR")
            larger.pts, larger.time_base = frame.pts, frame.time_base
            new.mux(stream.encode(larger))
        new.mux(stream.encode())


def repeat(path: Path, source: Path, times: int) -> None:
    """The clip several times in a row."""
    import av

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
    parser.add_argument("--enlarged", default="3840x2160")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    folder = options.keep or Path(tempfile.mkdtemp(prefix="speed_"))
    folder.mkdir(parents=True, exist_ok=True)
    lengths = [float(each) for each in options.seconds.split(",")]
    for size in map(pixels, options.sizes.split(",")):
        clips = [clip(folder, seconds, size, RATE) for seconds in lengths]
        if options.minutes:
            times = round(options.minutes * 60 / lengths[-1])
            longest = clips[-1].with_name(f"{clips[-1].stem}_x{times}.mp4")
            clips.append(made(longest, repeat, clips[-1], times))
        for arguments in PROCESSES.values():
            cost(arguments, clips[0])  # writes the bytecode
        for path in (*clips, clip(folder, lengths[0], size, 0.0)):
            report(path, options.rounds)
    if options.enlarged:
        path = clips[0].with_name(f"speed_{options.enlarged}_{lengths[0]:g}.mp4")
        report(made(path, enlarge, clips[0], pixels(options.enlarged)), options.rounds)


def pixels(size: str) -> tuple[int, int]:
    """Width and height."""
    w, h = map(int, size.split("x"))
    return w, h


def report(path: Path, count: int) -> None:
    """Print what each process takes over a clip."""
    # The stage by itself ends in an error where the clip is refused; the command says so.
    names = [name for name in PROCESSES if name != "vision stage" or "rest" not in path.stem]
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
