"""Effects that are Python functions run only when the command allows it, and only as fitted."""

import os
import py_compile
import sys
from pathlib import Path

import pytest

from pipeline.stages.user_effects import users_function
from tests.pipeline.stages.user_physics import SQUARE, corrected, variant, with_models
from tests.sessions import pipeline, run_without_page

pytestmark = pytest.mark.usefixtures("bare_page")

IN_PYTHON = """
effects:
  damp:
    python: physics.py:damp
    unit: rad/s per %²
    triad: gyroscope
"""


TOUCHING = (
    "from pathlib import Path\nPath(__file__).with_name('ran').touch()\n"
    "def damp(at):\n    return at.vector\n"
)


def test_python_does_not_run_unless_the_command_allows_it(
    damp_once: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    damp_once.with_name("physics.py").write_text(TOUCHING, encoding="utf-8")
    config = variant(damp_once, "python", IN_PYTHON)
    assert pipeline("run", config) == 2
    assert "runs only when you allow it: add --allow-python" in capsys.readouterr().err
    assert not damp_once.with_name("ran").exists()


def test_neither_is_bytecode_run_in_place_of_the_file_nor_left_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bytecode that says it is of this file, which holds something else than the file."""
    physics = tmp_path / "physics.py"
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    physics.write_text(TOUCHING, encoding="utf-8")
    planted = Path(py_compile.compile(str(physics), doraise=True) or "")
    stat = physics.stat()
    harmless = "def damp(at):\n    return at.vector\n"
    physics.write_text(harmless.ljust(len(TOUCHING)), encoding="utf-8")
    os.utime(physics, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    users_function(physics, "physics.py:damp")
    assert not (tmp_path / "ran").exists()
    planted.unlink()
    users_function(physics, "physics.py:damp")
    assert not planted.exists()


@pytest.mark.parametrize(("python", "says"), [
    ("physics.py:dam", "defines no function 'dam' (did you mean 'damp'?)"),
    ("nowhere.py:damp", "does not name a function"),
])
def test_check_finds_the_function_without_running_it(
    damp_once: Path, python: str, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    damp_once.with_name("physics.py").write_text(TOUCHING, encoding="utf-8")
    config = variant(damp_once, "named", IN_PYTHON)
    assert pipeline("check", config) == 0
    config = variant(damp_once, "misnamed", IN_PYTHON.replace("physics.py:damp", python))
    assert pipeline("check", config) == 2
    assert says in capsys.readouterr().err
    assert not damp_once.with_name("ran").exists()


def test_python_reaches_apply_plan_and_export_and_only_the_file_that_was_fitted(
    damp_once: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    physics = damp_once.with_name("physics.py")
    physics.write_text(SQUARE, encoding="utf-8")
    config = with_models(damp_once, "coded", "", "damp")
    text = config.read_text(encoding="utf-8")
    config.write_text(text.replace("expression: (humidity_pct - 45)**2", "python: physics.py:damp"),
                      encoding="utf-8")
    results = config.with_suffix(".run")
    by_function = run_without_page(config, allow_python=True)["gyroscope"]
    stored = by_function["correction"]["own_effects"]["damp"]
    assert stored["python"] == "physics.py:damp"
    assert len(stored["python_sha256"]) == 64
    log = damp_once.parent / "gyroscope" / "17rpm" / "pose_01.csv"

    capsys.readouterr()
    assert pipeline("apply", results, log) == 4
    said = capsys.readouterr().err
    assert "add --allow-python to the command if you trust physics.py" in said
    assert "raised" not in said  # nothing was run
    assert pipeline("plan", config) == 2
    assert pipeline("plan", config, "--allow-python") == 0
    assert pipeline("export", results, "--to", "kalibr", "--output", results) == 4
    assert pipeline("export", results, "--to", "kalibr", "--output", results,
                    "--allow-python") == 0
    assert "cannot store damp of the gyroscope" in capsys.readouterr().err
    by_python = corrected(results, log, "--allow-python")

    expression = with_models(damp_once, "expressed", "", "damp")
    expressed = run_without_page(expression)["gyroscope"]
    by_expression = corrected(expression.with_suffix(".run"), log)
    one, other = (section["effects"]["damp"] for section in (by_function, expressed))
    assert one["values"] == pytest.approx(other["values"], rel=1e-9)
    assert one["sd"] == pytest.approx(other["sd"], rel=1e-6)
    assert by_python["gyr_x_rad_s"] == pytest.approx(by_expression["gyr_x_rad_s"], abs=1e-7)

    physics.write_text(SQUARE + "# changed\n", encoding="utf-8")
    assert pipeline("apply", results, log, "--allow-python") == 3
    assert "is not the file that was fitted" in capsys.readouterr().err
    physics.unlink()
    assert pipeline("apply", results, log, "--allow-python") == 3
    assert "was not found in" in capsys.readouterr().err


def test_a_function_that_fails_is_named_and_no_bug_of_ours(
    damp_once: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    damp_once.with_name("physics.py").write_text("def damp(at):\n    return at.wetness\n", "utf-8")
    config = variant(damp_once, "failing", IN_PYTHON)
    assert pipeline("diagnose", config, "--allow-python") == 0  # no model has it
    assert "the diagnosis of the gyroscope leaves it out" in capsys.readouterr().err
    text = config.read_text(encoding="utf-8")
    head, _, tail = text.rpartition("misalignment]")
    config.write_text(f"{head}misalignment, damp]{tail}", encoding="utf-8")
    assert pipeline("run", config, "--allow-python") == 4
    error = capsys.readouterr().err
    assert "effects.damp: the Python function raised AttributeError" in error
