"""Small charts as SVG text, coloured by the page's style sheet in its light and dark form.

This module replaces a plotting library for three reasons. The whole page is one file of 0.5 to
1 MB that works offline, and the script of a plotting library alone has 1 to 4 MB. The style sheet
colours the charts for a light screen, a dark screen and paper. The tick boxes move the marks
themselves, so that the eye follows every pose from before to after. A chart is about as wide as a
phone; wider screens show several charts side by side.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from html import escape

import numpy as np

from calib.poses.imu_log import FloatArray, IntArray
from pipeline.text.formatting import shortened, with_minus_signs

NICE = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0)  #: limits of a symmetrical axis, in any decade
TICK_STEPS = (1.0, 2.0, 5.0, 10.0)  #: steps of a linear axis, in any decade
LABELLED_DECADE = (1.0, 2.0, 5.0)  #: labels of a logarithmic axis

LETTER = 8.0  #: px, width of a letter of a number under an axis; layout

#: Outlines about the origin: runs differ in shape as well as in colour.
SHAPES = (
    "M-3 0a3 3 0 1 0 6 0a3 3 0 1 0-6 0z",  # circle
    "M-2.7-2.7h5.4v5.4h-5.4z",  # square
    "M0-3.6L3.4 2.6H-3.4z",  # triangle
    "M0-3.8L3.4 0L0 3.8L-3.4 0z",  # diamond
    "M0 3.6L3.4-2.6H-3.4z",  # triangle, down
    "M-3.4-1h2.4v-2.4h2v2.4h2.4v2h-2.4v2.4h-2v-2.4h-2.4z",  # cross
)
SQUARE = f"m{SHAPES[1][1:]}"  #: outline of the second shape from where the pen is


@dataclass(frozen=True)
class Canvas:
    """Size of a chart and of the margins about its axes; ``kind`` is its class in the page."""

    width: float
    height: float
    margin_left: float
    margin_bottom: float
    kind: str
    margin_right: float = 12.0
    margin_top: float = 26.0


PLAIN = Canvas(400.0, 250.0, 54.0, 42.0, "chart")
SMALL = Canvas(320.0, 220.0, 54.0, 42.0, "chart small")  #: three side by side on a wide screen


@dataclass(frozen=True)
class Figure:
    """A chart with its title, the look of a good one, and a caption on this one."""

    title: str
    drawing: str
    good: str
    caption: str = ""


@dataclass(frozen=True)
class Scale:
    """Values from ``low`` to ``high`` to pixels from ``start`` to ``end``."""

    low: float
    high: float
    start: float
    end: float
    logarithmic: bool = False

    def __call__(self, value: float) -> float:
        """The pixel of a value."""
        low, high = self.low, self.high
        if self.logarithmic:
            low, high, value = math.log(low), math.log(high), math.log(value)
        return self.start + (value - low) / (high - low) * (self.end - self.start)

    def ticks(self, count: int = 5) -> list[float]:
        """Round values within the scale, about ``count`` of them."""
        if self.logarithmic:
            decades = range(math.floor(math.log10(self.low)), math.ceil(math.log10(self.high)) + 1)
            few = math.log10(self.high / self.low) > 3  # then the decades alone are enough
            ticks = [10.0**k * m for k in decades for m in (LABELLED_DECADE[:1] if few
                                                            else LABELLED_DECADE)]
            return [value for value in ticks if self.low <= value <= self.high]
        raw = (self.high - self.low) / count
        decade = 10.0 ** math.floor(math.log10(raw))
        step = next(decade * m for m in TICK_STEPS if decade * m >= raw * (1 - 1e-9))
        first = math.ceil(self.low / step - 1e-9)
        return [k * step for k in range(first, math.floor(self.high / step + 1e-9) + 1)]


def across(values: FloatArray, canvas: Canvas = PLAIN) -> Scale:
    """The x scale that shows all ``values`` (n,) with a little room on both sides."""
    low, high = float(np.min(values)), float(np.max(values))
    room = 0.04 * (high - low) or 0.5 * abs(low) or 0.5
    return rightward(low - room, high + room, canvas)


def rightward(low: float, high: float, canvas: Canvas = PLAIN) -> Scale:
    """The x scale from ``low`` at the left to ``high`` at the right."""
    return Scale(low, high, canvas.margin_left, canvas.width - canvas.margin_right)


def upward(
    low: float, high: float, *, logarithmic: bool = False, canvas: Canvas = PLAIN
) -> Scale:
    """The y scale from ``low`` at the bottom to ``high`` at the top."""
    return Scale(low, high, canvas.height - canvas.margin_bottom, canvas.margin_top, logarithmic)


def nice_limit(value: float) -> float:
    """The next round number not below ``value`` (> 0); the page's script rounds in the same way."""
    decade = 10.0 ** math.floor(math.log10(value))
    return next(decade * m for m in NICE if decade * m >= value * (1 - 1e-9))


def tick_text(value: float) -> str:
    """A tick's number with a true minus sign.

    >>> tick_text(-0.05), tick_text(3000.0)
    ('−0.05', '3000')
    """
    return with_minus_signs(f"{value + 0.0:.6g}").replace("e−0", "e−").replace("e+0", "e")


def pixel(value: float) -> str:
    """A coordinate to a tenth of a unit.

    >>> pixel(12.04), pixel(7.0)
    ('12', '7')
    """
    return f"{value:.1f}".removesuffix(".0")


@dataclass
class Chart:
    """A chart under construction; later parts cover earlier ones."""

    x: Scale
    y: Scale
    x_title: str
    y_title: str
    canvas: Canvas = PLAIN
    parts: list[str] = field(default_factory=list)

    @property
    def right(self) -> float:
        """End of the axes."""
        return self.canvas.width - self.canvas.margin_right

    def axes(self, x_ticks: Sequence[tuple[float, str]] | None = None) -> None:
        """Grid, numbers and titles; ``x_ticks`` are values with their text."""
        self.y_axis([(value, tick_text(value)) for value in self.y.ticks()])
        self.x_axis(
            [(value, tick_text(value)) for value in self.x.ticks()] if x_ticks is None else x_ticks
        )

    def y_axis(
        self, ticks: Sequence[tuple[float, str]], attributes: Sequence[str] | None = None
    ) -> None:
        """Horizontal grid lines, their numbers, and the title above them.

        ``attributes`` mark the numbers for scripts.
        """
        start = self.canvas.margin_left
        for (value, text), attribute in zip(ticks, attributes or [""] * len(ticks), strict=True):
            self.level(value, "grid")
            self.parts.append(
                f'<text class="tick" x="{start - 5:g}" y="{pixel(self.y(value))}" dy="4" '
                f'text-anchor="end"'
                f"{attribute}>{escape(text)}</text>"
            )
        self.parts.append(f'<text class="title" x="2" y="12">{escape(self.y_title)}</text>')

    def x_axis(self, ticks: Sequence[tuple[float, str]]) -> None:
        """Numbers under the axis and its title."""
        bottom = self.canvas.height - self.canvas.margin_bottom
        self.level(self.y.low, "axis")
        for value, text in ticks:
            at = pixel(self.x(value))
            self.parts.append(
                f'<text class="tick" x="{at}" y="{bottom + 16:g}" text-anchor="middle">'
                f"{escape(text)}</text>"
            )
        self.parts.append(
            f'<text class="title" x="{self.right:g}" y="{self.canvas.height - 6:g}" '
            f'text-anchor="end">{escape(self.x_title)}</text>'
        )

    def groups(self, names: Sequence[str]) -> None:
        """An x axis of n places from 0, with the name of every run of equal ``names`` (n,).

        Lines stand between them; one name alone leaves numbers from 1.
        """
        starts = [i for i, name in enumerate(names) if i == 0 or names[i - 1] != name]
        if len(starts) == 1:
            return self.x_axis([(i, str(i + 1)) for i in range(0, len(names),
                                                              max(1, len(names) // 6))])
        ends = [*starts[1:], len(names)]
        room = (self.right - self.canvas.margin_left) / len(names) / LETTER
        self.x_axis([((start + end - 1) / 2, shortened(names[start], int(room * (end - start))))
                     for start, end in zip(starts, ends, strict=True)])
        for start in starts[1:]:
            self.bar(start - 0.5, self.y.low, self.y.high, "grid")
        return None

    def level(self, value: float, kind: str = "zero") -> None:
        """A horizontal line over the whole width."""
        self._path(kind, f"M{self.canvas.margin_left:g} {pixel(self.y(value))}H{self.right:g}")

    def stripe(self, low: float, high: float) -> None:
        """A band between two values over the whole width."""
        top, bottom = self.y(high), self.y(low)
        self.parts.append(
            f'<rect class="stripe" x="{self.canvas.margin_left:g}" y="{pixel(top)}" '
            f'width="{self.right - self.canvas.margin_left:g}" height="{pixel(bottom - top)}"/>'
        )

    def line(self, xs: FloatArray, ys: FloatArray, kind: str) -> None:
        """A line through the points ``xs``, ``ys``, both of shape (n,), in units of the axes."""
        self._path(f"line {kind}", "M" + "L".join(self._places(xs, ys)))

    def dots(self, xs: FloatArray, ys: FloatArray, kind: str) -> None:
        """Many small dots at ``xs``, ``ys``, both of shape (n,), as one path."""
        self._path(f"dots {kind}", "".join(f"M{place}h0" for place in self._places(xs, ys)))

    def poses(self, xs: FloatArray, ys: FloatArray, poses: IntArray, kind: str) -> None:
        """A round dot for every pose (n,), which the script of the page knows by its number."""
        dots = "".join(f'<path data-i="{i}" d="M{place}h0"/>'
                       for place, i in zip(self._places(xs, ys), poses, strict=True))
        self.parts.append(f'<g class="pose-dots {kind}">{dots}</g>')

    def squares(self, xs: FloatArray, ys: FloatArray, kind: str) -> None:
        """Open squares at ``xs``, ``ys``, both of shape (n,), as one path."""
        self._path(kind, "".join(f"M{place}{SQUARE}" for place in self._places(xs, ys)))

    def bars(self, xs: FloatArray, lows: FloatArray, highs: FloatArray, kind: str) -> None:
        """Vertical bars at ``xs`` from ``lows`` to ``highs``, all of shape (n,), as one path."""
        self._path(kind, "".join(map(self._upright, xs, lows, highs)))

    def bar(self, x: float, low: float, high: float, kind: str, attribute: str = "") -> None:
        """A vertical bar from ``low`` to ``high``."""
        self._path(kind, self._upright(x, low, high), attribute)

    def _places(self, xs: FloatArray, ys: FloatArray) -> Iterator[str]:
        return (f"{pixel(self.x(a))} {pixel(self.y(b))}" for a, b in zip(xs, ys, strict=True))

    def _upright(self, x: float, low: float, high: float) -> str:
        return f"M{pixel(self.x(x))} {pixel(self.y(low))}V{pixel(self.y(high))}"

    def _path(self, kind: str, course: str, attribute: str = "") -> None:
        self.parts.append(f'<path class="{kind}" d="{course}"{attribute}/>')

    def mark(
        self, x: float, y: float, shape: int, kind: str, title: str = "", attribute: str = ""
    ) -> None:
        """One mark of shape number ``shape``; ``title`` is its tooltip."""
        tooltip = f"<title>{escape(title)}</title>" if title else ""
        self.parts.append(
            f'<g class="{kind}" transform="translate({pixel(self.x(x))} {pixel(self.y(y))})"'
            f'{attribute}>{tooltip}<path d="{SHAPES[shape % len(SHAPES)]}"/></g>'
        )

    def svg(self, alternative: str, attribute: str = "", kind: str = "") -> str:
        """The chart as text; ``alternative`` is its text for screen readers."""
        return drawing(self.parts, alternative, self.canvas, attribute, kind)


def drawing(
    parts: Sequence[str], alternative: str, canvas: Canvas = PLAIN, attribute: str = "",
    kind: str = "",
) -> str:
    """An SVG element of the size of ``canvas``, of one more class ``kind``."""
    return (
        f'<svg class="{f"{canvas.kind} {kind}".strip()}" '
        f'viewBox="0 0 {canvas.width:g} {canvas.height:g}" role="img" '
        f'aria-label="{escape(alternative)}"{attribute}>{"".join(parts)}</svg>'
    )
