"""The parameters as the terminal and the report show them: one source for both."""

import re
import shutil
from pathlib import Path

import pytest

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
