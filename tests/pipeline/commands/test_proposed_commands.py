"""Every command that the program proposes works as printed, whatever files and columns are called.

What stands behind ``next:``, ``afterwards:`` or a colon is read as a shell reads it and typed.
"""

import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline.config.load import load_config
from pipeline.model_change import edited_config, read_target
from tests.pipeline.guess.corpus import READ
from tests.pipeline.guess.hand_log import hand_log
from tests.sessions import pipeline, quick_session, rewrite_rows
from tests.world.bench import wedge_directions
from tests.world.designs import paper_design, still_run
from tests.world.session import simulate
from tests.world.sizes import draw_effect
from tests.world.write import write_session

pytestmark = pytest.mark.usefixtures("bare_page")

FOLDER = "Jörg's evening [3] (a & b) -x"
COLUMN = "Fan speed [1/min], ö"
BIAS_PER_RPM = 0.05  #: counts; 75 counts between the slowest and the fastest pose
LSB_NOISE = 2.0
PROPOSES = re.compile(
    "(next|afterwards|then|then type|with it|Now|session|exclude (it|them)): pipeline ")


def proposed(printed: str) -> list[list[str]]:
    """The words of every command that a text proposes."""
    lines = [line.split("pipeline ", 1)[1] for line in printed.splitlines()
             if PROPOSES.search(line)]
    return [shlex.split(line.split(", and with", 1)[0]) for line in lines]


@pytest.fixture
def session(tmp_path: Path) -> Path:
    """A session whose accelerometer follows a logged column that its gyroscope's logs lack."""
    (tmp_path / FOLDER).mkdir()
    config, _ = quick_session(tmp_path / FOLDER)
    rng = np.random.default_rng(3)
    for path in sorted((config.parent / "accelerometer").glob("*.csv")):
        head, *rows = path.read_text(encoding="utf-8").splitlines()
        fan = rng.uniform(800, 2300)
        names = head.split(",")
        table = np.array([[float(cell) for cell in row.split(",")] for row in rows])
        table[:, [names.index(f"acc_{axis}") for axis in "xyz"]] += np.rint(
            BIAS_PER_RPM * fan + rng.normal(0, LSB_NOISE, (len(table), 3)))
        body = "\n".join(",".join([*(f"{v:.9g}" for v in row), f"{fan:.1f}"]) for row in table)
        path.write_text(f'{head},"{COLUMN}"\n{body}\n', encoding="utf-8")
    return config


def test_a_column_with_any_name_in_the_logs_of_one_triad_is_added_as_proposed(
    session: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("run", session) == 0
    (words,) = proposed(capsys.readouterr().out)
    assert words == ["add", str(session), f"accelerometer.column:{COLUMN}"]
    assert pipeline(*words) == 0
    out, err = capsys.readouterr()
    assert "as in its own poses on average" in err
    assert load_config(session).accelerometer.model[-1] == f"column:{COLUMN}"  # type: ignore[union-attr]
    assert "accelerometer: Nothing is missing" in out
    assert pipeline("check", session) == 0
    for words in proposed(out + capsys.readouterr().out):
        log = next((session.parent / "accelerometer").glob("*.csv"))
        typed = [str(log) if word == "LOG" else str(session.parent / "out.csv")
                 if word == "FILE" else word for word in words]
        assert pipeline(*typed) == 0
    target = read_target(load_config(session), f"accelerometer.column:{COLUMN}")
    assert "column:" not in edited_config(load_config(session), target, remove=True).source.text


def test_a_bad_pose_is_excluded_as_proposed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / FOLDER).mkdir()
    config, _ = quick_session(tmp_path / FOLDER)
    bad = config.parent / "gyroscope/17rpm/pose_12.csv"
    table = np.loadtxt(bad, delimiter=",", skiprows=1)
    table[:, [4, 5]] += 200
    rewrite_rows(bad, table)
    assert pipeline("run", config) == 0
    (words,) = proposed(capsys.readouterr().out)
    assert words == ["exclude", str(config), "gyroscope.pose_12"]
    assert pipeline(*words) == 0
    out = capsys.readouterr().out
    assert "gyroscope, 18 → 17 poses" in out
    assert "gyroscope: Nothing is missing" in out
    read = load_config(config).triads
    assert [read[triad].sections[0].exclude for triad in read] == [(), ("pose_12",)]


def test_a_class_is_added_as_proposed_and_named_with_the_block_that_is_proposed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wedge = wedge_directions()
    first = paper_design().scaled(seconds=0.3)
    hidden = draw_effect("temperature_bias", "accelerometer", 4.0, first, 3)
    design = replace(paper_design(), runs=(
        still_run(wedge), still_run(wedge, "warm", soak_c=20.0, lead_s=1200.0),
        still_run(wedge, "cooled", lead_s=1200.0))).scaled(seconds=0.3)
    config = write_session(tmp_path, simulate(design, 3, (hidden,)), film=False).config
    later = tmp_path / "later"
    later.mkdir()
    for path in sorted((tmp_path / "accelerometer").glob("*.csv"))[len(wedge):]:
        path.rename(later / path.name)
    assert pipeline("run", config) == 0
    out = capsys.readouterr().out
    assert "next: record the same poses warmed by about 20 °C and once more after" in out
    bring, add = proposed(out)
    before = config.read_text(encoding="utf-8")
    assert pipeline(*add) == 0
    assert re.search(r"^verdict +effect +nothing_missing$", capsys.readouterr().out, re.MULTILINE)
    config.write_text(before, encoding="utf-8")
    assert bring[1:3] == ["LOGS", "--into"]
    assert pipeline(bring[0], *sorted(later.iterdir()), *bring[2:]) == 0
    assert ('poses: [accelerometer/pose_*.csv, "later/pose_[0-9][0-9].csv"]'
            in config.read_text(encoding="utf-8"))
    (add,) = proposed(capsys.readouterr().out)
    assert add[-1] == "accelerometer.temperature_bias"


def test_commands_before_the_first_log_are_typed_as_proposed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / FOLDER
    assert pipeline("init", folder) == 0
    printed = capsys.readouterr().out
    (plan,) = proposed(printed)
    assert plan == ["plan", str(folder / "config.yaml")]
    assert pipeline(*plan) == 0
    check = shlex.split(printed.split("in place: pipeline ", 1)[1].partition("\n")[0])
    assert check == ["check", str(folder / "config.yaml")]
    assert pipeline(*check) == 3  # no log is there yet
    assert pipeline("history", folder) == 3 or "pipeline run" in capsys.readouterr().out


def test_the_configuration_of_an_import_runs_as_proposed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (path,) = READ["milli_g"](tmp_path, hand_log(seed=1)).files
    strange = path.rename(tmp_path / "-2026-03-04 14-05 Müller's [1].csv")
    assert pipeline("import", "--", strange.name) == 0
    (words,) = proposed(capsys.readouterr().out)
    assert pipeline(*words) == 0


def test_a_folder_stands_for_the_configuration_in_it(
    session: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("check", session.parent) == 0
    assert str(session) in capsys.readouterr().out
    session.rename(session.with_suffix(".txt"))
    assert pipeline("check", session.parent) == 2
    assert "is a folder without config.yaml" in capsys.readouterr().err


@pytest.mark.parametrize(("typed", "meant"), [
    ("g_sensitivity", "'gyroscope.g_sensitivity'"),
    ("gsens", "'gyroscope.g_sensitivity'"),
    ("gyroscope.gsens", "'g_sensitivity'"),
    ("gyro.g_sensitivity", "'gyroscope.g_sensitivity'"),
])
def test_a_target_that_is_nearly_right_is_corrected(
    session: Path, capsys: pytest.CaptureFixture[str], typed: str, meant: str
) -> None:
    assert pipeline("add", session, typed) == 2
    assert f"did you mean {meant}" in capsys.readouterr().err
