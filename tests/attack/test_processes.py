"""Signals, terminals that cannot show everything, disks that fill up, pipes and clocks."""

import errno
import io
import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pipeline.logs import memory
from pipeline.record.store import RawFile
from tests.attack.case import hashes
from tests.paths import DATA, ROOT
from tests.sessions import pipeline

CLIP = DATA / "example/video/17rpm.mp4"
HIDE, SHOW = b"\x1b[?25l", b"\x1b[?25h"


@pytest.mark.parametrize("encoding", ["cp1252", "ascii", "cp437", "latin-1", "utf-8"])
def test_every_encoding_of_the_terminal_gets_the_report(
    copied: Path, monkeypatch: pytest.MonkeyPatch, encoding: str
) -> None:
    behind = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(behind, encoding=encoding))
    assert pipeline("check", copied) == 0
    assert b"no error in" in behind.getvalue()


def test_a_terminal_without_the_signs_of_the_field_gets_the_report(alone: Path) -> None:
    """In a process of its own, whose streams have that encoding from the start."""
    done = subprocess.run(
        [sys.executable, "-m", "pipeline", "run", alone], cwd=ROOT, capture_output=True,
        check=False, env={**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONPATH": str(ROOT)})
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"Nothing is missing" in done.stdout


def test_sigterm_gives_the_cursor_back() -> None:
    master, slave = pty.openpty()
    with subprocess.Popen([sys.executable, "-m", "pipeline", "rate", CLIP], cwd=ROOT,
                          stdout=subprocess.DEVNULL, stderr=slave,
                          env={**os.environ, "TERM": "xterm", "PYTHONPATH": str(ROOT)}) as run:
        os.close(slave)
        seen, begun = b"", time.monotonic()
        while HIDE not in seen and time.monotonic() - begun < 240:
            seen += os.read(master, 4096)
        run.send_signal(signal.SIGTERM)
        try:
            while chunk := os.read(master, 4096):
                seen += chunk
        except OSError:  # the other end is closed
            pass
        assert run.wait(240) == 130
    os.close(master)
    assert seen.rfind(SHOW) > seen.rfind(HIDE) >= 0


def test_a_full_disk_ends_a_recording_with_its_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object, **__: object) -> None:
        raw = RawFile(tmp_path / "001.bin")
        raw.close()
        with open("/dev/full", "wb", buffering=0) as disk:
            monkeypatch.setattr(raw, "_bytes", disk)
            raw.keep(b"x", 0.0)

    if not os.path.exists("/dev/full"):
        pytest.skip("this system has no /dev/full")
    monkeypatch.setattr("pipeline.record.start.open_session", full)
    assert pipeline("record", DATA / "example/config.yaml") == 2
    assert "No space left on device" in capsys.readouterr().err


def test_a_log_larger_than_the_memory_is_refused_before_it_is_read(
    copied: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(memory, "LEAST_FREE", 1 << 16)
    monkeypatch.setattr(memory, "_linux", lambda: 1 << 16)
    log = copied.parent / "accelerometer/pose_07.csv"
    assert pipeline("apply", copied.with_suffix(".run"), log) == 3
    assert "holds more than" in capsys.readouterr().err


@pytest.mark.parametrize("number", [errno.EACCES, errno.EROFS, errno.ENOSPC, errno.EDQUOT,
                                    errno.EIO, errno.ENAMETOOLONG])
def test_a_folder_that_cannot_be_written_is_said_and_nothing_changes(
    alone: Path, monkeypatch: pytest.MonkeyPatch, number: int,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def refused(*_: object, **__: object) -> None:
        raise OSError(number, os.strerror(number))

    before = hashes(alone.parent)
    monkeypatch.setattr("pipeline.files.tempfile.mkstemp", refused)
    assert pipeline("run", alone) == 2
    printed = capsys.readouterr().err
    assert os.strerror(number) in printed
    assert "write to another one" in printed
    assert hashes(alone.parent) == before


@pytest.mark.parametrize("name", ["config.run/.written.json", "config.run/.unfinished.json",
                                  "config.run/.nothing.json"])
@pytest.mark.parametrize("content", ["[" * 100_000, "\xff", "{}", '{"a": 5}', "null"])
def test_notes_of_the_program_that_somebody_spoiled_are_made_anew(
    copied: Path, name: str, content: str
) -> None:
    (copied.parent / name).write_text(content, encoding="latin-1")
    run = copied.with_suffix(".run")
    assert pipeline("export", run, "--to", "json", "--output", copied.parent / "out") == 0


@pytest.mark.skipif(sys.platform != "linux", reason="names of files are text here")
def test_names_of_files_that_are_no_text_are_names_of_files(alone: Path) -> None:
    """Also of the configuration, whose name its results, their lock and their journal have."""
    os.rename(alone.parent / "accelerometer/pose_07.csv",
              os.fsencode(alone.parent / "accelerometer") + b"/pose_\xff07.csv")
    named = Path(os.fsdecode(os.fsencode(alone.parent) + b"/c\xff.yaml"))
    alone.rename(named)
    assert pipeline("run", named) == 0
    written = (named.parent / named.with_suffix(".run").name / "results.json").read_bytes()
    assert b"pose_\\\\xff07.csv" in written
    assert pipeline("export", named.with_suffix(".run"), "--to", "json") == 0
