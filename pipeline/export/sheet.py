"""One sheet of A4 that texts, rules and charts are placed on, in millimetres from its top left.

matplotlib draws it: its charts are vectors, the font that it brings holds the signs of the field,
and equal input gives equal bytes once no date is written.
"""

import io
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache, lru_cache
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont
from matplotlib.ft2font import FT2Font, LoadFlags
from matplotlib.lines import Line2D
from matplotlib.patches import FancyBboxPatch

WIDTH, HEIGHT = 210.0, 297.0  #: mm, A4
INCH, POINT = 25.4, 25.4 / 72  #: mm
FONT = "DejaVu Sans"  #: comes with matplotlib
MEASURED = 100.0  #: size in points at which texts are measured
SMALLEST = 0.62  #: of the size of a text: smaller it could not be read
ABSENT = "□"  #: in place of a letter that the font does not have

INK, QUIET, LINE, ACCENT = "#1d2430", "#5b6472", "#d5d8de", "#1f5fa8"


@contextmanager
def own_settings() -> Iterator[None]:
    """matplotlib as it comes, whatever the user's settings are; text stays text in the file."""
    with matplotlib.rc_context(dict(matplotlib.rcParamsDefault)):
        matplotlib.rcParams.update({
            "pdf.fonttype": 42, "font.family": FONT, "axes.edgecolor": LINE,
            "axes.labelcolor": QUIET, "xtick.color": QUIET, "ytick.color": QUIET,
            "axes.linewidth": 0.6,
        })
        yield


@cache
def _font(bold: bool) -> FT2Font:
    """The font at the size at which texts are measured."""
    font = FT2Font(findfont(FontProperties(family=FONT, weight="bold" if bold else "normal")))
    font.set_size(MEASURED, 72)
    return font


@lru_cache(maxsize=10_000)
def _measured(text: str, bold: bool) -> float:
    """How wide a text is at the size :data:`MEASURED`, points.

    Kept, since a paragraph is broken into lines once for its height and once to be drawn.
    """
    font = _font(bold)
    font.set_text(text, 0.0, flags=LoadFlags.NO_HINTING)
    width: int = font.get_width_height()[0]
    return width / 64


class A4Sheet:
    """The sheet; :meth:`pdf` gives the file."""

    def __init__(self) -> None:
        self.figure = Figure(figsize=(WIDTH / INCH, HEIGHT / INCH))
        FigureCanvasPdf(self.figure)
        self.letters = _font(False).get_charmap()
        self.absent: set[str] = set()  #: letters that the font does not have

    def text(
        self, x: float, y: float, text: str, size: float = 7.0, *, colour: str = INK,
        bold: bool = False, right: bool = False, most: float | None = None,
    ) -> float:
        """One line with its base at y; its width, mm.

        Where it is wider than ``most`` it is set smaller, and from :data:`SMALLEST` on cut.
        """
        shown = self.drawable(text)
        width = self.width(shown, size, bold=bold)
        if most is not None and width > most:
            size *= max(most / width, SMALLEST)
            letters = bisect_right(
                range(len(shown)), most, key=lambda n: self.width(shown[:n], size, bold=bold))
            if letters < len(shown):
                shown = f"{shown[:max(letters - 2, 1)].rstrip()}…"
            width = min(self.width(shown, size, bold=bold), most)
        self.figure.text(
            x / WIDTH, 1 - y / HEIGHT, shown, fontsize=size, color=colour, parse_math=False,
            fontweight="bold" if bold else "normal", ha="right" if right else "left", va="baseline",
        )
        return width

    def paragraph(
        self, x: float, y: float, text: str, width: float, size: float = 6.6, *,
        colour: str = INK, most: int = 99,
    ) -> float:
        """Lines of at most ``width``, the first with its base at y; the base of the next one."""
        lines = self.wrapped(text, width, size)
        if len(lines) > most:
            lines = [*lines[: most - 1], f"{lines[most - 1].rstrip('.,; ')} …"]
        for line in lines:
            self.text(x, y, line, size, colour=colour, most=width)
            y += 1.42 * size * POINT
        return y

    def wrapped(self, text: str, width: float, size: float) -> list[str]:
        """``text`` broken into lines of at most ``width``; a longer word stands alone."""
        lines: list[str] = []
        for word in self.drawable(text).split(" "):
            longer = f"{lines[-1]} {word}" if lines else word
            if lines and self.width(longer, size) <= width:
                lines[-1] = longer
            else:
                lines.append(word)
        return lines

    def width(self, text: str, size: float, *, bold: bool = False) -> float:
        """How wide a line is, mm."""
        return _measured(text, bold) * size / MEASURED * POINT

    def drawable(self, text: str) -> str:
        """``text`` with :data:`ABSENT` for every letter that the font does not have."""
        self.absent |= {c for c in text if ord(c) not in self.letters}
        return "".join(ABSENT if c in self.absent else c for c in text)

    def rule(
        self, x: float, y: float, width: float, colour: str = LINE, points: float = 0.6
    ) -> None:
        """A horizontal line."""
        self.figure.add_artist(Line2D(
            [x / WIDTH, (x + width) / WIDTH], [1 - y / HEIGHT] * 2, color=colour, linewidth=points))

    def box(self, x: float, y: float, width: float, height: float, colour: str) -> None:
        """A filled box with its top left at (x, y)."""
        self.figure.add_artist(FancyBboxPatch(
            (x / WIDTH, 1 - (y + height) / HEIGHT), width / WIDTH, height / HEIGHT,
            boxstyle="square,pad=0", facecolor=colour, edgecolor="none", zorder=-1))

    def axes(self, x: float, y: float, width: float, height: float) -> Axes:
        """A chart with the top left of its frame at (x, y)."""
        return self.figure.add_axes(
            (x / WIDTH, 1 - (y + height) / HEIGHT, width / WIDTH, height / HEIGHT))

    def pdf(self, about: Mapping[str, str]) -> bytes:
        """The file; ``about`` holds its Title, Subject and so on. It holds no date."""
        data = io.BytesIO()
        metadata: dict[str, Any] = {**about, "CreationDate": None}
        self.figure.savefig(data, format="pdf", metadata=metadata)
        return data.getvalue()
