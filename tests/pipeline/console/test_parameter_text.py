"""The parameters as the terminal and the report show them: one source for both."""

import re
import shutil
from pathlib import Path

import pytest

from pipeline.config.sensor import AccelerometerSheet, GyroscopeSheet, TriadSheet, triad_spec
from pipeline.results.json_values import unit_of
from pipeline.results.names import PARAMETERS
from pipeline.text.formatting import with_minus_signs
from tests.pipeline.conftest import RunSession
from tests.pipeline.report.html_page import Page
from tests.sessions import edit, pipeline

EFFECTS = """
effects:
  sway: {expression: x ** 3, per: common, unit: 1/(m/s²)²}
  sway_squared: {expression: x ** 2, per: common, unit: 1/(m/s²)}
"""


@pytest.fixture
def two_effects(finished: RunSession, tmp_path: Path) -> Path:
    """A session that may fit two effects, the name of one of which begins like the other's."""
    folder = tmp_path / "session"
    shutil.copytree(finished.config.parent, folder, ignore=shutil.ignore_patterns("*.run"))
    config = folder / finished.config.name
    text = config.read_text(encoding="utf-8")
    config.write_text(text + EFFECTS, encoding="utf-8")
    return config


def test_a_change_shows_the_size_of_its_effect_alone(
    two_effects: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("add", two_effects, "accelerometer.sway_squared", "--anyway") == 0
    assert len(re.findall(r"^ +sway_squared \[", capsys.readouterr().out, re.M)) == 1
    assert pipeline("add", two_effects, "accelerometer.sway", "--anyway") == 0
    shown = capsys.readouterr().out
    assert len(re.findall(r"^ +sway \[", shown, re.M)) == 1
    assert not re.search(r"^ +sway_squared \[", shown, re.M)


def test_the_report_has_the_values_of_the_terminal(
    two_effects: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    edit(two_effects, "model: [bias, scale, misalignment]", "model: [bias, scale, sway]")
    assert pipeline("run", two_effects) == 0
    shown = capsys.readouterr().out
    page = Page((two_effects.with_suffix(".run") / "report.html").read_text(encoding="utf-8"))
    values = re.findall(r"^ +(?:misalignment|sway) \[.*?\] +(.*\S)$", shown, re.M)
    assert values
    printed = {with_minus_signs(each) for value in values for each in re.split(r" {2,}", value)}
    assert {each for each in printed if each not in page.text} == set()
    assert "0 (not fitted)" in page.text


@pytest.mark.parametrize(("sheet", "triad", "bias", "scale"), [
    (AccelerometerSheet(unit="m_s2"), "accelerometer", "m/s²", "no unit"),
    (AccelerometerSheet(unit="mg"), "accelerometer", "mg", "mg/(m/s²)"),
    (GyroscopeSheet(unit="rad_s"), "gyroscope", "rad/s", "no unit"),
    (GyroscopeSheet(unit="deg_s"), "gyroscope", "°/s", "(°/s)/(rad/s)"),
    (GyroscopeSheet(counts_per_deg_s=131.0), "gyroscope", "counts", "counts/(rad/s)"),
    (GyroscopeSheet(full_scale_deg_s=250.0, bits=16, encoding="twos-complement"), "gyroscope",
     "counts", "counts/(rad/s)"),
])
def test_parameters_of_a_log_in_physical_units_have_its_unit(
    sheet: TriadSheet, triad: str, bias: str, scale: str
) -> None:
    spec = triad_spec(sheet)
    assert [unit_of(key, triad, spec) for key in PARAMETERS] == ["rad", bias, scale]
