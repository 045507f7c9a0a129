"""Random streams of bytes, in pieces, for every parser; and how much a parser keeps of them."""

import random
import sys
from collections.abc import Callable, Iterator

from pipeline.devices.line_pattern import LinePattern, LinePatternParser, sketch_line
from pipeline.devices.mpu6050_text import Mpu6050TextParser
from pipeline.devices.sample import Parser
from pipeline.devices.xsens import XsensParser, frame

PARSERS: dict[str, Callable[[], Parser]] = {
    "xsens-mti": XsensParser,
    "xsens-mti-mtdata2": XsensParser,
    "mpu-6050": Mpu6050TextParser,
    "lines": lambda: LinePatternParser(
        LinePattern.stated("{time_s},{acc_x},{acc_y},{acc_z} {skip}")),
}
#: Pieces of every protocol, so that chance gets beyond the first byte.
FRAGMENTS = (
    b"\xfa\xff", b"\xfa\xff\x32\x16", b"\xfa\xff\x36\xff\xff\xff", frame(0x32, bytes(22)),
    frame(0x36, bytes.fromhex("102002000140200c") + bytes(12)), b"a/g:\t", b"1\t2\t3\t4\t5\t6\r\n",
    b"S,1,2,", sketch_line(1, 2, (3, 4, 5, 6, 7, 8, 9)).encode() + b"\n", b"Acceleration X: 1, Y:",
    b"connection successful\r\n", b"ax,ay,az\n", b"1e99,nan,inf\n", b"\n", b"\0\0\0\0", b"-",
    b"1" * 50,
    b"accel x,y,z: 1, 2, 3\n", b"#turntable v1 a=.. b=1.\n", b"\x1b[31m", b"0,1,2,3 x\n",
    b"time,ax,ay,az\n",
)


def case(rng: random.Random) -> Iterator[bytes]:
    """One stream in pieces."""
    for _ in range(rng.randrange(1, 12)):
        kind = rng.random()
        if kind < 0.35:
            yield rng.randbytes(rng.randrange(0, 40))
        elif kind < 0.9:
            piece = bytearray(rng.choice(FRAGMENTS))
            if piece and rng.random() < 0.3:
                piece[rng.randrange(len(piece))] ^= 1 << rng.randrange(8)
            yield bytes(piece[: rng.randrange(len(piece) + 1)] if rng.random() < 0.2 else piece)
        else:
            yield bytes([rng.randrange(256)]) * rng.randrange(0, 600)


def kept(parser: object) -> int:
    """Bytes in the buffers of a parser, those of its line or frame reader included."""
    total = 0
    for value in vars(parser).values():
        if isinstance(value, bytes | bytearray | str | list | dict | set):
            total += sys.getsizeof(value)
        elif type(value).__module__.startswith("pipeline.devices") and hasattr(value, "__dict__"):
            total += kept(value)
    return total


def fuzz(name: str, cases: int, seed: int) -> tuple[int, int]:
    """Run ``cases`` streams through one parser kind; samples found and most bytes kept."""
    rng = random.Random(seed)
    samples = most = 0
    parser = PARSERS[name]()
    for number in range(cases):
        if number % 20 == 0:  # a stream of twenty cases, then a new one
            parser = PARSERS[name]()
        for piece in case(rng):
            samples += len(parser.feed(piece))
        most = max(most, kept(parser))
    return samples, most
