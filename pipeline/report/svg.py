"""Small charts as SVG text, coloured by the page's style sheet in its light and dark form.

This module replaces a plotting library: the page stays small, the style sheet sets the colours, and
the tick boxes move the marks that this module draws. A chart is 400 units wide, the width of a
phone; wider screens show several charts side by side.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape

import numpy as np

from calib.poses.imu_log import FloatArray

WIDTH, HEIGHT = 400.0, 240.0
LEFT, RIGHT, TOP, BOTTOM = 58.0, 8.0, 12.0, 40.0
NICE = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0)  #: limits of a symmetrical axis, in any decade
TICK_STEPS = (1.0, 2.0, 5.0, 10.0)
LABELLED_DECADE = (1.0, 2.0, 5.0)  #: of a logarithmic axis

#: Outlines about the origin: runs differ in shape as well as in colour.
SHAPES = (
    "M-3 0a3 3 0 1 0 6 0a3 3 0 1 0-6 0z",  # circle
    "M-2.7-2.7h5.4v5.4h-5.4z",  # square
    "M0-3.6L3.4 2.6H-3.4z",  # triangle
    "M0-3.8L3.4 0L0 3.8L-3.4 0z",  # diamond
    "M0 3.6L3.4-2.6H-3.4z",  # triangle, down
    "M-3.4-1h2.4v-2.4h2v2.4h2.4v2h-2.4v2.4h-2v-2.4h-2.4z",  # cross
)


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


def across(values: FloatArray) -> Scale:
    """The x scale that shows all ``values`` with a little room on both sides."""
    low, high = float(np.min(values)), float(np.max(values))
    room = 0.04 * (high - low) or 0.5 * abs(low) or 0.5
    return Scale(low - room, high + room, LEFT, WIDTH - RIGHT)


def upward(low: float, high: float, *, logarithmic: bool = False) -> Scale:
    """The y scale from ``low`` at the bottom to ``high`` at the top."""
    return Scale(low, high, HEIGHT - BOTTOM, TOP, logarithmic)


def nice_limit(value: float) -> float:
    """The next round number not below ``value`` (> 0); the page's script rounds alike."""
    decade = 10.0 ** math.floor(math.log10(value))
    return next(decade * m for m in NICE if decade * m >= value * (1 - 1e-9))


def tick_text(value: float) -> str:
    """A tick's number with a true minus sign.

    >>> tick_text(-0.05), tick_text(3000.0)
    ('−0.05', '3000')
    """
    return f"{value + 0.0:.6g}".replace("-", "−").replace("e−0", "e−").replace("e+0", "e")


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
    parts: list[str] = field(default_factory=list)

    def axes(self, x_ticks: Sequence[tuple[float, str]] | None = None) -> None:
        """Grid, numbers and titles; ``x_ticks`` are values with their text."""
        self.y_axis([(value, tick_text(value)) for value in self.y.ticks()])
        self.x_axis(
            [(value, tick_text(value)) for value in self.x.ticks()] if x_ticks is None else x_ticks
        )

    def y_axis(self, ticks: Sequence[tuple[float, str]], attribute: str = "") -> None:
        """Horizontal grid lines and their numbers; ``attribute`` marks the numbers for scripts."""
        for value, text in ticks:
            at = pixel(self.y(value))
            self.parts.append(f'<path class="grid" d="M{LEFT:g} {at}H{WIDTH - RIGHT:g}"/>')
            self.parts.append(
                f'<text class="tick" x="{LEFT - 5:g}" y="{at}" dy="4" text-anchor="end"'
                f"{attribute}>{escape(text)}</text>"
            )
        self.parts.append(
            f'<text class="title" transform="translate(11 {(TOP + HEIGHT - BOTTOM) / 2:g}) '
            f'rotate(-90)" text-anchor="middle">{escape(self.y_title)}</text>'
        )

    def x_axis(self, ticks: Sequence[tuple[float, str]]) -> None:
        """Numbers under the axis and its title."""
        bottom = HEIGHT - BOTTOM
        self.parts.append(f'<path class="axis" d="M{LEFT:g} {bottom:g}H{WIDTH - RIGHT:g}"/>')
        for value, text in ticks:
            at = pixel(self.x(value))
            self.parts.append(
                f'<text class="tick" x="{at}" y="{bottom + 14:g}" text-anchor="middle">'
                f"{escape(text)}</text>"
            )
        self.parts.append(
            f'<text class="title" x="{(LEFT + WIDTH - RIGHT) / 2:g}" y="{HEIGHT - 6:g}" '
            f'text-anchor="middle">{escape(self.x_title)}</text>'
        )

    def level(self, value: float, kind: str = "zero") -> None:
        """A horizontal line over the whole width."""
        at = pixel(self.y(value))
        self.parts.append(f'<path class="{kind}" d="M{LEFT:g} {at}H{WIDTH - RIGHT:g}"/>')

    def stripe(self, low: float, high: float) -> None:
        """A band between two values over the whole width."""
        top, bottom = self.y(high), self.y(low)
        self.parts.append(
            f'<rect class="stripe" x="{LEFT:g}" y="{pixel(top)}" '
            f'width="{WIDTH - RIGHT - LEFT:g}" height="{pixel(bottom - top)}"/>'
        )

    def line(self, xs: FloatArray, ys: FloatArray, kind: str) -> None:
        """A line through the points."""
        points = "L".join(
            f"{pixel(self.x(a))} {pixel(self.y(b))}" for a, b in zip(xs, ys, strict=True)
        )
        self.parts.append(f'<path class="line {kind}" d="M{points}"/>')

    def dots(self, xs: FloatArray, ys: FloatArray, kind: str) -> None:
        """Many small dots as one path."""
        points = "".join(
            f"M{pixel(self.x(a))} {pixel(self.y(b))}h0" for a, b in zip(xs, ys, strict=True)
        )
        self.parts.append(f'<path class="dots {kind}" d="{points}"/>')

    def bar(self, x: float, low: float, high: float, kind: str, attribute: str = "") -> None:
        """A vertical bar from ``low`` to ``high``."""
        at = pixel(self.x(x))
        self.parts.append(
            f'<path class="{kind}" d="M{at} {pixel(self.y(low))}V{pixel(self.y(high))}"'
            f"{attribute}/>"
        )

    def mark(
        self, x: float, y: float, shape: int, kind: str, title: str = "", attribute: str = ""
    ) -> None:
        """One mark of shape number ``shape``; ``title`` is its tooltip."""
        tooltip = f"<title>{escape(title)}</title>" if title else ""
        self.parts.append(
            f'<g class="{kind}" transform="translate({pixel(self.x(x))} {pixel(self.y(y))})"'
            f'{attribute}>{tooltip}<path d="{SHAPES[shape % len(SHAPES)]}"/></g>'
        )

    def svg(self, alternative: str, attribute: str = "") -> str:
        """The chart as text; ``alternative`` is its text for screen readers."""
        return drawing(self.parts, alternative, HEIGHT, attribute)


def drawing(
    parts: Sequence[str], alternative: str, height: float = HEIGHT, attribute: str = ""
) -> str:
    """An SVG element of the common width."""
    return (
        f'<svg viewBox="0 0 {WIDTH:g} {height:g}" role="img" aria-label="{escape(alternative)}"'
        f"{attribute}>{''.join(parts)}</svg>"
    )


def thinned(count: int, most: int) -> np.ndarray:
    """Indices of at most ``most`` of ``count`` rows, evenly spread, first and last included."""
    if count <= most:
        return np.arange(count)
    return np.unique(np.linspace(0, count - 1, most).round().astype(int))
