"""A parameter over the sensors of a lot as a small chart; those unlike it are marked."""

import numpy as np

from calib.poses.imu_log import BoolArray, FloatArray
from pipeline.drawings.charts import SMALL, Chart, across, pixel, upward

MOST_BARS = 40
"""Bars of a chart 320 units wide; derived: narrower ones are lines."""


def histogram(value: FloatArray, unlike: BoolArray, unit: str) -> str:
    """The chart as SVG.

    Parameters
    ----------
    value : array, shape (S,)
        NaN where a sensor has none.
    unlike : array of bool, shape (S,)
        Sensors unlike the lot: marks on the axis, in the page's colour of warnings.
    unit : str
        Of the values.
    """
    stated = value[np.isfinite(value)]
    x = across(stated, SMALL)
    bars = int(np.clip(np.sqrt(len(stated)) * 2, 5, MOST_BARS))
    counts, edges = np.histogram(stated, bins=bars, range=(x.low, x.high))
    chart = Chart(x, upward(0.0, 1.08 * counts.max(), canvas=SMALL), unit, "sensors", SMALL)
    chart.axes()
    floor = pixel(chart.y(0.0))
    for n, start, end in zip(counts, edges, edges[1:], strict=False):
        if n:
            at, top, width = chart.x(start), chart.y(float(n)), chart.x(end) - chart.x(start)
            chart.parts.append(f'<path class="run0" d="M{pixel(at + 0.4)} {floor}V{pixel(top)}'
                               f'h{pixel(max(width - 0.8, 0.6))}V{floor}z"/>')
    for one in value[unlike & np.isfinite(value)]:
        where = pixel(chart.x(float(one)))
        chart.parts.append(f'<path class="unlike" d="M{where} {floor}v-9"/>')
    return chart.svg(f"Histogram of {len(stated)} sensors, in {unit}")
