"""The certificate of a calibration as one page that a laboratory files.

From top to bottom: the sensor and what identifies the session; each triad with its verdict,
parameters, figures and residuals; the references with their traceability; how to read it. It is
HTML with a style sheet for A4: a browser prints it, or saves it as PDF.
"""

from functools import cache
from itertools import groupby

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined, Template

from pipeline.drawings.charts import Canvas, Chart, rightward, upward
from pipeline.export.certificate_content import Residuals, certificate_content
from pipeline.export.parts import Export
from pipeline.results.read import Stored
from pipeline.text.formatting import with_minus_signs

FILE_NAME = "certificate.html"
CANVAS = Canvas(320.0, 122.0, 34.0, 20.0, "chart", margin_right=3.0, margin_top=4.0)
REACH = 1.1  #: length of the axis in largest residuals with their sd; layout
LONGEST_RUN = 24  #: letters of a run's name; layout


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


def residual_chart(residuals: Residuals, triad: str) -> str:
    """Residuals in the order of the poses over their noise, as SVG; a square marks a length."""
    largest = float(np.max(np.abs(residuals.value) + residuals.sd))
    low = 0.0 if residuals.is_length.all() else -largest
    place = np.arange(len(residuals.value), dtype=float)
    chart = Chart(rightward(-0.5, len(place) - 0.5, CANVAS),
                  upward(REACH * low, REACH * largest, canvas=CANVAS), "", "", CANVAS)
    chart.y_axis([(value, with_minus_signs(f"{value:.2g}"))
                  for value in sorted({0.0, low, largest})])
    runs, first = [], 0
    for run, poses in groupby(residuals.run):
        last = first + len(list(poses))
        runs.append(((first + last - 1) / 2, run[:LONGEST_RUN]))
        first = last
    chart.x_axis(runs)
    chart.bars(place, np.where(residuals.is_length, 0.0, -residuals.sd), residuals.sd, "band")
    for x, value, is_length in zip(place, residuals.value, residuals.is_length, strict=True):
        chart.mark(x, value, int(is_length), "mark")
    return chart.svg(f"Residuals of the {triad}")
