"""Figures 4 to 6 of the publication: the parameters against the iterations, from three starts."""

import io
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from calib.fit.least_squares.angrisano import data_sheet_start
from calib.poses.imu_log import AXES
from tests.studies.angrisano.iteration import Iterations
from tests.studies.angrisano.published import ACCELEROMETER
from tests.studies.angrisano.table2 import StartStudy, start_study

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INSIDE_RAD = math.radians(15.0)
OUTSIDE_RAD = math.radians(25.0)


@dataclass(frozen=True, eq=False)
class IterationFigure:
    """One figure: its file's stem, its title, the iteration and how it ended."""

    stem: str
    title: str
    iterations: Iterations
    ended: str

    def png(self) -> bytes:
        """The figure as a PNG file; the same bytes for the same iteration."""
        from matplotlib.figure import Figure  # the tables need none

        figure = Figure(figsize=(9.0, 6.0), layout="constrained")
        draw(figure, self)
        target = io.BytesIO()
        figure.savefig(target, format="png", dpi=110, metadata={"Software": None})
        return target.getvalue()


def paper_figures() -> Iterator[IterationFigure]:
    """Figures 4, 5 and 6 on the session of the first set."""
    study = start_study()
    inside = study.start("misalignment", INSIDE_RAD)
    outside = study.start("misalignment", OUTSIDE_RAD)
    yield _figure(study, "figure4", "Fig. 4: start from the data sheet",
                  data_sheet_start(ACCELEROMETER))
    yield _figure(study, "figure5", f"Fig. 5: all alpha at {math.degrees(INSIDE_RAD):.0f}°, inside",
                  inside)
    yield _figure(study, "figure6",
                  f"Fig. 6: all alpha at {math.degrees(OUTSIDE_RAD):.0f}°, outside", outside)


def _figure(
    study: StartStudy, stem: str, title: str, start: np.ndarray
) -> IterationFigure:
    found = study.as_printed(start)
    right = study.is_right(found.x[-1])
    ended = (
        f"stopped after {found.count} iterations "
        f"{'at the solution' if right else 'far from the solution'}"
        if found.stopped
        else "did not stop"
    )
    return IterationFigure(stem, title, found, ended)


def draw(figure: "Figure", shown: IterationFigure) -> None:
    """Four panels: alpha, b, k⁻¹ and the rms misclosure against the iteration."""
    x, rms = shown.iterations.x, shown.iterations.rms
    panels = figure.subplots(2, 2, sharex=True)
    figure.suptitle(f"{shown.title}: {shown.ended}")
    _lines(panels[0, 0], np.degrees(x[:, :3]), "alpha [°]")
    _lines(panels[0, 1], x[:, 3:6], "b [counts]")
    _lines(panels[1, 0], 1 / x[:, 6:], "k⁻¹ [counts/(m/s²)]")
    panels[1, 1].semilogy(range(len(rms)), rms, "k.-")
    panels[1, 1].set_ylabel("rms of |N| - s [m/s²]")
    panels[1, 1].grid(alpha=0.3)
    for panel in panels[1]:
        panel.set_xlabel("iteration")
        panel.set_xticks(range(len(rms)))
    panels[0, 0].legend(loc="best")


def _lines(panel: "Axes", values: np.ndarray, label: str) -> None:
    for axis, column in zip(AXES, values.T, strict=True):
        panel.plot(range(len(column)), column, ".-", label=axis)
    panel.set_ylabel(label)
    panel.grid(alpha=0.3)
