"""``--to certificate``: one page that states what the results hold, whatever the names are."""

import json
import math
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calib.poses.data_sheet import TriadSpec
from pipeline.export.certificate import certificate_content, residual_chart, to_certificate
from pipeline.results.read import Stored, load_results
from pipeline.results.schema.triad import PoseResult
from pipeline.text.formatting import with_sd
from tests.pipeline.conftest import RunSession
from tests.pipeline.export.stored_results import with_effects
from tests.pipeline.report.browser import CHROMIUM, QUIET, needs_browser
from tests.pipeline.report.html_page import Page
from tests.sessions import pipeline, results_in


@pytest.fixture
def stored(finished: RunSession) -> Stored:
    return load_results(finished.folder)


def page_of(stored: Stored) -> str:
    (page,) = to_certificate(stored).files.values()
    assert isinstance(page, str)
    return page


def test_it_is_a_page_of_its_own_and_the_same_bytes_for_the_same_results(stored: Stored) -> None:
    source = page_of(stored)
    page = Page(source)
    assert not page.open
    assert not [each for each in ("http", "src=", "<script") if each in source]
    assert "Reference and traceability" in page.text
    assert source == page_of(stored)


def test_it_states_the_parameters_of_the_results(stored: Stored, finished: RunSession) -> None:
    found = results_in(finished.folder)
    for part in certificate_content(stored)["triads"]:
        section = found[part["name"]]
        keys = ("bias_counts", "scale_counts_per_unit")
        for (_, values), key in zip(part["rows"], keys, strict=False):
            for shown, value, sd in zip(
                values, section["parameters"][key], section["sd"][key], strict=True
            ):
                assert " ".join(shown).replace("−", "-") == with_sd(value, sd)
        assert part["figures"]["Poses"] == str(section["n_poses"])
        assert part["explanation"].replace("\u00a0", " ") == section["diagnosis"]["says"]
        assert part["standing"] == "good"
        for name in section["diagnosis"]["blind"]:
            assert name in part["not_determined"]


def test_what_is_incomplete_is_not_said_to_hold(
    stored: Stored, finished: RunSession, tmp_path: Path
) -> None:
    assert "The calibration holds for the stated ranges" in page_of(stored)
    contents = results_in(finished.folder)
    contents["gyroscope"]["diagnosis"]["standing"] = "act"
    (tmp_path / "results.json").write_text(json.dumps(contents), encoding="utf-8")
    page = page_of(load_results(tmp_path))
    assert "The calibration of the gyroscope is incomplete" in page
    assert "The calibration holds" not in page


def test_counts_without_a_range_are_counts(stored: Stored) -> None:
    counts, rate = (TriadSpec(math.inf, 0, "si", size) for size in (1 / 65.5, math.pi / 180))
    first, *_ = stored.triads
    for spec, unit in ((counts, "counts"), (rate, "°/s")):
        triad = replace(first, name="gyroscope", correction=replace(first.correction, spec=spec))
        part, = certificate_content(replace(stored, triads=(triad,)))["triads"]
        assert part["range"] == f"logged in {unit}"


def test_it_identifies_the_session_and_its_references(
    stored: Stored, finished: RunSession
) -> None:
    content = certificate_content(stored)
    facts = content["facts"]
    assert facts["Configuration"] == f"SHA-256 {stored.contents.config_sha256[:16]}"
    last = json.loads((finished.folder / "history.jsonl").read_text("utf-8").splitlines()[-1])
    assert facts["Date of calibration"] == last["when"][:16].replace("T", " ")
    names = [name for name, _, _ in content["references"]]
    assert names == ["Gravity", *(f"Plate, {name}" for name in stored.contents.rate)]


def test_effects_stand_in_units_of_data_sheets(finished: RunSession, tmp_path: Path) -> None:
    sensitivity = list(np.arange(-4.0, 5.0) * 1e-5)
    stored = with_effects(finished, tmp_path, "gyroscope", {"g_sensitivity": sensitivity})
    contents = json.loads(stored.path.read_text("utf-8"))
    contents["gyroscope"]["effects"]["g_sensitivity"] |= {
        "unit": "(rad/s)/(m/s²)", "sd": [1e-6] * 9}
    stored.path.write_text(json.dumps(contents), encoding="utf-8")
    rows = certificate_content(load_results(tmp_path))["triads"][1]["rows"][3:]
    assert [name for name, _ in rows] == [
        f"g_sensitivity {axis} [°/s per g]" for axis in "xyz"]
    shown = [float(value.replace("−", "-")) for _, values in rows for value, _ in values]
    assert shown == pytest.approx(np.degrees(sensitivity) * 9.80665, abs=6e-5)


def test_without_a_history_the_date_is_not_invented(finished: RunSession, tmp_path: Path) -> None:
    shutil.copy(finished.folder / "results.json", tmp_path)
    facts = certificate_content(load_results(tmp_path))["facts"]
    assert facts["Date of calibration"] == "not recorded"


def test_the_chart_shows_every_residual_over_its_noise() -> None:
    chart = residual_chart([
        PoseResult.model_construct(run=run, residual=residual, sd=sd, reference=reference)
        for run, residual, sd, reference in (
            ("slow", 1.0, 0.5, 1.7), ("slow", -2.0, 1.0, 1.7), ("stopped", 0.5, 0.25, 0.0))
    ], "gyroscope")
    marks = [(float(x), float(y)) for x, y in re.findall(
        r'class="mark" transform="translate\(([\d.]+) ([\d.]+)\)', chart)]
    (zero,) = (float(y) for y in re.findall(r'y="([\d.]+)"[^>]*>0</text>', chart))
    bars = [(float(start), float(end)) for start, end in re.findall(
        r"M[\d.]+ ([\d.]+)V([\d.]+)", re.search(r'class="band" d="([^"]+)"', chart)[1])]
    (_, high), (_, low), (at, _) = marks
    assert high < zero < low
    assert zero - high == pytest.approx((low - zero) / 2, abs=0.1)
    assert sum(bars[0]) / 2 == pytest.approx(zero, abs=0.1)  # noise on both sides of 0
    assert bars[2][0] == pytest.approx(zero, abs=0.1)  # a length is above it
    runs = re.findall(r'x="([\d.]+)"[^>]*text-anchor="middle">(\w+)<', chart)
    assert [name for _, name in runs] == ["slow", "stopped"]
    assert float(runs[1][0]) == pytest.approx(at, abs=0.1)


@pytest.mark.parametrize("name", [
    "<script>alert(1)</script>", "two\nlines\tand\x07 a bell", "{{7*7}} &amp; \"'", "転台 2"])
def test_no_name_out_of_a_file_spoils_the_page(name: str, stored: Stored) -> None:
    rates = {f"{name} {i}": rate for i, rate in enumerate(stored.contents.rate.values())}
    contents = stored.contents.model_copy(update={"title": name, "sensor": name, "rate": rates})
    page = Page(page_of(replace(stored, contents=contents)))
    shown = " ".join("".join(c if c.isprintable() else " " for c in name).split())
    assert not page.open
    assert "script" not in {tag for tag, _ in page.elements}
    assert page.text.count(shown) >= 2 + len(rates)


@needs_browser
def test_a_browser_prints_it_on_one_page(finished: RunSession, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert pipeline("export", finished.folder, "--to", "certificate", "--output", out) == 0
    subprocess.run(
        [str(CHROMIUM), *QUIET, f"--user-data-dir={tmp_path}",
         f"--print-to-pdf={out / 'page.pdf'}", (out / "certificate.html").as_uri()],
        check=True, capture_output=True, timeout=120)
    printed = (out / "page.pdf").read_bytes()
    assert printed.count(b"/Type /Page") - printed.count(b"/Type /Pages") == 1
