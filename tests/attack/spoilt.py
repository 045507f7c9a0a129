"""Sessions to be spoilt, and the ways to spoil them: what silent-number attacks are made of."""

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.world.designs import paper_design, rich_design
from tests.world.session import simulate
from tests.world.write import write_session

Table = np.ndarray
Edit = Callable[[Table], Table]
Spoil = Callable[[Path], None]

ACC, GYR = slice(1, 4), slice(4, 7)


def write_base(folder: Path) -> None:
    """The sessions without a fault: ``paper`` (one speed) and ``rich`` (five runs)."""
    write_session(folder / "paper", simulate(paper_design().scaled(sample_rate=0.5), 1), film=False)
    write_session(folder / "rich", simulate(rich_design().scaled(sample_rate=0.2), 2), film=False)


def copy_of(base: Path, name: str, to: Path) -> Path:
    """A copy of a session to spoil; its configuration."""
    shutil.copytree(base / name, to / name)
    return to / name / "config.yaml"


def read_table(path: Path) -> tuple[str, Table]:
    """Header and rows of a log."""
    with path.open(encoding="utf-8") as lines:
        header = lines.readline().strip()
        return header, np.loadtxt(lines, delimiter=",", ndmin=2)


def write_table(path: Path, header: str, table: Table) -> None:
    """A log as a logger writes it: whole counts."""
    whole = [name[:4] in ("acc_", "gyr_") for name in header.split(",")]
    np.savetxt(path, table, delimiter=",", header=header, comments="",
               fmt=["%d" if each else "%.6f" for each in whole])


def logs(pattern: str, edit: Edit) -> Spoil:
    """Every log that matches is edited."""

    def spoil(config: Path) -> None:
        paths = sorted(config.parent.glob(pattern))
        assert paths
        for path in paths:
            header, table = read_table(path)
            write_table(path, header, edit(table))

    return spoil


def config_text(old: str, new: str, count: int = -1) -> Spoil:
    """Another text in the configuration."""

    def spoil(config: Path) -> None:
        text = config.read_text(encoding="utf-8")
        assert old in text, old
        config.write_text(text.replace(old, new, count), encoding="utf-8")

    return spoil


def appended(text: str) -> Spoil:
    """A further section."""
    return lambda config: config.write_text(
        config.read_text(encoding="utf-8") + text, encoding="utf-8") and None


def both(*spoils: Spoil) -> Spoil:
    """One after the other."""

    def spoil(config: Path) -> None:
        for each in spoils:
            each(config)

    return spoil


def axes(columns: slice, order: tuple[int, int, int], signs: tuple[int, int, int] = (1, 1, 1),
         middle: float = 32767.5) -> Edit:
    """Axes exchanged and mirrored about the middle of the converter."""

    def edit(table: Table) -> Table:
        table[:, columns] = (table[:, columns] - middle)[:, order] * np.array(signs) + middle
        return table

    return edit


def scaled(columns: slice, factor: float, middle: float = 32767.5) -> Edit:
    """Another range or unit."""

    def edit(table: Table) -> Table:
        table[:, columns] = (table[:, columns] - middle) * factor + middle
        return table

    return edit


def times(factor: float) -> Edit:
    """Time stamps in another unit, or stretched."""

    def edit(table: Table) -> Table:
        table[:, 0] *= factor
        return table

    return edit


def frozen(start: float) -> Edit:
    """One and the same reading from some share of the log on."""

    def edit(table: Table) -> Table:
        first = int(start * len(table))
        table[first:, 1:] = table[first, 1:]
        return table

    return edit


def part(edit: Edit, start: float, stop: float) -> Edit:
    """An edit of a part of the rows, from and to these shares."""

    def edited(table: Table) -> Table:
        rows = slice(int(start * len(table)), int(stop * len(table)))
        table[rows] = edit(table[rows].copy())
        return table

    return edited


def rocking(degrees: float, per_rad_s: float, middle: float = 32767.5) -> Edit:
    """Turned to and fro about x once a second; ``per_rad_s`` is the gyroscope's gain, counts."""

    def edit(table: Table) -> Table:
        angle = np.radians(degrees) * np.sin(2 * np.pi * table[:, 0])
        y, z = (table[:, 2:4] - middle).T
        table[:, 2] = middle + y * np.cos(angle) - z * np.sin(angle)
        table[:, 3] = middle + y * np.sin(angle) + z * np.cos(angle)
        table[:, 4] += per_rad_s * np.gradient(angle, table[:, 0])
        return table

    return edit


def dead(column: int) -> Edit:
    """An axis that gives noise about nothing."""

    def edit(table: Table) -> Table:
        table[:, column] = np.random.default_rng(3).integers(-30, 30, len(table))
        return table

    return edit


def without(columns: slice) -> Spoil:
    """The logs of the turning runs lack some columns."""

    def spoil(config: Path) -> None:
        for path in sorted(config.parent.glob("gyroscope/*/*.csv")):
            header, table = read_table(path)
            kept = [i for i in range(table.shape[1]) if i not in range(7)[columns]]
            names = header.split(",")
            write_table(path, ",".join(names[i] for i in kept), table[:, kept])

    return spoil
