"""The figure of an Allan deviation: every axis with its band, and the fitted processes."""

import io
import math
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from calib.noise.allan import NAMES
from calib.noise.coefficients import AxisNoise
from calib.poses.imu_log import AXES

COLOURS = ("#0072b2", "#d55e00", "#009e73")  #: Okabe and Ito's, for x, y, z
SHOWN = {"gyroscope": ("Gyroscope", "°/s", math.degrees(1.0)),
         "accelerometer": ("Accelerometer", "mm/s²", 1000.0)}
SLOPES = {"noise_density": ("N: slope −1/2", "--"), "bias_instability": ("B: flat", ":"),
          "random_walk": ("K: slope +1/2", "-.")}
INCHES = (11.0, 5.0)  #: size of two triads side by side; layout


def noise_figure(log: str, triads: Mapping[str, Sequence[AxisNoise]]) -> dict[str, bytes]:
    """The figure by its form, ``svg`` and ``png``: points and bands measured, lines fitted."""
    figure = Figure(figsize=(INCHES[0] * len(triads) / 2, INCHES[1]), layout="constrained")
    FigureCanvasAgg(figure)
    for place, (triad, axes) in enumerate(triads.items()):
        plot = figure.add_subplot(1, len(triads), place + 1)
        title, unit, factor = SHOWN[triad]
        for name, colour, axis in zip(AXES, COLOURS, axes, strict=True):
            tau = axis.curve.tau_s
            plot.fill_between(tau, factor * axis.curve.low, factor * axis.curve.high, color=colour,
                              alpha=0.2, linewidth=0)
            plot.plot(tau, factor * axis.curve.deviation, ".", color=colour, label=name)
            plot.plot(tau, factor * axis.fitted, "-", color=colour, linewidth=1)
        bottom = factor * min(float(axis.curve.low.min()) for axis in axes)
        mean = np.mean([axis.parts for axis in axes], axis=0)
        for process, (label, style) in SLOPES.items():
            line = factor * np.sqrt(mean[:, NAMES.index(process)])
            if (line > 0.5 * bottom).any():
                plot.plot(axes[0].curve.tau_s, np.where(line > 0.5 * bottom, line, np.nan), style,
                          color="#666666", linewidth=1, label=label)
        plot.set(xscale="log", yscale="log", title=title, xlabel="averaging time τ [s]",
                 ylabel=f"Allan deviation [{unit}]")
        plot.grid(which="both", color="#dddddd", linewidth=0.5)
        plot.legend(frameon=False)
    figure.suptitle(f"{log}: bands are 68 %, lines are fitted", fontsize=10, parse_math=False)
    svg = _written(figure, "svg")
    figure.set_layout_engine("none")  # the places are known now
    return {"svg": svg, "png": _written(figure, "png")}


def _written(figure: Figure, form: str) -> bytes:
    buffer = io.BytesIO()
    metadata = {"Date": None} if form == "svg" else None
    figure.savefig(buffer, format=form, metadata=metadata, dpi=120)
    return buffer.getvalue()
