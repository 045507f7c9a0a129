"""What a lot shows, on the page and in population.json."""

import html
import json
import re
from dataclasses import dataclass, replace
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pytest

from calib.diagnosis.population.pool import Pool
from pipeline.fleet.finish import FleetSummary, finish_fleet, fleet_lines
from pipeline.fleet.population import copies_text, pool_headline, populations_of
from pipeline.fleet.sessions import SessionRecord, evidence_path
from pipeline.fleet.table import Row
from tests.lot_records import lot_records
from tests.world.designs import soak_design
from tests.world.lot import LotPlan, draw_lot

SENSORS = 40
MISFIT, UNLIKE = "u07", "u11"
HOSTILE = "=1+1 <script>alert(1)</script>"


class Addresses(HTMLParser):
    """Every address that a page refers to, and every element that it has."""

    def __init__(self) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.elements: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.add(tag)
        self.addresses += [value or "" for name, value in attrs if name in ("href", "src")]


@dataclass(frozen=True, eq=False)
class Page:
    """A finished lot."""

    output: Path
    summary: FleetSummary
    text: str


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Page:
    """Two evenings of 40 accelerometers with a hidden cubic effect; two unlike the others."""
    output = tmp_path_factory.mktemp("lot")
    plan = LotPlan(SENSORS, evenings=2, hidden="cubic", common_sd=1.0)
    drawn = draw_lot(soak_design(), plan, 3)
    drawn.counts[2 * 11 : 2 * 12] *= 1.5  # both evenings of one sensor: another gain
    drawn.counts[2 * 7] += 400  # one evening of another: its bias moved
    names = [f"u{unit:02d}/e{i % 2}" for i, unit in enumerate(drawn.unit)]
    records = lot_records(drawn, names, output)
    copy = {**records[0].rows[0], "session": "u98/e0", "sensor": "u98"}
    records.append(SessionRecord("u98/e0", "u98", "", 0, "", (copy,)))
    failed: Row = {"session": "u99/e0", "sensor": "u99", "triad": "", "exit_code": 3,
                   "reason": HOSTILE}
    records.append(SessionRecord("u99/e0", "u99", "", 3, HOSTILE, (failed,)))
    summary = finish_fleet(records, output, reports=True)
    return Page(output, summary, (output / "fleet.html").read_text(encoding="utf-8"))


def test_what_no_sensor_shows_alone_stands_at_the_top_of_the_page(page: Page) -> None:
    results = json.loads((page.output / "population.json").read_text(encoding="utf-8"))
    missing = results["accelerometer"]["missing"][0]
    assert "cubic" in (missing["name"], *missing["alternatives"])
    assert missing["p_common_size"] < 1e-4 < missing["p_same_size"]
    top = page.text[: page.text.index("<main>")]
    assert "Missing in the lot" in top
    assert missing["name"] in top


def test_sensors_unlike_the_lot_are_listed_with_their_reports(page: Page) -> None:
    table = html.unescape(page.text).split("Sensors unlike the lot</h3>")[1].split("<h3>")[0]
    assert f'href="sessions/{UNLIKE}/e0/report.html"' in table
    off = re.search(r"scale x ([\d.]+) ± [\d.]+ % \(", table)
    assert off is not None
    assert float(off[1]) == pytest.approx(50.0, abs=5.0)


def test_the_parameters_of_a_lot_differ_in_units_of_errors(page: Page) -> None:
    """The bias scatters by some mm/s², and nobody reads counts."""
    shown = page.text.split("Parameters over the lot</h3>")[1].split("<h3>")[0]
    sd = re.findall(r"a sensor's own sd ([\d.e-]+) mm/s²", html.unescape(shown))
    rows = page.summary.table.query("triad == 'accelerometer'")
    bias_sd = np.nanmedian(rows["bias_counts_x_sd"].astype(float)) / np.sqrt(2)  # two evenings
    gain = np.nanmedian(rows["scale_counts_per_unit_x"].astype(float))
    assert len(sd) == 3
    assert float(sd[0]) == pytest.approx(1000 * bias_sd / gain, rel=0.1)


def test_the_sensor_that_moved_between_its_evenings_is_counted(page: Page) -> None:
    repeats = {one.name: one for one in page.summary.populations[0].repeats}
    moved = repeats["bias_counts_x"].moved
    assert [page.summary.populations[0].sensors[i] for i in np.flatnonzero(moved)] == [MISFIT]
    assert repeats["scale_counts_per_unit_y"].birge == pytest.approx(1.0, abs=0.35)


def test_the_page_is_one_file_that_needs_no_network(page: Page) -> None:
    parser = Addresses()
    parser.feed(page.text)
    outside = [each for each in parser.addresses if not each.startswith(("#", "sessions/"))]
    assert outside == []
    assert not parser.elements & {"img", "link", "iframe"}
    assert page.text.count("<script") == 1  # that sorts
    assert "@import" not in page.text
    assert "url(" not in page.text
    assert len(page.text) < 2e6


def test_nothing_that_a_session_says_becomes_a_part_of_the_page(page: Page) -> None:
    assert HOSTILE not in page.text
    assert "&lt;script&gt;" in page.text
    assert "'=1+1 <script>" in (page.output / "fleet.csv").read_text(encoding="utf-8")


def test_addresses_stand_for_the_sessions_they_name(page: Page) -> None:
    parser = Addresses()
    parser.feed(page.text)
    for address in parser.addresses:
        if address.startswith("sessions/"):
            name = unquote(address).removeprefix("sessions/").removesuffix("/report.html")
            assert evidence_path(page.output, name, "accelerometer").exists()


def test_the_terminal_says_the_same(page: Page) -> None:
    lines = list(fleet_lines(page.summary))
    assert lines[0] == "82 sessions of 42 sensors: 81 calibrated"
    assert any(line.startswith("accelerometer: Pooled over 80 sessions of 40 sensors")
               for line in lines)
    assert lines[-1] == str(page.output / "fleet.html")


def test_a_session_that_is_a_copy_of_another_counts_once(page: Page) -> None:
    assert page.summary.populations[0].copies == {"u98/e0": "u00/e0"}
    assert len(page.summary.populations[0].rows) == 2 * SENSORS
    assert "&#39;u98/e0&#39; is &#39;u00/e0&#39;" in page.text


def test_different_data_sheets_are_not_pooled(page: Page) -> None:
    table = page.summary.table.copy()
    table["sheet"] = ["50 16 si 1"] * 10 + ["4 16 si 1"] * (len(table) - 10)

    def pooled(*_: object) -> Pool:
        raise AssertionError

    population, = populations_of(table, pooled)
    assert pool_headline(population).startswith("The sessions have 2 different data sheets")
    several = replace(population, copies={f"c{i}": "a" for i in range(7)})
    assert "'c1' is 'a'" in copies_text(several)
    assert copies_text(several).endswith("'c4' is 'a' and 2 more.")


def test_without_a_single_result_there_is_a_page_of_the_failures(tmp_path: Path) -> None:
    failed: Row = {"session": "a", "sensor": "a", "triad": "", "exit_code": 2, "reason": "wrong"}
    summary = finish_fleet([SessionRecord("a", "a", "", 2, "wrong", (failed,))], tmp_path, True)
    assert summary.populations == ()
    assert "wrong" in (tmp_path / "fleet.html").read_text(encoding="utf-8")
