"""The page of a lot."""

from collections import Counter
from collections.abc import Mapping, Sequence
from datetime import datetime
from itertools import islice
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

import numpy as np

from calib.diagnosis.population.pool import FALSE_ALARM, PooledTrial
from calib.diagnosis.population.spread import Spread
from calib.poses.imu_log import BoolArray, FloatArray
from calib.rounding import with_sd
from pipeline.drawings.charts import SMALL, Chart, across, pixel, upward
from pipeline.errors import DONE
from pipeline.fleet.board import board_of
from pipeline.fleet.limits import FAIL, limit_lines
from pipeline.fleet.over_time import MOST_SENSORS, SensorOverTime
from pipeline.fleet.population import (
    TriadPopulation,
    copies_text,
    is_unrepeatable,
    p_text,
    parameter_name,
    pool_headline,
    pool_text,
    repeat_text,
)
from pipeline.fleet.sessions import SESSIONS_FOLDER
from pipeline.fleet.table import column
from pipeline.report.page import css_text
from pipeline.report.page_templates import page_templates
from pipeline.results.json_values import unit_of
from pipeline.results.names import REPORT_NAME
from pipeline.text.formatting import DISPLAY

if TYPE_CHECKING:
    from pandas import DataFrame


MOST_BARS = 40
"""Bars of a chart 320 units wide; derived: narrower ones are lines."""


def histogram(value: FloatArray, unlike: BoolArray, unit: str) -> str:
    """The chart as SVG.

    Parameters
    ----------
    value : array, shape (S,)
        From the lot's mean; NaN where a sensor has none.
    unlike : array of bool, shape (S,)
        Sensors unlike the lot: marks on the axis, in the page's colour of warnings.
    unit : str
        Of the values.
    """
    stated = value[np.isfinite(value)]
    x = across(stated, SMALL)
    bars = int(np.clip(np.sqrt(len(stated)) * 2, 5, MOST_BARS))
    counts, edges = np.histogram(stated, bins=bars, range=(x.low, x.high))
    most = max(1.08 * counts.max(), FEWEST_SENSORS)
    chart = Chart(x, upward(0.0, most, canvas=SMALL), unit, "sensors", SMALL)
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


PAGE_NAME = "fleet.html"
FEWEST_SENSORS = 4  #: at the top of a histogram, so that its marks are whole; of a picture
MOST_ROWS = 100
"""Rows of a list on the page; the table has all. Derived: what a person looks through, and 10,000
sensors leave the page under 2 MB."""


def fleet_html(
    title: str, table: "DataFrame", populations: Sequence[TriadPopulation],
    over_time: Mapping[str, Sequence[SensorOverTime]], reports: bool,
    when: datetime | None = None,
) -> str:
    """The whole page.

    Parameters
    ----------
    title : str
        What the lot is called.
    table : DataFrame
        Its rows.
    populations : sequence of TriadPopulation
    over_time : mapping of str to sequence of SensorOverTime
        Sensors with several sessions, by triad.
    reports : bool
        Whether each session has a report to link to.
    when : datetime, optional
        Local time, for the head of the page.
    """
    failed = table[table["exit_code"] != DONE].drop_duplicates("session")
    sessions = table["session"].nunique()
    return page_templates().get_template(PAGE_NAME).render(
        title=title,
        title_css=css_text(title),
        when=f"{when:%Y-%m-%d %H:%M}" if when else "",
        sessions=sessions,
        calibrated=sessions - len(failed),
        sensors=table["sensor"].nunique(),
        limits=list(islice(limit_lines(table), MOST_ROWS + 1)),
        beyond=FAIL,
        triads=[_triad_view(one, over_time[one.triad], reports) for one in populations],
        failed=[{"name": row.session, "code": row.exit_code, "reason": row.reason}
                for row in failed[:MOST_ROWS].itertuples()],
        failed_count=len(failed),
        most=MOST_ROWS,
        most_over_time=MOST_SENSORS,
        level=FALSE_ALARM,
        p_text=p_text,
        parameter_name=parameter_name,
    )


def _triad_view(
    population: TriadPopulation, over_time: Sequence[SensorOverTime], reports: bool
) -> dict[str, Any]:
    """Contents of the page on one triad."""
    verdicts = Counter(population.rows["verdict"])
    named = Counter(name for missing in population.rows["missing"]
                    for name in missing.split(" + ") if name)
    unlike, unlike_count = _unlike(population, reports)
    board = board_of(population.rows, population.triad, MOST_ROWS)
    return {
        "name": population.triad,
        "sensors": len(population.sensors),
        "sessions": len(population.rows),
        "is_good": population.pool is not None and not population.pool.effects,
        "pool": pool_text(population),
        "headline": pool_headline(population),
        "copies": copies_text(population),
        "verdicts": [(code, n, n / len(population.rows)) for code, n in verdicts.most_common()],
        "effects": _effect_rows(population, named),
        "board": board,
        "links": dict(_links([row.session for row, _ in board.rows], reports)),
        "unrepeatable": is_unrepeatable(population),
        "histograms": [_histogram_view(spread, population) for spread in population.spreads],
        "unlike": unlike,
        "unlike_count": unlike_count,
        "repeat": repeat_text(population),
        "repeats": population.repeats,
        "over_time": [(one, _links(one.sessions, reports)) for one in over_time],
    }


def _effect_rows(population: TriadPopulation, named: Counter[str]) -> list[dict[str, Any]]:
    """Each candidate: the sessions that name it, and the pool's result; strongest first."""
    pooled = population.pool
    best: dict[str, PooledTrial] = {}
    for one in pooled.candidates if pooled else ():
        if one.trial.name not in best or one.exponent > best[one.trial.name].exponent:
            best[one.trial.name] = one
    in_pool = {effect.name for effect in pooled.effects} if pooled else set()
    names = sorted({*best, *named}, key=lambda name: (
        name not in in_pool, -named[name], -(best[name].exponent if name in best else 0.0)))
    rows = []
    for name in names:
        row = {"name": name, "sessions": named[name], "is_missing": name in in_pool}
        shown = best.get(name)
        row |= {"shown": "", "p_common": "", "p_any": ""} if shown is None else {
            "shown": shown.sessions, "p_common": p_text(shown.p_common),
            "p_any": p_text(shown.p_any)}
        rows.append(row)
    return rows


def _histogram_view(spread: Spread, population: TriadPopulation) -> dict[str, Any]:
    """One parameter: its histogram about the lot's mean, that mean, spread and typical sd."""
    of_lot, (unit, factor) = spread.of_lot, _deviation_unit(spread, population)
    typical_sd = float(np.nanmedian(spread.sd))
    return {
        "name": parameter_name(spread.name),
        "drawing": histogram(factor * (spread.value - of_lot.mean), spread.unlike, unit),
        "mean": f"{with_sd(of_lot.mean, of_lot.mean_sd)} "
                f"{unit_of(spread.name[:-2], population.triad)}",
        "spread": f"{with_sd(factor * of_lot.spread, factor * of_lot.spread_sd)} {unit}"
                  if of_lot.spread else "0",
        "typical_sd": f"{factor * typical_sd:.2g} {unit}",
        "unlike": int(spread.unlike.sum()),
    }


def _deviation_unit(spread: Spread, population: TriadPopulation) -> tuple[str, float]:
    """Unit in which sensors differ in a parameter, and its number in one unit of the parameter.

    mm/s² or °/s of a bias, per cent of a gain: by the median gain of the axis over the lot.
    """
    key, axis = spread.name[:-2], spread.name[-1]
    if key == "misalignment_rad":
        return "°", float(np.degrees(1.0))
    gain = abs(np.nanmedian(column(population.rows, f"scale_counts_per_unit_{axis}")))
    unit, per_si = ("%", 100.0) if key == "scale_counts_per_unit" else DISPLAY[population.triad]
    return unit, float(per_si / gain)


def _unlike(population: TriadPopulation, reports: bool) -> tuple[list[dict[str, Any]], int]:
    """Sensors unlike the lot with all its parameters, the most distant first, and their number."""
    farthest = np.zeros(len(population.sensors))
    for spread in population.spreads:
        farthest = np.maximum(farthest, np.where(spread.unlike, np.abs(spread.distance), 0.0))
    rows = []
    for i in np.argsort(-farthest, kind="stable")[: min(np.count_nonzero(farthest), MOST_ROWS)]:
        off = sorted((one for one in population.spreads if one.unlike[i]),
                     key=lambda one: -abs(one.distance[i]))
        what = []
        for one in off:
            unit, factor = _deviation_unit(one, population)
            off_by = with_sd(factor * (one.value[i] - one.of_lot.mean), factor * one.sd[i])
            what.append(f"{parameter_name(one.name)} {off_by} {unit} "
                        f"({abs(one.distance[i]):.1f} sds)")
        rows.append({"sensor": population.sensors[i], "what": ", ".join(what),
                     "links": _links(population.sessions_of(i), reports)})
    return rows, int(np.count_nonzero(farthest))


def _links(sessions: Sequence[str], reports: bool) -> list[tuple[str, str]]:
    """Name and address of each session's report, the address empty where there is none."""
    return [(name, f"{SESSIONS_FOLDER}/{quote(name)}/{REPORT_NAME}" if reports else "")
            for name in sessions]
