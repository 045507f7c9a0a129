"""The report in the browser: a program of the system opens it, or the command says that none does.
"""

import os
import sys
from pathlib import Path

import pytest

from tests.sessions import pipeline, quick_session

LINUX = pytest.mark.skipif(sys.platform != "linux", reason="files are opened by xdg-open on Linux")


@LINUX
def test_the_report_of_the_run_is_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    opener = tmp_path / "bin" / "xdg-open"
    opener.parent.mkdir()
    opener.write_text('#!/bin/sh\necho "opened $1"\n')
    opener.chmod(0o755)
    monkeypatch.setenv("PATH", f"{opener.parent}{os.pathsep}{os.environ['PATH']}")
    config, _ = quick_session(tmp_path / "session")
    assert pipeline("open", config, "--output", tmp_path / "out") == 0
    report = tmp_path / "out" / "report.html"
    assert report.exists()
    assert f"opened {report}" in capfd.readouterr().out


@LINUX
def test_without_a_program_that_opens_it_the_path_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    config, _ = quick_session(tmp_path / "session")
    assert pipeline("open", config) == 0
    told = capsys.readouterr().err
    assert f"{config.with_suffix('.run') / 'report.html'}. Open this file in a browser" in told
