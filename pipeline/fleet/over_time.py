"""A sensor over time: changes between its sessions, and when to calibrate it again.

The comparison and the pace are those of `pipeline compare`
(:mod:`pipeline.results.comparison`, :mod:`pipeline.results.ageing`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from html import escape
from pathlib import Path

import numpy as np

from calib.poses.imu_log import FloatArray
from pipeline.console.comparison_text import ageing_text, sds_text
from pipeline.drawings.charts import SMALL, Chart, across, nice_limit, pixel, upward
from pipeline.errors import UnreadableInput
from pipeline.fleet.population import TriadPopulation
from pipeline.fleet.sessions import folder_of
from pipeline.results.ageing import DAY_S, LEAST_DAYS, Ageing, ageing_of, recorded_at
from pipeline.results.comparison import ComparedParameter, ComparedTriad, compare_calibrations
from pipeline.results.json_values import Json, json_value, numbers
from pipeline.results.read import Stored, load_results
from pipeline.text.formatting import with_minus_signs

MOST_SENSORS = 24
"""Sensors that are shown over time, those that moved most; derived: a page of charts, and a second
of reading results where each sensor has four sessions."""
COLOURS = 3  #: parameters with a line in a colour of its own; there are so many
NAME_PX = 14.0  #: height of a name in a chart; a height of text
NAMED = replace(SMALL, margin_right=70.0)  #: with room for names at the ends of lines


@dataclass(frozen=True, eq=False)
class SensorOverTime:
    """One triad of a sensor in its S sessions, in the order in which they were recorded.

    Parameters
    ----------
    sensor : str
    sessions : tuple of str
    days : array, shape (S,)
        Since the first session; NaN where the sessions do not tell when they were recorded.
    compared : ComparedTriad
        Every session against the first.
    ageing : Ageing or None
    """

    sensor: str
    sessions: tuple[str, ...]
    days: FloatArray
    compared: ComparedTriad
    ageing: Ageing | None

    @property
    def limit_sd(self) -> float:
        """Sds that the farthest parameter of all sessions exceeds in 1 of 100 sensors by chance."""
        return self.compared.chance_limit_sd(*range(1, len(self.sessions)))

    @cached_property
    def moved(self) -> list[ComparedParameter]:
        """The parameters that are farther from the first session than chance explains."""
        far = {one.name: float(np.nanmax(np.abs(one.apart_sd), initial=0.0))
               for one in self.compared.parameters}
        return sorted((one for one in self.compared.parameters if far[one.name] > self.limit_sd),
                      key=lambda one: -far[one.name])

    @property
    def in_words(self) -> str:
        """The changes, and when to calibrate again, in words."""
        limit = f"{self.limit_sd:.1f} sds, which chance exceeds in 1 of 100 sensors"
        far = ", ".join(f"{one.name} by {sds_text(_farthest(one), '+')}" for one in self.moved)
        text = with_minus_signs(f"These moved by more than {limit}: {far}." if far
                                else f"Nothing moved by more than {limit}.")
        if self.ageing is None:
            return text
        when = ageing_text(self.ageing, self.compared.triad)
        return f"{text} {when[0].upper()}{when[1:]}"

    @property
    def chart(self) -> str:
        """Every parameter's distance from the first session against time, as SVG."""
        dated = bool(np.isfinite(self.days).all())
        at = self.days if dated else np.arange(1.0, len(self.sessions) + 1)
        shown = [one for one in self.compared.parameters if np.isfinite(one.apart_sd).sum() > 1]
        apart = np.array([one.apart_sd for one in shown]).reshape(len(shown), len(at))
        reach = nice_limit(1.05 * max(float(np.nanmax(np.abs(apart), initial=0.0)), self.limit_sd))
        chart = Chart(across(at, NAMED), upward(-reach, reach, canvas=NAMED),
                      "days" if dated else "session", "from the first session [sd]", NAMED)
        chart.stripe(-self.limit_sd, self.limit_sd)
        chart.axes(None if dated else [(k, f"{k:g}") for k in at])
        chart.level(0.0)
        coloured = [one.name for one in self.moved[:COLOURS]]
        for one in sorted(shown, key=lambda one: one.name in coloured):
            known = np.isfinite(one.apart_sd)
            kind = f"axis{coloured.index(one.name)}" if one.name in coloured else "other"
            chart.line(at[known], one.apart_sd[known], kind)
        self._name_lines(chart)
        return chart.svg(f"{self.sensor}: {self.in_words}")

    def _name_lines(self, chart: Chart) -> None:
        """Names at the ends of the lines in colour, apart from each other."""
        last = [float(one.apart_sd[np.isfinite(one.apart_sd)][-1])
                for one in self.moved[:COLOURS]]
        below = np.inf
        for i in sorted(range(len(last)), key=lambda i: last[i]):
            below = min(chart.y(last[i]) + NAME_PX / 3, below - NAME_PX)
            chart.parts.append(f'<text class="title" x="{chart.right + 3:g}" y="{pixel(below)}">'
                               f'{escape(self.moved[i].name)}</text>')

    @property
    def as_json(self) -> Json:
        """The same data for programs."""
        return {
            "sessions": list(self.sessions), "days": numbers(self.days),
            "limit_sd": self.limit_sd,
            "moved": {one.name: numbers(one.apart_sd) for one in self.moved},
            "ageing": None if self.ageing is None else json_value(asdict(self.ageing)),
        }


def sensors_over_time(population: TriadPopulation, output: Path) -> Iterator[SensorOverTime]:
    """The sensors of a lot with several sessions whose results are in ``output``.

    Those whose sessions differ most come first, and at most ``MOST_SENSORS``.
    """
    if not population.repeats:
        return
    birge = np.nan_to_num(np.fmax.reduce([repeat.of_sensor for repeat in population.repeats]))
    for i in np.argsort(-birge, kind="stable")[: min(np.count_nonzero(birge), MOST_SENSORS)]:
        one = _over_time(population.sensors[i], population.triad, population.sessions_of(i), output)
        if one is not None:
            yield one


def _over_time(
    sensor: str, triad: str, names: Sequence[str], output: Path
) -> SensorOverTime | None:
    sessions: list[tuple[float, str, Stored]] = []
    for name in names:
        try:
            stored = load_results(folder_of(output, name))
        except UnreadableInput:
            continue
        sessions.append((recorded_at(stored), name, stored))
    if len(sessions) < 2:
        return None
    times = np.array([time_s for time_s, _, _ in sessions])
    if not np.ptp(times) > LEAST_DAYS * DAY_S:  # unknown, or the first runs of one evening
        times[:] = np.nan
    order = np.argsort(times, kind="stable")
    results = [sessions[k][2] for k in order]
    compared = [one for one in compare_calibrations(results) if one.triad == triad]
    if not compared:
        return None
    return SensorOverTime(
        sensor, tuple(sessions[k][1] for k in order), (times - times.min())[order] / DAY_S,
        compared[0], ageing_of(compared[0], times[order].tolist()))


def _farthest(parameter: ComparedParameter) -> float:
    """Its distance from the first session where that is largest, sds."""
    known = np.nan_to_num(parameter.apart_sd)
    return float(known[np.argmax(np.abs(known))])
