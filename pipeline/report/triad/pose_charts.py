"""Charts of the poses of one triad: their directions, and their residuals."""

import math
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammainc

from calib.diagnosis.next_measurement.advice import pose_in_words
from calib.fit.validation.predicted_pose import PredictedPose
from calib.numbers import RPM
from calib.poses.imu_log import TEMPERATURE, FloatArray
from calib.poses.pose_set import PoseSet
from pipeline.console.run_text import leading_covariate
from pipeline.drawings.charts import (
    SHAPES,
    Canvas,
    Chart,
    Figure,
    Scale,
    across,
    drawing,
    nice_limit,
    pixel,
    rightward,
    tick_text,
    upward,
)
from pipeline.report.triad.pose_sphere import coverage_of
from pipeline.stages.triads import TriadResult
from pipeline.text.formatting import DISPLAY, count, with_sd

SHOWN_SD = 4.0  #: residual charts reach at least this many typical sds
FRACTIONS = (-1.0, -0.5, 0.0, 0.5, 1.0)  #: shares of a chart's limit that have a number
MOST_COLUMNS = 8  #: logged columns with a chart; those that explain most of the misfit first
SPHERE = Canvas(400.0, 232.0, 0.0, 0.0, "chart sphere")
SPHERE_RADIUS = 88.0  #: px of the drawing; layout
SPHERE_CENTRES = (104.0, 296.0)  #: px from the left; layout
RUN_COLOURS = 6  #: number of colours of the style sheet
BY_THE_EQUATOR = 0.1  #: |z| up to which a pose is drawn in both hemispheres

EXCLUDED = "excluded"  #: class of their marks, and what their group in the chart is called

TITLES = {
    "time_s": ("time", "time since the session began [min]", 1 / 60),
    "spin_rad_s": ("the plate's rate", "rate of the plate [rpm]", 1 / RPM),
    TEMPERATURE: ("temperature", "temperature [°C]", 1.0),
}


def residual_figure(result: TriadResult) -> Figure:
    """The residual of every pose with its noise band, in the order of the configuration."""
    poses, excluded = result.comparison.poses, shown_excluded(result)
    position = np.arange(len(poses) + len(excluded), dtype=float)
    at_rest = result.calibration.fit.equations.is_null
    chart = _residual_chart(result, rightward(-0.7, len(position) - 0.3), "pose")
    runs = [*(pose.run for pose in poses), *[EXCLUDED] * len(excluded)]
    starts = [i for i, run in enumerate(runs) if i == 0 or runs[i - 1] != run]
    middles = [(a + b - 1) / 2 for a, b in zip(starts, [*starts[1:], len(runs)], strict=True)]
    if len(starts) > 1:
        chart.x_axis([(at, runs[i][:10]) for at, i in zip(middles, starts, strict=True)])
        for start in starts[1:]:
            at = pixel(chart.x(start - 0.5))
            ends = f"{chart.y.end:g}V{chart.y.start:g}"
            chart.parts.append(f'<path class="grid" d="M{at} {ends}"/>')
    else:
        every = max(1, len(poses) // 6)
        chart.x_axis([(i, str(i + 1)) for i in range(0, len(poses), every)])
    for i, pose in enumerate(poses):
        at = pixel(chart.x(position[i]))
        low = 0.0 if at_rest[i] else -pose.sd  # the residual of a pose at rest is a length
        chart.bar(position[i], low, pose.sd, "band", f' data-i="{i}" data-x="{at}"')
    _marks(chart, result, position[: len(poses)], whole_title=True)
    _hollow_marks(chart, result, position[len(poses) :])
    within = sum(abs(pose.in_sd) <= 1 for pose in poses)
    worst = result.comparison.worst(1)[0]
    caption = (
        f"{within} of {len(poses)} residuals are smaller than one sd; "
        f"{_expected_within(result):.0f} are expected. The largest is "
        f"{abs(worst.in_sd):.1f} sds: {pose_in_words(result.calibration.fit, worst.label)}."
    )
    if excluded:
        one = len(excluded) == 1
        caption += (f" The hollow {'mark is the pose' if one else 'marks are the poses'} that the "
                    f"configuration excludes, by the fit without {'it' if one else 'them'}.")
    return _figure(chart, "Residual of every pose", caption, _good_residuals(at_rest))


def _good_residuals(at_rest: NDArray[np.bool_]) -> str:
    """The look of good residuals; a pose with the plate stopped cannot scatter about zero."""
    bar = "most of them inside their bar (one sd of the noise of the pose)"
    length = "the length of the remaining vector, which cannot be negative"
    if at_rest.all():
        return f"the marks have no pattern, {bar}. Each shows {length}."
    stopped = f" A pose with the plate stopped shows {length}." if at_rest.any() else ""
    return f"the marks scatter about zero without a pattern, {bar}.{stopped}"


def _expected_within(result: TriadResult) -> float:
    """The expected number of residuals below one sd if the model is right.

    The fit absorbs part of the noise: it reduces the variance of a residual by ``dof / rows``.
    """
    fit = result.calibration.fit
    share = max(fit.dof, 1) / fit.equations.data_count
    null = int(fit.equations.is_null.sum())
    inside = [math.erf(1 / math.sqrt(2 * share)), float(gammainc(1.5, 1.5 / share))]
    return inside[0] * (len(fit.poses) - null) + inside[1] * null


def covariate_figures(result: TriadResult) -> Iterator[Figure]:
    """The residual against time, rate and every logged column that varies."""
    poses = result.calibration.fit.poses
    candidates = {"time_s": poses.time_s, "spin_rad_s": poses.spin_rad_s}
    evidence = {c.name: c.log_evidence for c in result.diagnosis.ranking if c.kind == "unknown"}
    columns = sorted(poses.columns, key=lambda name: -evidence.get(name, -np.inf))
    residuals = np.array([pose.residual for pose in result.comparison.poses])
    for name in columns[:MOST_COLUMNS]:
        candidates[name] = poses.columns[name]
    for name, values in candidates.items():
        if not np.isfinite(values).all() or np.ptp(values) == 0:
            continue
        short, title, factor = TITLES.get(name, (name, name, 1.0))
        hollow = np.array([_covariate(one.poses, name) for one in shown_excluded(result)])
        reach = np.concatenate([values, hollow[np.isfinite(hollow)]]) * factor
        chart = _residual_chart(result, across(reach), title)
        chart.x_axis([(value, tick_text(value)) for value in chart.x.ticks()])
        _marks(chart, result, values * factor, whole_title=False)
        _hollow_marks(chart, result, hollow * factor)
        follows = leading_covariate(result) == name
        yield _figure(
            chart, f"Residual against {short}",
            f"The misfit follows {short}, which explains more of it than any other covariate."
            if follows else "",
            f"no slope, no bend and no step: the residuals do not depend on {short}.",
            f"{count(len(values), 'pose')} from {tick_text(np.min(values) * factor)} to "
            f"{tick_text(np.max(values) * factor)}. The correlation of residual and {short} is "
            f"{np.corrcoef(values, residuals)[0, 1]:+.2f}.",
        )


def residual_limit(result: TriadResult) -> float:
    """The limit of the residual charts, SI; the script of the page computes the same."""
    poses = result.comparison.poses
    typical = sorted(pose.sd for pose in poses)[len(poses) // 2]
    return max(SHOWN_SD * typical, *(abs(pose.residual) + pose.sd for pose in poses))


def _residual_chart(result: TriadResult, x: Scale, x_title: str) -> Chart:
    unit, factor = DISPLAY[result.triad]
    limit = nice_limit(residual_limit(result) * factor)
    chart = Chart(x, upward(-limit / factor, limit / factor), x_title, f"residual [{unit}]")
    chart.y_axis([(part * limit / factor, tick_text(part * limit)) for part in FRACTIONS],
                 [f' data-fraction="{part:g}"' for part in FRACTIONS])
    chart.level(0.0)
    return chart


def _figure(chart: Chart, title: str, caption: str, good: str, alternative: str = "") -> Figure:
    """``alternative`` replaces ``caption`` for screen readers."""
    attribute = f' data-top="{chart.y.end:g}" data-bottom="{chart.y.start:g}"'
    drawing = chart.svg(f"{title}. {caption or alternative}", attribute, "residuals")
    return Figure(title, drawing, good, caption)


def _marks(chart: Chart, result: TriadResult, xs: FloatArray, *, whole_title: bool) -> None:
    number = _run_numbers(result)
    unit, factor = DISPLAY[result.triad]
    for i, pose in enumerate(result.comparison.poses):
        title = pose.label
        if whole_title:
            value = with_sd(pose.residual * factor, pose.sd * factor)
            title += f": {value} {unit}, {pose.in_sd:+.1f} sd"
        shape = number[pose.run]
        attribute = f' data-i="{i}" data-x="{pixel(chart.x(xs[i]))}"'
        attribute += ' data-titled="1"' if whole_title else ""
        chart.mark(xs[i], pose.residual, shape, f"mark run{shape % RUN_COLOURS}", title, attribute)


def shown_excluded(result: TriadResult) -> list[PredictedPose]:
    """The excluded poses of which the fit says something."""
    return [one.predicted for one in result.excluded if one.predicted is not None]


def _covariate(poses: PoseSet, name: str) -> float:
    """Time, rate or logged column of one pose; NaN where it is not known."""
    known = {"time_s": poses.time_s, "spin_rad_s": poses.spin_rad_s, **poses.columns}
    return float(known[name][0]) if name in known else math.nan


def _hollow_marks(chart: Chart, result: TriadResult, xs: FloatArray) -> None:
    """The excluded poses at ``xs``; those far off stand at the edge of the chart."""
    unit, factor = DISPLAY[result.triad]
    for x, one in zip(xs, shown_excluded(result), strict=True):
        if not np.isfinite(x):
            continue
        pose = one.residual
        value = with_sd(pose.residual * factor, pose.sd * factor)
        y = float(np.clip(pose.residual, chart.y.low, chart.y.high))
        chart.mark(x, y, 0, EXCLUDED, f"{pose.label}: excluded; {value} {unit}",
                   f' data-x="{pixel(chart.x(x))}" data-value="{pose.residual * factor:.6g}"')


def _run_numbers(result: TriadResult) -> Mapping[str, int]:
    """The runs, numbered in their order: what shape and colour their marks have."""
    runs = dict.fromkeys(pose.run for pose in result.comparison.poses)
    return {run: i for i, run in enumerate(runs)}


def run_legend(result: TriadResult) -> list[tuple[str, str, str]]:
    """Class, outline and name of every run; empty for one run."""
    number = _run_numbers(result)
    if len(number) < 2:
        return []
    return [(f"run{i % RUN_COLOURS}", SHAPES[i % len(SHAPES)], run) for run, i in number.items()]


# --- coverage ----------------------------------------------------------------------------------


def coverage_figure(result: TriadResult) -> Figure | None:
    """The directions of the measured vector in the axes of the sensor, on two hemispheres.

    None where every pose is at rest with the plate stopped: such a vector has no direction. The 18
    faces and edges are marked where the poses follow that design, which covers most of them.
    """
    fit = result.calibration.fit
    turning = ~fit.equations.is_null
    vectors = fit.rows.vector[turning]
    unit = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    if not len(unit):
        return None
    coverage = coverage_of(unit)
    parts: list[str] = []
    names = ("+z hemisphere", "−z hemisphere")
    for centre, sign, name in zip(SPHERE_CENTRES, (1, -1), names, strict=True):
        parts += _hemisphere(centre, name)
        for direction, is_covered in coverage.expected:
            corner = np.count_nonzero(direction) == 3
            kind = "natural" + (" corner" if corner else "") + ("" if is_covered else " missing")
            outline = "M-7 0a7 7 0 1 0 14 0a7 7 0 1 0-14 0z" if is_covered else "M-5-5L5 5M5-5L-5 5"
            parts += _sphere_mark(centre, sign, direction, kind, outline)
        for direction in unit:
            parts += _sphere_mark(centre, sign, direction, "direction", SHAPES[0])
    if coverage.expected:
        good = ("every solid ring contains a dot, and there is no cross: the poses cover the 6 "
                "faces and 12 edges. Corners (dotted) are optional; they determine cross-coupling.")
    else:
        good = "the dots are spread over both hemispheres."
    title = "Attitude coverage"
    figure = drawing(parts, f"{title}. {coverage.caption}", SPHERE)
    return Figure(title, figure, good, coverage.caption)


def _hemisphere(centre: float, name: str) -> list[str]:
    middle = SPHERE_RADIUS + 14
    r = SPHERE_RADIUS
    return [
        f'<circle class="rim" cx="{centre:g}" cy="{middle:g}" r="{r:g}"/>',
        f'<path class="grid" d="M{centre - r:g} {middle:g}h{2 * r:g}M{centre:g} '
        f'{middle - r:g}v{2 * r:g}"/>',
        f'<text class="tick" x="{centre + r - 2:g}" y="{middle + 18:g}" text-anchor="end">'
        "+x</text>",
        f'<text class="tick" x="{centre + 11:g}" y="{middle - r - 3:g}">+y</text>',
        f'<text class="title" x="{centre:g}" y="{SPHERE.height - 10:g}" text-anchor="middle">'
        f"{name}</text>",
    ]


def _sphere_mark(
    centre: float, sign: int, direction: FloatArray, kind: str, outline: str
) -> list[str]:
    """A mark in Lambert's equal-area view of a hemisphere; nothing if it is on the other one."""
    x, y, z = direction
    up = sign * float(z)
    if up < -BY_THE_EQUATOR:
        return []
    rho = SPHERE_RADIUS * np.sqrt(max(1 - max(up, 0.0), 0.0))
    across_axis = max(float(np.hypot(x, y)), 1e-12)
    at_x, at_y = centre + rho * x / across_axis, SPHERE_RADIUS + 14 - rho * y / across_axis
    return [
        f'<path class="{kind}" transform="translate({pixel(at_x)} {pixel(at_y)})" d="{outline}"/>'
    ]
