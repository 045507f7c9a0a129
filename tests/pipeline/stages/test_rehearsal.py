"""``pipeline check`` on a filmed session: what no clip decides is refused before one is opened."""

import shutil
from pathlib import Path

import pytest

from tests.paths import DATA
from tests.sessions import edit, pipeline

GYRO = "rate: 17rpm}\n  model: [bias, scale, misalignment"


@pytest.fixture
def filmed(tmp_path: Path) -> Path:
    """The example session with a clip that nobody can open."""
    shutil.copytree(DATA / "example", tmp_path / "example", ignore=shutil.ignore_patterns("*.run"))
    (tmp_path / "example/video/17rpm.mp4").write_bytes(b"no clip")
    return tmp_path / "example/config.yaml"


@pytest.mark.parametrize(("effects", "code", "said"), [
    ("", 0, "no error"),
    (", bias_drift", 0, "no error"),
    (", g_sensitivity", 4, "these poses cannot see 'g_sensitivity'"),
    (", cubic, temperature_bias, hysteresis", 4, "18 equations for 19 parameters"),
])
def test_check_refuses_what_no_clip_decides_and_opens_none(
    filmed: Path, effects: str, code: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    edit(filmed, GYRO, GYRO + effects)
    assert pipeline("check", filmed) == code
    assert said in "".join(capsys.readouterr())
    assert not filmed.with_suffix(".run").exists()


def test_check_runs_no_python_and_says_nothing_of_a_model_that_needs_it(filmed: Path) -> None:
    (filmed.parent / "mine.py").write_text("open('ran', 'w')\ndef f(poses):\n    return poses\n")
    edit(filmed, GYRO, GYRO + ", mine")
    with filmed.open("a", encoding="utf-8") as text:
        text.write("\neffects:\n  mine: {python: 'mine.py:f', unit: '1', triad: gyroscope}\n")
    assert pipeline("check", filmed) == 0
    assert not Path("ran").exists()
