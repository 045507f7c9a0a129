"""Recording under load. Run: python -m tests.bench.bench_record {fuzz|baud|kill} [N]

fuzz   N random streams (100000) through every parser: exceptions, seconds, bytes kept at most.
baud   N seconds (60) of a 460800 baud line through pyserial and a recording's own reader: losses.
kill   a guided 18-pose recording killed N times (20) at random moments, beside an undisturbed one.
"""

import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np

from pipeline.devices.xsens import MTDATA, RAW_COUNTED, XsensParser, frame
from pipeline.record.serial_port import SerialPort
from pipeline.record.store import RawFile
from pipeline.record.stream import Stream
from tests.pipeline.devices.random_streams import PARSERS, fuzz
from tests.pipeline.record.play import (
    calibrated,
    evening,
    onlooker,
    playing,
    record,
    record_with_kills,
    write_config,
)
from tests.pipeline.record.playback.pseudo_port import PseudoPort

BAUD, BITS_PER_BYTE = 460800, 10
TICK_S = 0.004
KILL_SPEED = 6.0  #: times as fast as in life: slow enough for every kill to find it running


def fuzz_all(cases: int) -> None:
    """Every parser its share of the cases, each of several streams."""
    each = cases // len(PARSERS)
    for name in PARSERS:
        begun = time.perf_counter()
        samples, most = fuzz(name, each, seed=2026)
        print(f"{name:20s} {each} cases, {samples} samples, no exception, at most {most} bytes "
              f"kept, {time.perf_counter() - begun:.1f} s")


def send_full_speed(port: PseudoPort, seconds: float, sent: list[int]) -> None:
    """MTData as fast as a line of ``BAUD`` carries them; a full terminal loses bytes."""
    begun, count, backlog = time.monotonic(), 0, b""
    per_second = BAUD / BITS_PER_BYTE / (RAW_COUNTED.size + 5)
    while (elapsed := time.monotonic() - begun) < seconds:
        time.sleep(TICK_S)
        due = int(elapsed * per_second)
        backlog = b"".join(frame(MTDATA, RAW_COUNTED.pack(*[32768] * 9, 6400, n % 65536))
                           for n in range(count, due))
        if port.send(backlog) < len(backlog):
            sent.append(-1)
        count = due
    sent.append(count)


def sustained(seconds: float) -> None:
    """The recording's reader: pyserial, raw file, parser, clock."""
    port, sent = PseudoPort(), []
    line = SerialPort(port.name, BAUD)
    with tempfile.TemporaryDirectory() as folder:
        raw = RawFile(Path(folder) / "001.bin")
        stream = Stream(XsensParser(), BAUD / BITS_PER_BYTE / 27)
        sender = threading.Thread(target=send_full_speed, args=(port, seconds, sent))
        cpu = time.process_time()
        sender.start()
        while sender.is_alive():
            data, heard_s = line.read()
            raw.keep(data, heard_s)
            stream.feed(data, heard_s)
        cpu = time.process_time() - cpu
        raw.close()
    print(f"{seconds:g} s at {BAUD} baud: {sent[-1]} frames sent, {stream.samples} read, "
          f"{stream.parser.bad} damaged, terminal full {sent.count(-1)} times, "
          f"{100 * cpu / seconds:.0f} % of one core for both sides")


def kill(times: int) -> None:
    """Killed recordings beside an undisturbed one, from the same played device."""
    session = evening()
    with tempfile.TemporaryDirectory() as folder:
        configs = []
        for name in ("undisturbed", "killed"):
            (Path(folder) / name).mkdir()
            configs.append(write_config(Path(folder) / name, session, "xsens-mti"))
        with playing(session, "xsens-mti", speed=KILL_SPEED) as port:
            record(configs[0], port, onlooker())
            kills = record_with_kills(configs[1], port, times, seed=7)
        one, two = (calibrated(config) for config in configs)
        count = len(list((Path(folder) / "killed" / "acc").glob("pose_*.csv")))
    print(f"killed {kills} times while running; {count} poses at the end")
    for name, sd in zip(("misalignment_rad", "bias_counts", "scale_counts_per_unit"),
                        one.parameters.sd, strict=True):
        apart = (getattr(one.parameters, name) - getattr(two.parameters, name)) / sd
        print(f"  {name:24s} differs by at most {np.abs(apart).max():.2f} of its sd")


if __name__ == "__main__":
    what, count = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 0
    {"fuzz": lambda: fuzz_all(count or 100_000), "baud": lambda: sustained(count or 60),
     "kill": lambda: kill(count or 20)}[what]()
