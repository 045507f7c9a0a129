"""``--to certificate``: one page that states what the results hold, whatever the names are."""

import json
import re
import shutil
import subprocess
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.text import Text

from pipeline.export.certificate_content import certificate_content
from pipeline.export.certificate_page import certificate_pdf, draw_certificate
from pipeline.export.sheet import ABSENT, A4Sheet, own_settings
from pipeline.results.read import Stored, load_results
from pipeline.text.formatting import with_sd
from tests.pipeline.conftest import RunSession
from tests.pipeline.export.stored_results import with_effects
from tests.sessions import pipeline, results_in

OVERLAP = 0.6  #: points that two boxes of letters may share: descenders reach below the base


@pytest.fixture
def stored(finished: RunSession) -> Stored:
    return load_results(finished.folder)


def with_contents(stored: Stored, **changes: object) -> Stored:
    return replace(stored, contents={**stored.contents, **changes})


def sheet_of(stored: Stored) -> tuple[A4Sheet, list[str]]:
    with own_settings():
        sheet = A4Sheet()
        lost = draw_certificate(sheet, certificate_content(stored))
        sheet.figure.canvas.draw()
    return sheet, lost


def texts_of(sheet: A4Sheet) -> list[Text]:
    """All but the numbers beside the charts."""
    return [text for text in sheet.figure.texts if text.get_text().strip()]


def fits(sheet: A4Sheet) -> None:
    """Every text is on the page, and none lies on another."""
    width, height = sheet.figure.bbox.width, sheet.figure.bbox.height
    boxes = [(text.get_text(), text.get_window_extent()) for text in texts_of(sheet)]
    for words, box in boxes:
        assert box.x0 >= 0, words
        assert box.y0 >= 0, words
        assert box.x1 <= width, words
        assert box.y1 <= height, words
    scale = sheet.figure.dpi / 72
    for (one, a), (other, b) in combinations(boxes, 2):
        across = min(a.x1, b.x1) - max(a.x0, b.x0)
        upward = min(a.y1, b.y1) - max(a.y0, b.y0)
        both = across > OVERLAP * scale and upward > 0.35 * min(a.height, b.height)
        assert not both, f"{one!r} lies on {other!r}"


def test_it_is_one_page_and_the_same_bytes_for_the_same_results(stored: Stored) -> None:
    (page,) = certificate_pdf(stored).files.values()
    assert isinstance(page, bytes)
    assert page.startswith(b"%PDF")
    assert len(re.findall(rb"/Type /Page\b", page)) == 1
    assert b"CreationDate" not in page
    assert page == certificate_pdf(stored).files["certificate.pdf"]
    assert certificate_pdf(stored).loses == ()


def test_it_states_the_parameters_of_the_results(stored: Stored, finished: RunSession) -> None:
    found = results_in(finished.folder)
    for part in certificate_content(stored).triads:
        section = found[part.name.lower()]
        for row, key in zip(part.rows, ("bias_counts", "scale_counts_per_unit"), strict=False):
            for shown, value, sd in zip(
                row.values, section["parameters"][key], section["sd"][key], strict=True
            ):
                assert f"{shown.value} {shown.sd}".replace("−", "-") == with_sd(value, sd)
        figures = dict(part.figures)
        assert figures["Poses"] == str(section["n_poses"])
        assert part.explanation.replace("\u00a0", " ") == section["diagnosis"]["says"]
        assert part.standing == "good"
        for name in section["diagnosis"]["blind"]:
            assert name in part.not_determined


def test_it_identifies_the_session_and_its_references(
    stored: Stored, finished: RunSession
) -> None:
    content = certificate_content(stored)
    facts = dict(content.facts)
    assert facts["Configuration"] == f"SHA-256 {stored.contents['config_sha256'][:16]}"
    last = json.loads((finished.folder / "history.jsonl").read_text("utf-8").splitlines()[-1])
    assert facts["Date of calibration"] == last["when"][:16].replace("T", " ")
    names = [name for name, _, _ in content.references]
    assert names == ["Gravity", *(f"Plate, {name}" for name in stored.contents["rate"])]


def test_effects_stand_in_units_of_data_sheets(finished: RunSession, tmp_path: Path) -> None:
    sensitivity = list(np.arange(-4.0, 5.0) * 1e-5)
    stored = with_effects(finished, tmp_path, "gyroscope", {"g_sensitivity": sensitivity})
    contents = json.loads(stored.path.read_text("utf-8"))
    contents["gyroscope"]["effects"]["g_sensitivity"] |= {
        "unit": "(rad/s)/(m/s²)", "sd": [1e-6] * 9}
    stored.path.write_text(json.dumps(contents), encoding="utf-8")
    rows = certificate_content(load_results(tmp_path)).triads[1].rows[3:]
    assert [row.name for row in rows] == [
        f"g_sensitivity {axis} [°/s per g]" for axis in "xyz"]
    shown = [float(each.value.replace("−", "-")) for row in rows for each in row.values]
    assert shown == pytest.approx(np.degrees(sensitivity) * 9.80665, abs=6e-5)


def test_without_a_history_the_date_is_not_invented(finished: RunSession, tmp_path: Path) -> None:
    shutil.copy(finished.folder / "results.json", tmp_path)
    facts = dict(certificate_content(load_results(tmp_path)).facts)
    assert facts["Date of calibration"] == "not recorded"


def test_nothing_leaves_the_page_or_lies_on_something_else(stored: Stored) -> None:
    sheet, lost = sheet_of(stored)
    assert lost == []
    fits(sheet)


@pytest.mark.parametrize("name", [
    "a $very\\frac{1}{0}$ odd^name_", "two\nlines\tand\x07 a bell", "W" * 300, "(\\) %s {0} <b>",
])
def test_no_name_out_of_a_file_spoils_the_page(name: str, stored: Stored) -> None:
    rates = {f"{name} {i}": rate for i, rate in enumerate(
        [*stored.contents["rate"].values()] * 2)}
    sheet, _ = sheet_of(with_contents(stored, title=name, sensor=name, rate=rates))
    fits(sheet)
    shown = " ".join("".join(c if c.isprintable() else " " for c in name).split())
    drawn = [text.get_text() for text in texts_of(sheet)]
    assert shown in drawn or f"{shown[:30]}" in {text[:30] for text in drawn if text[-1] == "…"}
    assert certificate_pdf(with_contents(stored, title=name)).files


def test_letters_that_the_font_lacks_are_boxes_and_said_so(stored: Stored) -> None:
    export = certificate_pdf(with_contents(stored, title="転台 2"))
    assert export.loses == ("The font of the page lacks 2 letters of the names; a box stands for "
                            "each.",)
    sheet, _ = sheet_of(with_contents(stored, title="転台 2"))
    assert f"{ABSENT}{ABSENT} 2" in [text.get_text() for text in texts_of(sheet)]


def test_what_has_no_room_is_counted_and_said(finished: RunSession, tmp_path: Path) -> None:
    many = {name: [1e-4] * 9 for name in ("g_sensitivity", "cross_quadratic")}
    many |= {name: [1e-4] * 3 for name in (
        "quadratic", "cubic", "asymmetry", "temperature_bias", "temperature_scale", "bias_drift")}
    stored = with_effects(finished, tmp_path, "gyroscope", many)
    rates = {f"setting {i}": rate for i, rate in enumerate(
        [*stored.contents["rate"].values()] * 12)}
    sheet, lost = sheet_of(with_contents(stored, rate=rates))
    fits(sheet)
    assert len(lost) == 2
    assert all("results.json" in each for each in lost)


@pytest.mark.skipif(shutil.which("pdftotext") is None, reason="no pdftotext here")
def test_the_command_writes_a_page_whose_text_can_be_searched(
    finished: RunSession, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    assert pipeline("export", finished.folder, "--to", "certificate", "--output", out) == 0
    text = subprocess.run(["pdftotext", "-layout", str(out / "certificate.pdf"), "-"],
                          capture_output=True, text=True, check=True).stdout
    assert "Reference and traceability" in text
    assert "Page 1 of 1" in text
    found = results_in(finished.folder)["accelerometer"]["parameters"]["bias_counts"]
    assert f"{found[0]:.0f}"[:4] in text


def test_a_user_s_matplotlib_settings_change_nothing(
    stored: Stored, monkeypatch: pytest.MonkeyPatch
) -> None:
    import matplotlib

    plain = certificate_pdf(stored).files
    monkeypatch.setitem(matplotlib.rcParams, "font.size", 30.0)
    monkeypatch.setitem(matplotlib.rcParams, "axes.facecolor", "black")
    assert certificate_pdf(stored).files == plain
