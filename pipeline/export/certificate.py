"""The certificate of a calibration as one page that a laboratory files.

From top to bottom: the sensor and what identifies the session; each triad with its verdict,
parameters, figures and residuals; the references with their traceability; how to read it. It is
HTML with a style sheet for A4: a browser prints it, or saves it as PDF.
"""

from dataclasses import dataclass
from functools import cache
from itertools import groupby

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined, Template

from pipeline.export.certificate_content import Residuals, certificate_content
from pipeline.export.parts import Export
from pipeline.results.read import Stored
from pipeline.text.formatting import with_minus_signs

FILE_NAME = "certificate.html"
WIDTH, HEIGHT = 320.0, 110.0  #: size of a chart, in the units of its drawing; layout
LEFT, TOP, BOTTOM = 34.0, 4.0, 96.0  #: edges of its frame; layout
REACH = 1.1  #: length of the axis in largest residuals with their sd; layout


@dataclass(frozen=True)
class Bar:
    """The noise and the residual of one pose, in the units of the drawing."""

    x: float
    width: float
    top: float
    height: float
    y: float
    is_length: bool


@dataclass(frozen=True)
class ResidualChart:
    """Residuals in the order of the poses over their noise; runs and ticks as (place, text)."""

    bars: tuple[Bar, ...]
    runs: tuple[tuple[float, str], ...]
    ticks: tuple[tuple[float, str], ...]


def to_certificate(stored: Stored) -> Export:
    """``certificate.html``; equal results and history give equal bytes."""
    page = _template().render(content=certificate_content(stored), chart=residual_chart)
    return Export({FILE_NAME: page}, ())


@cache
def _template() -> Template:
    environment = Environment(
        loader=PackageLoader("pipeline.export", "templates"), autoescape=True,
        undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return environment.get_template(FILE_NAME)


def residual_chart(residuals: Residuals) -> ResidualChart:
    """The drawing of a triad's residuals."""
    reach = REACH * float(np.max(np.abs(residuals.value) + residuals.sd))
    low = 0.0 if residuals.is_length.all() else -reach
    step = (WIDTH - LEFT) / len(residuals.value)

    def height(value: float) -> float:
        return round(BOTTOM - (value - low) / (reach - low) * (BOTTOM - TOP), 2)

    bars = []
    for i, (value, sd, is_length) in enumerate(
        zip(residuals.value, residuals.sd, residuals.is_length, strict=True)
    ):
        top, bottom = height(sd), height(0.0 if is_length else -sd)
        bars.append(Bar(round(LEFT + (i + 0.05) * step, 2), round(0.9 * step, 2), top,
                        round(bottom - top, 2), height(value), bool(is_length)))
    runs, place = [], 0
    for run, poses in groupby(residuals.run):
        runs.append((round(LEFT + place * step, 2), run))
        place += len(list(poses))
    ticks = tuple((height(value), with_minus_signs(f"{value:.2g}"))
                  for value in sorted({0.0, low / REACH, reach / REACH}))
    return ResidualChart(tuple(bars), tuple(runs), ticks)
