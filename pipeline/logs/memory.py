"""Largest size of a log by the free memory; a larger one is refused before it is read.

A byte of text takes eleven bytes of memory during its conversion to arrays: the bytes, the text,
its lines, the table and the columns (measured on logs of seven columns with 30 to 80 bytes a row;
short rows take more). At most half of the free memory is used.
"""

import os
from contextlib import suppress
from pathlib import Path

from pipeline.errors import UnreadableInput

MEMORY_PER_BYTE = 16  #: the measured eleven, and half as many more for short rows
SHARE = 0.5  #: share of the free memory; chosen: as much remains for the calibration
LEAST_FREE = 256 << 20  #: bytes; a system that states less has them in pages that it can free
#: Files in which Linux states the free memory, and the limit of a container.
MEMINFO, CGROUP = Path("/proc/meminfo"), Path("/sys/fs/cgroup/memory.max")


def largest_text() -> int:
    """Largest number of bytes of text, unpacked, that may be read."""
    return int(SHARE * max(_free(), LEAST_FREE) / MEMORY_PER_BYTE)


def too_large(path: Path, limit: int) -> UnreadableInput:
    """The error for a file of more than ``limit`` bytes, unpacked."""
    return UnreadableInput(
        f"{path}: holds more than {limit >> 20} MB, unpacked; the memory that is free is enough "
        f"for {limit >> 20} MB. Split the log, or leave columns and samples out that are not "
        f"needed."
    )


def _free() -> int:
    stated = []
    for size in (_linux, _container, _physical):
        # A container may state "max", and a system may have no such file or name.
        with suppress(AttributeError, OSError, ValueError, StopIteration):
            stated.append(size())
    return min(stated, default=LEAST_FREE)


def _linux() -> int:
    lines = MEMINFO.read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) << 10 for line in lines if line.startswith("MemAvailable"))


def _container() -> int:
    return int(CGROUP.read_text(encoding="ascii"))


def _physical() -> int:
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
