"""Nothing of the user's is lost: overwritten inputs, two commands at once, kills at every write."""

import json
import os
import shutil
import signal
import subprocess
import sys
from hashlib import sha256
from pathlib import Path

import pytest

from tests.paths import ROOT
from tests.sessions import pipeline
from tests.world.bench import Design
from tests.world.designs import rich_design
from tests.world.session import simulate
from tests.world.write import write_session

ADD = ("add", "CONFIG", "gyroscope.bias_drift", "--although-aliased",
       "--although-unseen")
#: Kills its own process at the N-th renaming, or before the N-th forcing to the disk.
KILLER = """
import os, sys
from pipeline import cli, files
count, (name, n) = 0, (sys.argv[1], int(sys.argv[2]))
real = getattr(os, name)
def killed(*arguments):
    global count
    count += 1
    if count == n:
        os.kill(os.getpid(), 9)
    return real(*arguments)
setattr(files.os, name, killed)
sys.exit(cli.main(sys.argv[3:]))
"""


def design() -> Design:
    return rich_design().scaled(sample_rate=0.1)


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session that was run once, with its results."""
    written = write_session(tmp_path_factory.mktemp("lost"), simulate(design(), 3), film=False)
    assert pipeline("run", written.config) == 0
    return written.config


@pytest.fixture
def session(calibrated: Path, tmp_path: Path) -> Path:
    shutil.copytree(calibrated.parent, tmp_path / "session")
    return tmp_path / "session" / calibrated.name


def command(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "pipeline", *map(str, arguments)]


def is_consistent(config: Path) -> bool:
    """Whether the results are those of the configuration beside them, and nothing lies about."""
    folder = config.with_suffix(".run")
    results = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    steps = (folder / "history.jsonl").read_text(encoding="utf-8").splitlines()
    hashed = sha256(config.read_text(encoding="utf-8").encode()).hexdigest()
    parts = [*config.parent.rglob("*.part"), *config.parent.rglob(".unfinished*")]
    return (not parts and results["config_sha256"] == hashed
            and json.loads(steps[-1])["config_sha256"] == hashed)


@pytest.mark.parametrize("step", ["replace", "fsync"])
@pytest.mark.parametrize("n", range(1, 7))
def test_a_kill_at_any_write_leaves_all_or_nothing_to_the_next_command(
    session: Path, step: str, n: int
) -> None:
    before = session.read_bytes()
    arguments = [str(session) if word == "CONFIG" else word for word in ADD]
    done = subprocess.run([sys.executable, "-c", KILLER, step, str(n), *arguments], cwd=ROOT,
                          capture_output=True, text=True, check=False)
    assert done.returncode in (0, -signal.SIGKILL), done.stderr
    killed = done.returncode != 0
    assert killed or n > 5  # four files and the journal are written
    assert pipeline("diagnose", session) == 0
    assert is_consistent(session)
    if killed and step == "fsync":
        assert session.read_bytes() == before


@pytest.mark.parametrize("step", ["replace", "fsync"])
@pytest.mark.parametrize("n", range(1, 6))
@pytest.mark.parametrize("fault", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_full_disk_or_an_interrupt_at_any_write_changes_both_or_neither(
    session: Path, monkeypatch: pytest.MonkeyPatch, step: str, n: int, fault: BaseException,
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
    code = pipeline(*[session if word == "CONFIG" else word for word in ADD])
    monkeypatch.undo()
    assert code in (2, 130)
    assert capsys.readouterr().err.lstrip().startswith(("Interrupted", str(session.parent)))
    assert pipeline("diagnose", session) == 0
    assert is_consistent(session)


def test_four_runs_at_once_leave_four_lines_of_history(session: Path) -> None:
    runs = [subprocess.Popen(command("run", session), cwd=ROOT, stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE, text=True) for _ in range(4)]
    waited = [run.communicate()[1] for run in runs]
    assert [run.returncode for run in runs] == [0] * 4
    history = session.with_suffix(".run") / "history.jsonl"
    assert len(history.read_text(encoding="utf-8").splitlines()) == 1 + 4
    assert sum("another command is working on this session" in text for text in waited) >= 1


def test_a_configuration_that_is_edited_meanwhile_is_not_overwritten(
    session: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from pipeline.commands import model_change

    results = (session.with_suffix(".run") / "results.json").read_bytes()
    edited = session.read_text(encoding="utf-8") + "# a thought of mine\n"
    real = model_change.outputs_of

    def meanwhile(*arguments: object) -> object:
        session.write_text(edited, encoding="utf-8")
        return real(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(model_change, "outputs_of", meanwhile)
    assert pipeline(*[session if word == "CONFIG" else word for word in ADD]) == 2
    assert "was changed by somebody else" in capsys.readouterr().err
    assert session.read_text(encoding="utf-8") == edited
    assert (session.with_suffix(".run") / "results.json").read_bytes() == results


def test_a_reader_that_goes_away_does_not_stop_the_work(session: Path) -> None:
    shutil.rmtree(session.with_suffix(".run"))
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(command("run", session), cwd=ROOT, stdout=writer, check=False,
                          stderr=subprocess.PIPE, text=True)
    os.close(writer)
    assert (done.returncode, done.stderr) == (0, "")
    assert is_consistent(session)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="this system has no /dev/full")
def test_a_full_disk_behind_the_output_is_said_and_the_results_are_written(session: Path) -> None:
    shutil.rmtree(session.with_suffix(".run"))
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run(command("run", session), cwd=ROOT, stdout=full, check=False,
                              stderr=subprocess.PIPE, text=True)
    assert done.returncode == 2
    assert "standard output cannot be written (No space left on device)" in done.stderr
    assert is_consistent(session)


def test_a_symbolic_link_stays_a_link(session: Path, tmp_path: Path) -> None:
    link = tmp_path / "session" / "linked.yaml"
    link.symlink_to(session.name)
    assert pipeline(*[link if word == "CONFIG" else word for word in ADD]) == 0
    assert link.is_symlink()
    assert "bias_drift" in session.read_text(encoding="utf-8")


def test_apply_never_replaces_its_log_the_results_or_a_file_of_the_users(
    session: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = session.with_suffix(".run")
    log = sorted((session.parent / "accelerometer").iterdir())[0]
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
    session: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, mine = session.with_suffix(".run"), tmp_path / "mine"
    mine.mkdir()
    (mine / "imu.yaml").write_text("by hand")
    (mine / "report.html").write_text("<p>my own")
    assert pipeline("export", folder, "--to", "kalibr", "--output", mine) == 2
    assert pipeline("run", session, "--output", mine) == 2
    assert "was not written by `pipeline run`" in capsys.readouterr().err
    assert (mine / "imu.yaml").read_text() == "by hand"
    assert (mine / "report.html").read_text() == "<p>my own"
    assert pipeline("export", folder, "--to", "kalibr", "--output", mine, "--force") == 0
    assert pipeline("export", folder, "--to", "kalibr", "--output", mine) == 0


def test_the_link_of_a_played_port_replaces_no_file(
    session: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    note = tmp_path / "note.txt"
    note.write_text("mine")
    assert pipeline("playback", session, "--link", note) == 2
    assert "is no link to a port" in capsys.readouterr().err
    assert note.read_text() == "mine"


def test_a_journal_of_somebody_else_moves_nothing(session: Path, tmp_path: Path) -> None:
    victim = tmp_path / "victim"
    victim.write_text("mine")
    folder = session.with_suffix(".run")
    (folder / ".victim.x.part").write_text("theirs")
    (tmp_path / ".victim.x.part").write_text("theirs")
    noted = {os.path.relpath(victim, folder): ".victim.x.part", "results.json": "../../victim"}
    (folder / ".unfinished.json").write_text(json.dumps(noted))
    assert pipeline("run", session) == 0
    assert victim.read_text() == "mine"
    assert not (folder / ".unfinished.json").exists()


def test_sigterm_ends_a_command_as_an_interrupt_does(session: Path) -> None:
    with subprocess.Popen(command("playback", session), cwd=ROOT, stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE, text=True) as run:
        assert run.stderr is not None
        started = run.stderr.readline()
        run.terminate()
        assert "Ctrl-C" in started
        assert run.wait(10) == 130


def test_control_characters_out_of_a_file_are_shown_not_sent(
    session: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = '"x\\e]0;owned\\a\\e[2J": 1\n' + session.read_text(encoding="utf-8")
    session.write_text(text, encoding="utf-8")
    assert pipeline("check", session) == 2
    printed = capsys.readouterr().err
    assert "\x1b" not in printed
    assert "\x07" not in printed
    assert "owned" in printed
