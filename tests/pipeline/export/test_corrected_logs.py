"""Logs that `pipeline apply` cannot read, and its own, which are no poses of a session."""

import shutil
from pathlib import Path

import pytest

from tests.pipeline.conftest import RunSession
from tests.sessions import pipeline

pytestmark = pytest.mark.usefixtures("bare_page")


def test_a_corrected_log_does_not_become_a_pose(
    finished: RunSession, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Not by its name, which is refused with one that would do, nor where it came in otherwise."""
    session = tmp_path / "session"
    shutil.copytree(finished.config.parent, session)
    folder, config = session / finished.folder.name, session / finished.config.name
    log, wrong = session / "accelerometer/pose_03.csv", session / "accelerometer/pose_03.cal.csv"
    assert pipeline("apply", folder, log, "--output", wrong) == 2
    said = capsys.readouterr().err
    assert "'accelerometer/pose_*.csv' in config.yaml would take it for a pose" in said
    able = Path(said.split("--output ")[1].strip())
    assert pipeline("apply", folder, log, "--output", able) == 0
    able.rename(wrong)
    refusal = "pose_03.cal.csv: `pipeline apply` has corrected this log"
    for command in (("run", config), ("import", wrong), ("import", wrong, "--into", config)):
        assert pipeline(*command) in (2, 3)
        assert refusal in capsys.readouterr().err
    logs = sorted(log.parent.glob("pose_*.csv"))
    assert pipeline("import", *logs, "--output", session / "new.yaml") == 0
    assert "pose_03.cal.csv: left out, because `pipeline apply`" in capsys.readouterr().err


def test_an_absent_log_has_no_columns_to_name(
    finished: RunSession, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("apply", finished.folder, "none.csv") == 3
    assert "--columns" not in capsys.readouterr().err
