"""Nothing of the user's is lost: overwritten inputs, two commands at once, kills at every write."""

import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.attack.any_order import killed
from tests.attack.case import is_consistent
from tests.paths import ROOT
from tests.sessions import accelerometer_alone, pipeline

ADD = ("add", "CONFIG", "accelerometer.bias_drift", "--anyway")
WRITES = 5
"""Files of a model change: configuration, results, report, history and the journal of the four."""


def command(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "pipeline", *map(str, arguments)]


@pytest.mark.parametrize(("step", "n"), [
    ("fsync", WRITES), ("replace", 3), ("fsync", WRITES + 1), ("replace", WRITES + 1)])
def test_a_kill_at_a_write_leaves_all_or_nothing_to_the_next_command(
    alone: Path, step: str, n: int
) -> None:
    """Before and after the journal is in place; each write alone stands in test_files."""
    before = alone.read_bytes()
    code = killed([alone if word == "CONFIG" else word for word in ADD], step, n)
    assert code == (-signal.SIGKILL if n <= WRITES else 0)
    assert pipeline("diagnose", alone) == 0
    assert is_consistent(alone)
    assert (alone.read_bytes() == before) == (step == "fsync" and n <= WRITES)


@pytest.mark.parametrize(("step", "n", "fault"), [
    ("fsync", WRITES, OSError(28, "No space left on device")), ("replace", 3, KeyboardInterrupt())])
def test_a_full_disk_or_an_interrupt_at_a_write_changes_both_or_neither(
    alone: Path, monkeypatch: pytest.MonkeyPatch, step: str, n: int, fault: BaseException,
    capsys: pytest.CaptureFixture[str],
) -> None:
    real, calls = getattr(os, step), 0

    def faulty(*arguments: object) -> object:
        nonlocal calls
        calls += 1
        if calls == n:
            raise fault
        return real(*arguments)

    monkeypatch.setattr(f"pipeline.files.os.{step}", faulty)
    code = pipeline(*[alone if word == "CONFIG" else word for word in ADD])
    monkeypatch.undo()
    assert code in (2, 130)
    assert capsys.readouterr().err.lstrip().startswith(("Interrupted", str(alone.parent)))
    assert pipeline("diagnose", alone) == 0
    assert is_consistent(alone)


def test_commands_at_once_end_one_after_the_other(alone: Path) -> None:
    """A run and two changes of the model: each has its line of history and its words in the file.
    """
    names = ("bias_drift", "warm_up")
    typed = [("run", alone), *(("add", alone, "--anyway", f"accelerometer.{name}")
                               for name in names)]
    runs = [subprocess.Popen(command(*words), cwd=ROOT, stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE, text=True) for words in typed]
    waited = [run.communicate()[1] for run in runs]
    codes = [run.returncode for run in runs]
    assert codes[0] == 0
    text = alone.read_text(encoding="utf-8")
    for name, code, said in zip(names, codes[1:], waited[1:], strict=True):
        assert code in (0, 4, 5), said
        assert (name in text) == (code == 0)
    history = alone.with_suffix(".run") / "history.jsonl"
    assert len(history.read_text(encoding="utf-8").splitlines()) == 1 + codes.count(0)
    assert sum("another command is working on this session" in text for text in waited) >= 1


def test_a_configuration_that_is_edited_meanwhile_is_not_overwritten(
    alone: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from pipeline.commands.interaction import model_change

    results = (alone.with_suffix(".run") / "results.json").read_bytes()
    edited = alone.read_text(encoding="utf-8") + "# a thought of mine\n"
    real = model_change.outputs_of

    def meanwhile(*arguments: object) -> object:
        alone.write_text(edited, encoding="utf-8")
        return real(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(model_change, "outputs_of", meanwhile)
    assert pipeline(*[alone if word == "CONFIG" else word for word in ADD]) == 2
    assert "was changed by somebody else" in capsys.readouterr().err
    assert alone.read_text(encoding="utf-8") == edited
    assert (alone.with_suffix(".run") / "results.json").read_bytes() == results


def test_a_reader_that_goes_away_does_not_stop_the_work(alone: Path) -> None:
    shutil.rmtree(alone.with_suffix(".run"))
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(command("run", alone), cwd=ROOT, stdout=writer, check=False,
                          stderr=subprocess.PIPE, text=True)
    os.close(writer)
    assert (done.returncode, done.stderr) == (0, "")
    assert is_consistent(alone)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="this system has no /dev/full")
def test_a_full_disk_behind_the_output_is_said_and_the_results_are_written(alone: Path) -> None:
    shutil.rmtree(alone.with_suffix(".run"))
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run(command("run", alone), cwd=ROOT, stdout=full, check=False,
                              stderr=subprocess.PIPE, text=True)
    assert done.returncode == 2
    assert "standard output cannot be written (No space left on device)" in done.stderr
    assert is_consistent(alone)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="this system has no /dev/full")
@pytest.mark.parametrize("words", ["--help", "effects scale"])
@pytest.mark.parametrize(("closed", "code"), [
    (">&-", 0), ("2>&-", 0), ("<&- >&- 2>&-", 0), (">/dev/full", 2)])
def test_streams_that_are_closed_or_full_are_no_error_of_the_program(
    words: str, closed: str, code: int
) -> None:
    typed = shlex.join([sys.executable, "-m", "pipeline", *words.split()])
    done = subprocess.run(f"{typed} {closed}", shell=True, cwd=ROOT, check=False,
                          capture_output=True, text=True)
    assert done.returncode == code
    assert done.stderr.count("\n") == (code == 2)


def test_a_symbolic_link_stays_a_link(alone: Path, tmp_path: Path) -> None:
    link = tmp_path / "session" / "linked.yaml"
    link.symlink_to(alone.name)
    assert pipeline(*[link if word == "CONFIG" else word for word in ADD]) == 0
    assert link.is_symlink()
    assert "bias_drift" in alone.read_text(encoding="utf-8")


def test_apply_never_replaces_its_log_the_results_or_a_file_of_the_users(
    alone: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = alone.with_suffix(".run")
    log = sorted((alone.parent / "accelerometer").iterdir())[0]
    notes, made = tmp_path / "notes.txt", tmp_path / "made.csv"
    notes.write_text("mine")
    for output in (log, folder / "results.json", notes):
        kept = output.read_bytes()
        assert pipeline("apply", folder, log, "--output", output) == 2
        assert output.read_bytes() == kept
    assert pipeline("apply", folder, log, "--output", log, "--force") == 2
    assert "is what this command reads" in capsys.readouterr().err
    assert pipeline("apply", folder, log, "--output", made) == 0
    assert pipeline("apply", folder, log, "--output", made) == 0  # its own result
    made.write_text(made.read_text() + "# edited\n")
    assert pipeline("apply", folder, log, "--output", made) == 2
    assert "edited since" in capsys.readouterr().err
    assert pipeline("apply", folder, log, "--output", notes, "--force") == 0


def test_export_and_run_replace_only_what_commands_wrote(
    alone: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, mine = alone.with_suffix(".run"), tmp_path / "mine"
    mine.mkdir()
    (mine / "imu.yaml").write_text("by hand")
    (mine / "report.html").write_text("<p>my own")
    assert pipeline("export", folder, "--to", "kalibr", "--output", mine) == 2
    assert pipeline("run", alone, "--output", mine) == 2
    assert "was not written by `pipeline run`" in capsys.readouterr().err
    assert (mine / "imu.yaml").read_text() == "by hand"
    assert (mine / "report.html").read_text() == "<p>my own"
    assert pipeline("export", folder, "--to", "kalibr", "--output", mine, "--force") == 0
    assert pipeline("export", folder, "--to", "kalibr", "--output", mine) == 0


@pytest.mark.parametrize("command", [
    ADD, ("add", "CONFIG", "--auto"), ("remove", "CONFIG", "accelerometer.misalignment"),
    ("exclude", "CONFIG", "accelerometer.pose_01"), ("check", "CONFIG")])
def test_no_command_replaces_a_page_that_a_run_did_not_write(
    command: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nor begins to work for a folder that cannot be made."""
    config = accelerometer_alone(tmp_path)
    folder = config.with_suffix(".run")
    shutil.rmtree(folder, ignore_errors=True)
    typed = [config if word == "CONFIG" else word for word in command]
    folder.write_text("mine")
    assert pipeline(*typed) == 2
    said = capsys.readouterr()
    assert (said.out, "a folder on the way there is a file" in said.err) == ("", True)
    folder.unlink()
    folder.mkdir()
    (folder / "report.html").write_text("<p>my own")
    assert pipeline(*typed) == 2
    said = capsys.readouterr()
    assert (said.out, "was not written by `pipeline run`" in said.err) == ("", True)
    assert (folder / "report.html").read_text() == "<p>my own"


def test_a_journal_of_somebody_else_moves_nothing(alone: Path, tmp_path: Path) -> None:
    victim = tmp_path / "victim"
    victim.write_text("mine")
    folder = alone.with_suffix(".run")
    (folder / ".victim.x.part").write_text("theirs")
    (tmp_path / ".victim.x.part").write_text("theirs")
    noted = {os.path.relpath(victim, folder): ".victim.x.part", "results.json": "../../victim"}
    (folder / ".unfinished.json").write_text(json.dumps(noted))
    assert pipeline("run", alone) == 0
    assert victim.read_text() == "mine"
    assert not (folder / ".unfinished.json").exists()


def test_sigterm_ends_a_command_as_an_interrupt_does(tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(command("record", "--demo"), cwd=tmp_path, stdout=subprocess.DEVNULL,
                          env=environment, stderr=subprocess.PIPE, text=True) as run:
        assert run.stderr is not None
        run.stderr.readline()
        started = run.stderr.readline()
        run.terminate()
        assert "Ctrl-C" in started
        run.communicate(timeout=240)
        assert run.returncode == 130


def test_control_characters_out_of_a_file_are_shown_not_sent(
    alone: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = '"x\\e]0;owned\\a\\e[2J": 1\n' + alone.read_text(encoding="utf-8")
    alone.write_text(text, encoding="utf-8")
    assert pipeline("check", alone) == 2
    printed = capsys.readouterr().err
    assert "\x1b" not in printed
    assert "\x07" not in printed
    assert "owned" in printed
