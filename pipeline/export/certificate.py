"""The certificate of a calibration as one page that a laboratory files.

From top to bottom: the sensor and what identifies the session; each triad with its verdict,
parameters, figures and residuals; the references with their traceability; how to read it. It is
HTML with a style sheet for A4: a browser prints it, or saves it as PDF.
"""

from collections.abc import Sequence
from functools import cache
from itertools import groupby

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined, Template

from pipeline.drawings.charts import Canvas, Chart, rightward, upward
from pipeline.export.certificate_content import certificate_content, printable
from pipeline.export.parts import Export
from pipeline.results.read import Stored
from pipeline.results.schema.triad import PoseResult
from pipeline.text.formatting import DISPLAY, with_minus_signs

FILE_NAME = "certificate.html"
CANVAS = Canvas(320.0, 122.0, 34.0, 20.0, "chart", margin_right=3.0, margin_top=4.0)
REACH = 1.1  #: length of the axis in largest residuals with their sd; layout
LONGEST_RUN = 24  #: letters of a run's name; layout


def to_certificate(stored: Stored) -> Export:
    """``certificate.html``; equal results and history give equal bytes."""
    page = _template().render(**certificate_content(stored), chart=residual_chart)
    return Export({FILE_NAME: page}, ())


@cache
def _template() -> Template:
    environment = Environment(
        loader=PackageLoader("pipeline.export", "templates"), autoescape=True,
        undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return environment.get_template(FILE_NAME)


def residual_chart(poses: Sequence[PoseResult], triad: str) -> str:
    """Residuals in the order of the poses over their noise, as SVG in the shown unit of the triad.

    A square marks a pose at rest with the plate stopped, whose residual is a length.
    """
    factor = DISPLAY[triad][1]
    residual, sd = np.array([(pose.residual, pose.sd) for pose in poses]).T * factor
    is_length = np.array([pose.reference == 0 for pose in poses])
    largest = float(np.max(np.abs(residual) + sd))
    low = 0.0 if is_length.all() else -largest
    place = np.arange(len(poses), dtype=float)
    chart = Chart(rightward(-0.5, len(place) - 0.5, CANVAS),
                  upward(REACH * low, REACH * largest, canvas=CANVAS), "", "", CANVAS)
    chart.y_axis([(value, with_minus_signs(f"{value:.2g}"))
                  for value in sorted({0.0, low, largest})])
    runs, first = [], 0
    for run, of_run in groupby(printable(pose.run) for pose in poses):
        last = first + len(list(of_run))
        runs.append(((first + last - 1) / 2, run[:LONGEST_RUN]))
        first = last
    chart.x_axis(runs)
    chart.bars(place, np.where(is_length, 0.0, -sd), sd, "band")
    for x, value, square in zip(place, residual, is_length, strict=True):
        chart.mark(x, value, int(square), "mark")
    return chart.svg(f"Residuals of the {triad}")
