"""The page of ``pipeline rate --flutter --page``: figures and charts of how a platter turns."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from calib.numbers import RPM
from pipeline.console.flutter_text import flutter_lines
from pipeline.drawings.charts import Figure
from pipeline.report.layout.page_templates import page_templates
from pipeline.report.plate.speed_charts import polar_figure, spectrogram_figure, spectrum_figure
from pipeline.stages.flutter import MeasuredFlutter


@dataclass(frozen=True)
class SpeedView:
    """One clip or log as the page shows it; ``facts`` are names and values."""

    title: str
    facts: tuple[tuple[str, str], ...]
    figures: tuple[Figure, ...]


def speed_page(title: str, measured: Sequence[MeasuredFlutter]) -> str:
    """The page as text."""
    return page_templates().get_template("speed.html").render(
        title=title, views=[_view(one) for one in measured])


def _view(measured: MeasuredFlutter) -> SpeedView:
    head, *lines = flutter_lines(measured)
    figures = (polar_figure(measured.course), spectrum_figure(measured.figures, measured.course),
               spectrogram_figure(measured.course))
    return SpeedView(
        head.removeprefix("flutter "),
        (("mean rate", f"{measured.course.rate_rad_s / RPM:.4f} rpm"), *_facts(lines)),
        tuple(figure for figure in figures if figure is not None),
    )


def _facts(lines: Sequence[str]) -> Iterator[tuple[str, str]]:
    """The lines of the terminal: a name, two blanks or more, a value; a remark has no name."""
    for line in lines:
        name, _, value = line.strip().partition("  ")
        yield (name, value.strip()) if value else ("remark", name)
