"""The command line: exit codes, where output goes, what is imported."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import click
import pytest

import calib.errors
import vision.errors
from pipeline import cli
from pipeline.commands import COMMANDS, front_page
from pipeline.commands.interaction import group
from pipeline.commands.interaction.output import say
from pipeline.console.terminal import ShownStream
from pipeline.errors import ConfigError, DeviceError, UnreadableInput, exit_code_of
from tests.paths import ROOT
from tests.sessions import quick_session, typed

HEAVY = ("numpy", "scipy", "cv2", "matplotlib", "pydantic", "yaml", "rich", "jinja2", "serial")


def run(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """``python -m pipeline`` as a user types it."""
    return subprocess.run(
        [sys.executable, "-m", "pipeline", *arguments], cwd=ROOT, text=True, capture_output=True,
        env={**os.environ, **environment}, check=False,
    )


def test_help_loads_nothing_heavy_and_not_even_click() -> None:
    code = ("import sys, pipeline.cli\nfor arguments in ['--help'], [], ['-h']:\n"
            "    pipeline.cli.main(arguments)\nprint(*sys.modules)")
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, text=True, capture_output=True,
                          check=True)
    loaded = set(done.stdout.splitlines()[-1].split())
    assert not loaded & {*HEAVY, "click"}


def test_no_command_s_help_loads_anything_heavy() -> None:
    code = ("import sys, pipeline.cli\nfor name in sys.argv[1:]:\n"
            "    pipeline.cli.main([name, '--help'])\n    print('loaded', name, *sys.modules)")
    done = subprocess.run([sys.executable, "-c", code, *COMMANDS], cwd=ROOT, text=True,
                          capture_output=True, check=True)
    loaded = [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("loaded ")]
    assert [name for name, *_ in loaded] == [*COMMANDS]
    for name, *modules in loaded:
        assert not {*modules} & {*HEAVY}, name


def test_measuring_a_clip_loads_nothing_that_only_configurations_and_fits_need() -> None:
    code = ("import sys, pipeline.cli; pipeline.cli.main(['rate', 'data/example/video/17rpm.mp4']);"
            " print(*sys.modules)")
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, text=True, capture_output=True,
                          check=True)
    assert "rpm" in done.stdout
    loaded = set(done.stdout.splitlines()[-1].split())
    assert "vision.tracking.track" in loaded
    assert not loaded & {*HEAVY} - {"numpy", "cv2"}


def test_a_session_without_clips_loads_nothing_that_follows_or_measures_them(
    tmp_path: Path
) -> None:
    config, _ = quick_session(tmp_path)
    code = "import sys, pipeline.cli; pipeline.cli.main(sys.argv[1:]); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code, "run", config], cwd=ROOT, text=True,
                          capture_output=True, check=True)
    loaded = set(done.stdout.splitlines()[-1].split())
    assert "pipeline.report.plate.rate_terms" in loaded
    assert not loaded & {"cv2", "vision.rate.measure", "vision.tracking.track"}
    assert "scipy.stats" not in loaded  # a quarter of what a run would load


def test_every_command_of_the_table_is_there_and_on_the_front_page() -> None:
    page = typed("--help")[1]
    for name, (arguments, says) in COMMANDS.items():
        context = click.Context(group.root)
        command = group.root.get_command(context, name)
        assert isinstance(command, click.Command)
        assert command.help
        assert re.search(rf"^  {re.escape(f'{name} {arguments}')} +{re.escape(says)}$", page,
                         re.MULTILINE)


@pytest.mark.parametrize("columns", [40, 60, 80, 200])
def test_help_fits_the_terminal_and_cuts_no_word(
    columns: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = " ".join(front_page().split())
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    monkeypatch.setenv("COLUMNS", str(columns))
    page = front_page()
    assert max(map(len, page.splitlines())) <= min(max(columns, 48), 100)
    assert " ".join(page.split()) == words


def test_the_help_of_every_command_has_examples_that_exist() -> None:
    for name in COMMANDS:
        command = group.root.get_command(click.Context(group.root), name)
        assert command is not None
        shown = command.get_help(click.Context(command, info_name=f"pipeline {name}"))
        examples = [shlex.split(line)[1:] for line in shown.split("Examples:")[1].splitlines()
                    if line.strip()]
        assert examples, name
        options = {option for parameter in command.params for option in parameter.opts}
        for called, *words in examples:
            assert called == name
            assert {word for word in words if word.startswith("--")} <= options


@pytest.mark.parametrize(("option", "commands"), [
    ("--json", "run rate diagnose history plan import check noise fleet"),
    ("--quiet", "run rate diagnose add remove history record plan demo import check noise fleet"),
])
def test_commands_that_print_tables_have_json_and_quiet(option: str, commands: str) -> None:
    for name in commands.split():
        command = group.root.get_command(click.Context(group.root), name)
        assert command is not None
        assert option in {each for parameter in command.params for each in parameter.opts}, name


@pytest.mark.parametrize("command", ["--help", "effects"])
def test_a_reader_that_closes_the_pipe_early_sees_no_traceback(command: str) -> None:
    done = subprocess.run(
        f"{shlex.quote(sys.executable)} -m pipeline {command} | head -3", shell=True, cwd=ROOT,
        text=True, capture_output=True, check=True)
    assert len(done.stdout.splitlines()) == 3
    assert done.stderr == ""


def test_a_shell_can_ask_for_the_names_of_commands() -> None:
    done = run(_PIPELINE_COMPLETE="bash_complete", COMP_WORDS="pipeline re", COMP_CWORD="1")
    assert set(done.stdout.split()) == {"plain,remove", "plain,record"}


def test_a_wrong_command_is_answered_with_the_right_one() -> None:
    code, _, errors = typed("chek", "x.yaml")
    assert code == 2
    assert "did you mean 'check'" in errors


@pytest.mark.parametrize("arguments", [("check",), ("check", "--nonsense", "x"), ("--nonsense",)])
def test_wrong_usage_exits_with_2(arguments: tuple[str, ...]) -> None:
    code, printed, errors = typed(*arguments)
    assert (code, printed) == (2, "")
    assert errors
    assert "Traceback" not in errors


def test_init_writes_a_template_and_never_overwrites(tmp_path: Path) -> None:
    code, printed, _ = typed("init", tmp_path / "new")
    path = tmp_path / "new" / "config.yaml"
    assert code == 0
    assert f"pipeline check {path}" in printed
    path.write_text("mine")
    code, _, errors = typed("init", tmp_path / "new")
    assert code == 2
    assert "left as it is" in errors
    assert path.read_text() == "mine"


def test_check_says_what_is_there_on_stdout(tmp_path: Path) -> None:
    (tmp_path / "clip.mp4").touch()
    path = tmp_path / "c.yaml"
    path.write_text("sensor: mpu-6050\nrate: {slow: {video: clip.mp4}}\n")
    code, printed, errors = typed("check", path)
    assert (code, errors) == (0, "")
    assert "slow: 1 clip, container time, 100 ppm" in printed


def test_check_lists_mistakes_on_stderr_without_a_traceback(tmp_path: Path) -> None:
    path = tmp_path / "c.yaml"
    path.write_text("sensor: mpu-6051\nrate: {slow: {video: clip.mp4}}\n")
    done = run("check", str(path))
    assert (done.returncode, done.stdout) == (2, "")
    assert [line.split(" ")[0] for line in done.stderr.splitlines()] == [f"{path}:1:", f"{path}:2:"]


@pytest.mark.parametrize(("error", "code"), [
    (ConfigError("x"), 2), (UnreadableInput("x"), 3), (DeviceError("x"), 6),
    (calib.errors.UnusableLog("x"), 3), (calib.errors.Undetermined("x"), 4),
    (calib.errors.FitFailed("x"), 5), (vision.errors.UnreadableVideo("x"), 3),
    (vision.errors.RateRefused("x"), 4), (ZeroDivisionError("x"), 1), (KeyboardInterrupt(), 130),
])
def test_each_family_of_errors_has_its_exit_code(
    error: BaseException, code: int, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert exit_code_of(error) == code
    if code == 1:
        return  # nobody expected it: the test below runs it in a process of its own
    fail_with(error, monkeypatch)
    assert cli.main(["fail"]) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert err.strip() == ("Interrupted. Every file is either complete or unchanged."
                           if code == 130 else "x")


def test_python_unwinds_no_thread_of_an_interrupted_program() -> None:
    """It aborts the process where the thread is in C++ code."""
    text = ("import atexit, threading, time; from pipeline import cli, errors\n"
            "cli.main = lambda: errors.{}\n"
            "threading.Thread(target=time.sleep, args=(600,), daemon=True).start()\n"
            "atexit.register(print, 'Python ends it', flush=True); cli.program()")
    for outcome, code, said in (("INTERRUPTED", 130, ""), ("DONE", 0, "Python ends it\n")):
        done = subprocess.run([sys.executable, "-c", text.format(outcome)], cwd=ROOT,
                              capture_output=True, text=True, check=False)
        assert (done.returncode, done.stdout) == (code, said)


def fail_with(error: BaseException, monkeypatch: pytest.MonkeyPatch) -> None:
    """A command ``fail`` that raises ``error``."""
    @click.command("fail")
    def command() -> None:
        raise error

    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    monkeypatch.setitem(COMMANDS, "fail", ("", "Fails."))
    monkeypatch.setattr(group, "import_module", lambda _: type("module", (), {"command": command}))


def test_a_bug_is_reported_as_ours_with_its_traceback_saved(tmp_path: Path) -> None:
    code = ("import sys, click, pipeline.cli, pipeline.commands.init as m\n"
            "m.command = click.Command('init', callback=lambda: 1 / 0)\n"
            "sys.exit(pipeline.cli.main(['init']))")
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, text=True, capture_output=True,
                          env={**os.environ, "TMPDIR": str(tmp_path)}, check=False)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("This is our bug")
    assert "Traceback" not in done.stderr
    assert done.stderr.count("\n") == 1
    (log,) = tmp_path.glob("pipeline-bug-*.log")
    assert str(log) in done.stderr
    assert "ZeroDivisionError: division by zero" in log.read_text()


@pytest.mark.parametrize(("no_color", "expected"), [("1", "hi"), ("", "\x1b[31mhi\x1b[0m")])
def test_no_color_is_honoured(
    no_color: str, expected: str, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    @click.command("colour")
    def command() -> None:
        say("hi", fg="red")

    fail_with(AssertionError(), monkeypatch)
    monkeypatch.setattr(group, "import_module", lambda _: type("module", (), {"command": command}))
    monkeypatch.setattr(ShownStream, "isatty", lambda _: True, raising=False)
    monkeypatch.setenv("NO_COLOR", no_color)
    assert cli.main(["fail"]) == 0
    assert capsys.readouterr().out == expected + "\n"
