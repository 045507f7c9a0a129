"""Logs of whole classes: a number a line, the same labels from the first line on."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.pipeline.guess.foreign_files import DEG, Foreign, G
from tests.pipeline.guess.hand_log import HandLog
from tests.pipeline.guess.text_rows import counts_of, si_rows, write_lines


def a_number_a_line(folder: Path, log: HandLog) -> Foreign:
    """`Serial.println` of one value after another."""
    return Foreign([write_lines(folder / "monitor.txt", [
        cell for row in si_rows(log, 1.0, 1 / DEG) for cell in row])], 1.0, 1 / DEG)


def counts_a_line(folder: Path, log: HandLog) -> Foreign:
    """Counts of seven channels, the temperature among them, between words and empty lines."""
    rows = np.insert(counts_of(log), 3, -1700, axis=1)
    return Foreign([write_lines(folder / "port.log", [
        "MPU6050 ready", *(cell for row in rows for cell in (*map(str, row), ""))])],
        16384 / G, 131.072 / DEG, log.rate_hz)


def labels_from_the_first_line(folder: Path, log: HandLog) -> Foreign:
    """Means of poses, none of which may be lost."""
    means = [log.acc[log.rest == i].mean(axis=0) for i in range(18)]
    return Foreign([write_lines(folder / "faces.txt", [
        f"X: {x:.4f} Y: {y:.4f} Z: {z:.4f}" for x, y, z in means])], 1.0, None)


def an_axis_a_file(folder: Path, log: HandLog) -> Foreign:
    return Foreign([write_lines(folder / f"{axis} 1.txt", [f"{v:.5f}" for v in values])
                    for axis, values in zip("xyz", log.acc.T, strict=True)])


LATEST: dict[str, Callable[[Path, HandLog], Foreign]] = {
    tool.__name__: tool for tool in (a_number_a_line, counts_a_line, labels_from_the_first_line)
}
LATEST_REFUSED: dict[str, tuple[Callable[[Path, HandLog], Foreign], str]] = {
    "axes_apart": (an_axis_a_file, "paste -d ',' .*'.*x 1.txt' .*'.*z 1.txt' >log.csv"),
}
