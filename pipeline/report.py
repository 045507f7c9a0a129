"""report.html: the verdict, the numbers and the residual of every pose, in one file."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from jinja2 import Environment, PackageLoader, StrictUndefined

from calib.compare import PoseResidual
from pipeline.display import DISPLAY, RPM, relative, with_sd
from pipeline.history import Step, history_rows
from pipeline.rates import SettingRate
from pipeline.runner import Outcome
from pipeline.screen import base_rows, effect_rows, triad_line
from pipeline.triads import TriadResult

REPORT_NAME = "report.html"
TEMPLATE_NAME = "report.html"

CHART_WIDTH, CHART_HEIGHT = 720, 220
MARGIN = 44  #: of the chart, for the numbers beside it
SHOWN_SD = 4.0  #: the chart reaches at least this many typical sds


@dataclass(frozen=True)
class PoseMark:
    """One pose in the chart: pixels of its residual, of its ±1 sd, and what it says."""

    x: float
    y: float
    low: float
    high: float
    says: str


@dataclass(frozen=True)
class ResidualChart:
    """The residual of every pose with its sd, ready to be drawn as SVG."""

    triad: str
    unit: str
    limit: float
    width: int
    height: int
    zero: float
    marks: tuple[PoseMark, ...]
    says: str


def residual_chart(result: TriadResult) -> ResidualChart:
    """Lay out the residuals of a triad."""
    unit, factor = DISPLAY[result.triad]
    poses = result.comparison.poses
    typical = sorted(pose.sd for pose in poses)[len(poses) // 2]
    limit = max(SHOWN_SD * typical, *(abs(pose.residual) + pose.sd for pose in poses))
    zero = CHART_HEIGHT / 2
    step = (CHART_WIDTH - MARGIN) / len(poses)

    def pixel(value: float) -> float:
        return zero - value / limit * (zero - 8)

    marks = tuple(
        PoseMark(
            x=MARGIN + (i + 0.5) * step,
            y=pixel(pose.residual),
            low=pixel(-pose.sd),
            high=pixel(pose.sd),
            says=_pose_says(pose, unit, factor),
        )
        for i, pose in enumerate(poses)
    )
    within = sum(abs(pose.in_sd) <= 1 for pose in poses)
    worst = result.comparison.worst(1)[0]
    return ResidualChart(
        triad=result.triad,
        unit=unit,
        limit=limit * factor,
        width=CHART_WIDTH,
        height=CHART_HEIGHT,
        zero=zero,
        marks=marks,
        says=(
            f"{within} of {len(poses)} poses lie within one sd of the model (about two thirds are "
            f"expected); the farthest is {worst.label}, {abs(worst.in_sd):.1f} sds away."
        ),
    )


def _pose_says(pose: PoseResidual, unit: str, factor: float) -> str:
    value = with_sd(pose.residual * factor, pose.sd * factor)
    return f"{pose.label} ({pose.run}): {value} {unit}, {pose.in_sd:+.1f} sds"


def _rate_row(rate: SettingRate) -> list[str]:
    filmed = bool(rate.clips)
    return [
        rate.name,
        f"{rate.rate_rad_s / RPM:.5f} rpm",
        f"{rate.rate_rad_s:.7f} rad/s",
        relative(rate.sd_rad_s / rate.rate_rad_s),
        relative(rate.image_sd_rad_s / rate.rate_rad_s) if filmed else "",
        relative(rate.timebase_sd_rad_s / rate.rate_rad_s) if filmed else "",
        f"{sum(clip.revolutions for clip in rate.clips):.1f}" if filmed else "stated",
        rate.plate.direction or "",
    ]


def _phase_words(rate: SettingRate) -> list[str]:
    """What the phase track of each clip says, once for clips that say the same."""
    return list(dict.fromkeys(f"{rate.name}: {clip.diagnosis.says}" for clip in rate.clips))


def _degrees(result: TriadResult) -> list[str]:
    parameters = result.calibration.parameters
    return [
        with_sd(math.degrees(v), math.degrees(s))
        for v, s in zip(parameters.misalignment_rad, parameters.sd[0], strict=True)
    ]


def report_html(outcome: Outcome, history: Sequence[Step]) -> str:
    """The whole page; it needs no other file and no network."""
    environment = Environment(
        loader=PackageLoader("pipeline", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(TEMPLATE_NAME).render(
        title=outcome.config.title or outcome.config.source.path.stem,
        sensor=outcome.config.sensor.name,
        rates=[_rate_row(rate) for rate in outcome.rates.values()],
        phases=[words for rate in outcome.rates.values() for words in _phase_words(rate)],
        triads=[
            {
                "name": result.triad,
                "line": triad_line(result),
                "says": result.diagnosis.says,
                "model": ", ".join(result.calibration.fit.model.names),
                "base": base_rows(result.triad, result.calibration.parameters),
                "degrees": _degrees(result),
                "effects": effect_rows(result),
                "widening": result.calibration.widening,
                "gravity": result.gravity,
                "chart": residual_chart(result),
            }
            for result in outcome.triads
        ],
        warnings=outcome.warnings,
        history=history_rows(history),
    )
