"""Lines and tables in the width of the terminal: nothing is lost, and programs read whole lines."""

import io
import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.commands.interaction.output import say
from pipeline.console.terminal import ShownStream, cut_between_words
from pipeline.text.tables import aligned, terminal_columns
from tests.paths import ROOT

ROWS = [["candidate", "log evidence", "chi² drop", "leave-one-out", "like"],
        ["vibration_rectification", "-1.1", "0.0", "3.95", ""],
        ["asymmetry", "-1.8", "3.0", "2.9", "quadratic, cubic"]]


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("width", [30, 40, 50, 60, 70])
def test_a_wide_table_stands_in_blocks_behind_its_first_column(width: int) -> None:
    lines = aligned(ROWS, width=width)
    assert max(map(len, lines)) <= max(width, 2 + 23 + 2 + 16)
    assert {word for row in ROWS for cell in row for word in cell.split()} == {
        word for line in lines for word in line.split()}
    for line in lines:
        assert line.split()[0] in {"candidate", "vibration_rectification", "asymmetry"}


def test_a_table_that_fits_is_as_it_is_in_a_pipe() -> None:
    assert aligned(ROWS, width=200) == aligned(ROWS)


def test_a_long_last_column_continues_under_itself() -> None:
    lines = aligned([["name", "what it is in so many words that they need two lines"]], width=40)
    assert lines == ["  name  what it is in so many words that",
                     "        they need two lines"]


@pytest.mark.parametrize("line", [
    "gyroscope       90 poses in 5 runs, residual 0.0615 °/s, leave-one-out 0.0642 °/s",
    "  cannot determine: frame_rotation, lever_arm, reference_offset, reference_scale",
    "one_name_that_is_longer_than_the_terminal_is_wide_and_that_nobody_can_cut_in_two",
])
def test_a_line_is_cut_between_words(line: str) -> None:
    cut = cut_between_words(line, 40)
    assert cut.split() == line.split()
    assert all(len(each) <= 40 or " " not in each.strip() for each in cut.splitlines())


def test_what_is_copied_stays_whole(tmp_path: Path) -> None:
    report = tmp_path / ("a folder with a long name " * 3) / "report.html"
    report.parent.mkdir()
    report.touch()
    for line in (str(report), f"next: pipeline add {report} gyroscope.g_sensitivity"):
        assert cut_between_words(line, 40) == line


def test_columns_counts_on_a_terminal_and_not_in_a_pipe(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "50")
    assert terminal_columns(Terminal()) == 50
    assert terminal_columns(io.StringIO()) is None
    text = "a sentence of words " * 9
    for raw, lines in ((Terminal(), 4), (io.StringIO(), 1)):
        ShownStream(raw).write(text)
        assert len(raw.getvalue().splitlines()) == lines


def test_bytes_for_programs_are_never_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    raw = Terminal()
    ShownStream(raw).write_bytes(b'{"says": "' + b"many words " * 9 + b'"}')
    assert "\n" not in raw.getvalue()


def test_a_command_in_a_terminal_of_60_columns() -> None:
    """The list of effects is the widest that needs no session."""
    screen, terminal = pty.openpty()
    done = subprocess.Popen(
        [sys.executable, "-m", "pipeline", "effects"], cwd=ROOT, stdout=terminal, stderr=terminal,
        env={**os.environ, "COLUMNS": "60"})
    os.close(terminal)
    shown = b""
    while True:
        try:
            shown += os.read(screen, 65536)
        except OSError:  # the terminal is closed at its other end
            break
    assert done.wait() == 0
    assert max(map(len, shown.decode().splitlines())) <= 60


@pytest.mark.parametrize("face", [0, 1, 2, 7, 8, 31, 32, 33, 36, 44])
def test_a_colour_that_stands_in_a_text_is_shown_and_not_sent(
    face: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    raw = Terminal()
    monkeypatch.setattr("sys.stderr", ShownStream(raw))
    say(f"warning: column 'a\x1b[{face}mb'", err=True, fg="yellow")
    print(f"plain \x1b[{face}m", file=sys.stderr)
    own, _, rest = raw.getvalue().partition("warning: ")
    assert own == "\x1b[33m"
    assert rest.replace("\x1b[0m", "", 1).count("\x1b") == 0
    assert rest.count(f"\\x1b[{face}m") == 2


def test_no_command_sends_a_colour_out_of_a_file(tmp_path: Path) -> None:
    config = tmp_path / "\x1b[32mgood\x1b[0m.yaml"
    config.write_text('"\\e[31mtitel\\e[0m": 1\n', encoding="utf-8")
    screen, terminal = pty.openpty()
    done = subprocess.Popen([sys.executable, "-m", "pipeline", "check", str(config)], cwd=ROOT,
                            stdout=terminal, stderr=terminal)
    os.close(terminal)
    shown = b""
    while True:
        try:
            shown += os.read(screen, 65536)
        except OSError:
            break
    assert done.wait() == 2
    assert b"titel" in shown
    assert b"\x1b" not in shown
