"""data/docs/promises.md: every test that it names exists, and every promise names one."""

import re
from pathlib import Path

import pytest

from tests.attack.case import edit, result
from tests.paths import DATA, ROOT
from tests.sessions import pipeline

PROMISES = (DATA / "docs/promises.md").read_text(encoding="utf-8")
UNTESTED = "## What it cannot detect"


def test_every_promise_names_tests_that_exist() -> None:
    there = {name for path in (ROOT / "tests").rglob("test_*.py")
             for name in re.findall(r"^def (test_\w+)", path.read_text("utf-8"), re.MULTILINE)}
    named = set(re.findall(r"`(test_\w+)`", PROMISES))
    assert named - there == set()
    for promise in re.split(r"\n- ", PROMISES[: PROMISES.index(UNTESTED)])[1:]:
        assert "`test_" in promise, promise


def test_what_a_calibration_lacks_is_said_when_it_is_used(
    copied: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    result("gyroscope", "diagnosis", "verdict", value="effect")(copied)
    result("gyroscope", "diagnosis", "says", value="'cubic' is missing.")(copied)
    assert pipeline("export", copied.with_suffix(".run"), "--to", "json") == 0
    assert "the calibration is incomplete. 'cubic' is missing." in capsys.readouterr().err


def test_a_failed_run_leaves_the_results_of_the_run_before(copied: Path) -> None:
    before = (copied.with_suffix(".run") / "results.json").read_bytes()
    edit("gravity_m_s2: 9.80267", "gravity_m_s2: 12")(copied)
    assert pipeline("run", copied) == 2
    assert (copied.with_suffix(".run") / "results.json").read_bytes() == before
