"""Evenness of a platter's rotation: speed over the angle, spectrum, spectrogram, and their page.

The page is that of ``pipeline rate --flutter --page``.
"""

import base64
import math
import struct
import zlib
from collections.abc import Sequence

import numpy as np

from calib.numbers import RPM
from calib.poses.imu_log import FloatArray
from pipeline.console.rate_text import flutter_lines, two_sigma
from pipeline.drawings.charts import (
    PLAIN,
    Canvas,
    Chart,
    Figure,
    drawing,
    nice_limit,
    pixel,
    rightward,
    upward,
)
from pipeline.report.page_templates import page_templates
from pipeline.results.json_values import Json
from pipeline.stages.flutter import MeasuredFlutter
from vision.rate.aes6_flutter import PlatterFlutter, SpeedCourse

POLAR = Canvas(400.0, 400.0, 0.0, 0.0, "chart polar")
MIDDLE, EVEN_RADIUS, REACH = 200.0, 110.0, 66.0  #: px: of zero, of the limit; layout
MOST_TURNS = 12  #: laid over each other; of a picture
WHOLE_TURNS = 4  #: from which the first and the last are not drawn, of a picture
ANGLES = 120  #: angles of a turn, of a picture
SHOWN_ORDERS = 6.0  #: waves per turn of the polar chart, of a picture
PER_CENT = 100.0  #: definition
COLUMNS, ROWS = 120, 60  #: pixels of the spectrogram at most, of a picture
WINDOW_TURNS = 3.0  #: turns of the spectrogram that separate once from twice per turn; of a picture
LEAST_WINDOWS = 4  #: windows in a course that has a spectrogram; of a picture
DEEPEST = 0.03  #: share of the strongest wave below which nothing is drawn; of a picture


def polar_figure(course: SpeedCourse) -> Figure | None:
    """Speed over the angle, turns laid over each other and their mean; None under two turns."""
    smooth = _slow_part(course)
    turns = course.angle_rad / (2 * np.pi)
    first, last = math.ceil(turns[0]), math.floor(turns[-1])
    if last - first < 2:
        return None
    if last - first > WHOLE_TURNS:  # at its ends a course is less certain
        first, last = first + 1, last - 1
    at = np.arange(ANGLES + 1) / ANGLES
    courses = np.array([np.interp(turn + at, turns, smooth) for turn in range(first, last)])
    mean = courses.mean(axis=0)
    limit = nice_limit(max(PER_CENT * float(np.quantile(np.abs(courses), 0.99)), 1e-4))
    shown = np.unique(np.linspace(0, len(courses) - 1, min(len(courses), MOST_TURNS)).astype(int))
    parts = [_circle(0.0, "zero"), _circle(1.0, "grid"), _circle(-1.0, "grid")]
    for quarter, place in enumerate(((390, 195, "end"), (196, 14, "end"), (10, 195, "start"),
                                     (200, 396, "middle"))):
        x, y, anchor = place
        parts.append(f'<text class="tick" x="{x}" y="{y}" text-anchor="{anchor}">'
                     f"{90 * quarter}°</text>")
    for name, share in (("", 0.0), ("+", 1.0), ("−", -1.0)):
        parts.append(f'<text class="tick" x="{MIDDLE + 4:g}" '
                     f'y="{pixel(MIDDLE - EVEN_RADIUS - share * REACH - 4)}">'
                     f"{name}{limit * abs(share):g} %</text>")
    parts += [_curve(PER_CENT * courses[i] / limit, at, "turn") for i in shown]
    parts.append(_curve(PER_CENT * mean / limit, at, "mean"))
    repeats = PER_CENT * float(np.ptp(mean)) / 2
    rest = PER_CENT * float((courses - mean).std())
    caption = (f"{len(shown)} of {len(courses)} whole turns between the clip's ends, waves up to "
               f"{SHOWN_ORDERS:g} per turn. "
               f"Thick: their mean, ± {repeats:.2g} %. The turns scatter about it by {rest:.2g} %.")
    title = "Speed over one turn"
    return Figure(title, drawing(parts, f"{title}. {caption}", POLAR),
                  "circles. What the turns have in common is fixed to the platter, or to the view; "
                  "what they have not comes from motor and belt.", caption)


def spectrum_figure(figures: PlatterFlutter, course: SpeedCourse) -> Figure:
    """Amplitude of the waves of the speed, with the turns of the platter marked."""
    hz, amplitude = figures.hz, PER_CENT * figures.amplitude
    top = nice_limit(float(amplitude.max()) or 1e-6)
    chart = Chart(rightward(0.0, float(hz[-1])), upward(0.0, top), "frequency [Hz]",
                  "amplitude of the speed [%]")
    chart.axes()
    turns_hz = course.rate_rad_s / (2 * np.pi)
    for order in (1, 2):
        if order * turns_hz < hz[-1]:
            chart.bar(order * turns_hz, 0.0, top, "grid")
    shown = _thinned_peaks(amplitude)
    chart.line(hz[shown], amplitude[shown], "rms")
    caption = (f"Lines at once and twice per turn ({turns_hz:.3g} Hz). Platter, AES6-weighted: "
               f"{two_sigma(figures.weighted, figures.weighted_noise)}.")
    return Figure("Spectrum of the speed", chart.svg(f"Spectrum of the speed. {caption}"),
                  "low, without a line that stands out. Lines that follow no turn are those of "
                  "motor, belt and idler.", caption)


def spectrogram_figure(course: SpeedCourse) -> Figure | None:
    """The waves over time; None where the course is too short for it.

    Waves of the angle where angles were measured, whose noise is white; else of the speed.
    """
    window = round(WINDOW_TURNS * 2 * np.pi / course.rate_rad_s / course.step_s)
    if window < 8 or len(course.deviation) < LEAST_WINDOWS * window:
        return None
    starts = np.linspace(0, len(course.deviation) - window, COLUMNS).astype(int)
    taper = np.hanning(window)
    pieces = course.deviation[starts[:, None] + np.arange(window)]
    pieces = (pieces - pieces.mean(axis=1, keepdims=True)) * taper
    amplitude = 2 * np.abs(np.fft.rfft(pieces, axis=1)) / taper.sum()  # (columns, bins)
    hz = np.fft.rfftfreq(window, course.step_s)
    what, unit = "speed", " %"
    amplitude *= PER_CENT
    if course.noise_rad:
        what, unit = "angle", "°"
        amplitude[:, 1:] *= np.degrees(course.rate_rad_s) / PER_CENT / (2 * np.pi * hz[1:])
    kept = amplitude[:, 1 : int(np.searchsorted(hz, course.top_hz))]
    per_row = max(1, math.ceil(kept.shape[1] / ROWS))
    rows = kept[:, : kept.shape[1] // per_row * per_row]
    rows = rows.reshape(len(starts), -1, per_row).max(axis=2).T[::-1]  # fast on top
    strongest = float(rows.max()) or 1e-12
    depth = np.log(np.maximum(rows / strongest, DEEPEST)) / math.log(DEEPEST)  # 0 strongest
    picture = base64.b64encode(grey_png(np.round(255 * depth).astype(np.uint8))).decode()
    top = float(hz[1 + per_row * len(rows)]) if 1 + per_row * len(rows) < len(hz) else float(hz[-1])
    chart = Chart(rightward(0.0, course.seconds), upward(0.0, top), "time [s]", "frequency [Hz]")
    x, y = chart.x(0.0), chart.y(top)
    chart.parts.append(
        f'<image x="{x:g}" y="{y:g}" width="{chart.right - x:g}" height="{chart.y(0.0) - y:g}" '
        f'preserveAspectRatio="none" href="data:image/png;base64,{picture}"/>')
    chart.axes()
    least = DEEPEST * strongest
    caption = f"Dark is strong: black {strongest:.2g}{unit}, white {least:.2g}{unit} and less."
    title = f"Waves of the {what} in time"
    return Figure(title, chart.svg(f"{title}. {caption}"),
                  "level stripes or none. A stripe that bends is a motor or a belt that changes "
                  "its speed; one that breaks off is a belt that slips.", caption)


def grey_png(picture: np.ndarray) -> bytes:
    """A PNG of grey values uint8 (h, w)."""
    height, width = picture.shape
    rows = b"".join(b"\0" + row.tobytes() for row in picture)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return (struct.pack(">I", len(data)) + kind + data
                + struct.pack(">I", zlib.crc32(kind + data)))

    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows, 9))
            + chunk(b"IEND", b""))


def _slow_part(course: SpeedCourse) -> FloatArray:
    """The deviation (n,) up to ``SHOWN_ORDERS`` waves per turn."""
    n = len(course.deviation)
    mirrored = np.concatenate([course.deviation, course.deviation[::-1]])
    hz = np.fft.rfftfreq(2 * n, course.step_s)
    kept = hz <= SHOWN_ORDERS * course.rate_rad_s / (2 * np.pi)
    return np.asarray(np.fft.irfft(np.fft.rfft(mirrored) * kept, 2 * n)[:n])


def _circle(share: float, kind: str) -> str:
    radius = EVEN_RADIUS + share * REACH
    return (f'<circle class="{kind}" cx="{MIDDLE:g}" cy="{MIDDLE:g}" r="{radius:g}" fill="none"/>')


def _curve(share: FloatArray, turn: FloatArray, kind: str) -> str:
    """A closed line about the middle, counter-clockwise from the right as the angle grows."""
    radius = EVEN_RADIUS + REACH * np.clip(share, -1.5, 1.5)
    x = MIDDLE + radius * np.cos(2 * np.pi * turn)
    y = MIDDLE - radius * np.sin(2 * np.pi * turn)
    points = "L".join(f"{pixel(a)} {pixel(b)}" for a, b in zip(x, y, strict=True))
    return f'<path class="line {kind}" d="M{points}"/>'


def _thinned_peaks(values: FloatArray) -> FloatArray:
    """Indices (≤ 2 · width,) that keep the peaks of many values (n,)."""
    block = max(1, math.ceil(len(values) / PLAIN.width))
    starts = range(0, len(values), block)
    return np.array([start + int(np.argmax(values[start : start + block])) for start in starts])


def speed_page(title: str, measured: Sequence[MeasuredFlutter]) -> str:
    """The page as text."""
    return page_templates().get_template("speed.html").render(
        title=title, views=[_view(one) for one in measured])


def _view(measured: MeasuredFlutter) -> Json:
    """View of one clip or log; ``facts`` are names and values."""
    head, *lines = flutter_lines(measured)
    figures = (polar_figure(measured.course), spectrum_figure(measured.figures, measured.course),
               spectrogram_figure(measured.course))
    facts = [("mean rate", f"{measured.course.rate_rad_s / RPM:.4f} rpm")]
    for line in lines:  # of the terminal: a name, two blanks or more, a value; or a remark
        name, _, value = line.strip().partition("  ")
        facts.append((name, value.strip()) if value else ("remark", name))
    return {
        "title": head.removeprefix("flutter "),
        "facts": facts,
        "figures": [figure for figure in figures if figure is not None],
    }
