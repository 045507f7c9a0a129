"""Numbers that would be wrong without a word: what the grammar of mistakes does not draw.

A mistake in two places, in names, in columns beside the triads, in the mounting.
"""

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.attack.case import POSE, Case, Spoil, append, both, check, edit, rows
from tests.attack.judged import judge
from tests.sessions import pipeline
from tests.world.designs import rich_design
from tests.world.hidden import Hidden
from tests.world.session import simulate
from tests.world.write import write_session

pytestmark = pytest.mark.usefixtures("bare_page")

ROCKED = "accelerometer/pose_10.csv"
TURNING = "gyroscope/17rpm/pose_03.csv"
MODEL = "model: [bias, scale, misalignment]\n\ngyroscope"
MIDDLE, COUNTS_PER_RAD_S = 32767.5, 9500.0


def every(pattern: str, change: Callable[[list[str]], list[str]]) -> Spoil:
    """Other cells in every row of the logs that match."""

    def spoil(config: Path) -> None:
        paths = sorted(config.parent.glob(pattern))
        assert paths
        for path in paths:
            rows(change, path.relative_to(config.parent).as_posix())(config)

    return spoil


def two_names(config: Path) -> None:
    for path in sorted((config.parent / "accelerometer").glob("*.csv")):
        shutil.copy(path, path.with_name(f"again_{path.name}"))
    edit("accelerometer/pose_*.csv", "accelerometer/*.csv")(config)


def rocking(config: Path) -> None:
    """Turned to and fro about x by 8° once a second."""

    def rocked(cells: list[str]) -> list[str]:
        time, x, y, z, around, *others = map(float, cells)
        angle = np.radians(8.0) * np.sin(2 * np.pi * time)
        c, s = np.cos(angle), np.sin(angle)
        y, z = y - MIDDLE, z - MIDDLE
        around += COUNTS_PER_RAD_S * np.radians(8.0) * 2 * np.pi * np.cos(2 * np.pi * time)
        counts = (x, MIDDLE + y * c - z * s, MIDDLE + y * s + z * c, around, *others[:2])
        return [cells[0], *(f"{count:.0f}" for count in counts), *cells[7:]]

    rows(rocked, ROCKED)(config)


def empty_cell(config: Path) -> None:
    path = config.parent / POSE
    lines = path.read_text(encoding="utf-8").splitlines()
    lines[40] = f"{lines[40].rpartition(',')[0]},nan"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def gyroscope_alone(config: Path) -> None:
    """The logs of the turning runs lack the accelerometer."""
    for path in config.parent.glob("gyroscope/*/*.csv"):
        cells = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()]
        path.write_text("".join(f"{','.join([row[0], *row[4:]])}\n" for row in cells),
                        encoding="utf-8")


def effect(name: str) -> Spoil:
    """One more in the accelerometer's model."""
    return edit(MODEL, MODEL.replace("misalignment", f"misalignment, {name}"))


CASES = (
    Case("the triads exchanged", "run CONFIG", 4, "accelerometer",
         every("*/**/*.csv", lambda c: [c[0], *c[4:7], *c[1:4], *c[7:]])),
    Case("the same files under new names", "check CONFIG", 4,
         "hold the same accelerometer samples", two_names),
    Case("one file by two paths", "check CONFIG", 2, "is named twice", edit(
        "poses: accelerometer/pose_*.csv", "poses: [accelerometer/pose_*.csv, "
        "accelerometer/../accelerometer/pose_01.csv]")),
    Case("a rate that nobody knows", "check CONFIG", 2, "determines no scale",
         edit("sd_rad_s: 8.73e-05", "sd_rad_s: 1.0")),
    Case("a pose that rocks", "run CONFIG", 4,
         r"pose_10.csv: the sensor was shaken[^$]*short of gravity", rocking),
    Case("installed on the turning plate", "run CONFIG", 4, "was turning",
         append(f"installation: {{log: {TURNING}}}")),
    Case("the same log at both headings", "check CONFIG", 2, "is the file of `log`",
         append(f"installation: {{log: {POSE}, reverse_log: {POSE}}}")),
    Case("a column that is not there", "check CONFIG", 2, "needs the column nope",
         effect("column:nope")),
    Case("an empty cell of a column", "check CONFIG", 4,
         "no complete column temperature_c, first in accelerometer/pose_07.csv",
         both(empty_cell, effect("temperature_bias"))),
)
RUN_17 = "- {poses: gyroscope/17rpm/pose_*.csv, rate: 17rpm}"
RICH_CASES = (
    Case("the same run twice", "check CONFIG", 2, r"is in gyroscope.runs\[0\].poses as well",
         edit(RUN_17, f"{RUN_17}\n    {RUN_17}")),
    Case("rates exchanged, gyroscope alone", "run CONFIG", 4,
         r"the rates \(or the clips, or the files\)[^$]*are exchanged", both(
             edit("gyroscope/17rpm/pose_*.csv, rate: 17rpm", "gyroscope/17rpm/pose_*.csv, rate: X"),
             edit("gyroscope/33rpm/pose_*.csv, rate: 33rpm", "gyroscope/33rpm/pose_*.csv, "
                  "rate: 17rpm"), edit("rate: X", "rate: 33rpm"), gyroscope_alone)),
    Case("kelvin in one run", "check CONFIG", 4, r"temperature_c[^$]*in kelvin", every(
        "gyroscope/33rpm/*.csv", lambda c: [*c[:7], f"{float(c[7]) + 273.15}", *c[8:]])),
)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_mistake_is_refused_by_its_name_and_nothing_is_written(
    case: Case, copied: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    check(case, copied, capsys)


@pytest.mark.parametrize("case", RICH_CASES, ids=lambda case: case.name)
def test_a_mistake_of_a_run_is_refused_by_its_name(
    case: Case, rich: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    check(case, rich, capsys)


@pytest.mark.parametrize("name", ["copied", "rich"])
def test_a_session_without_a_fault_is_not_contradicted(
    name: str, request: pytest.FixtureRequest, capsys: pytest.CaptureFixture[str]
) -> None:
    config = request.getfixturevalue(name)
    assert pipeline("check", config) == 0
    assert pipeline("run", config) == 0
    streams = capsys.readouterr()
    assert streams.out.count("Nothing is missing") == 2
    assert "warning" not in streams.err


def test_an_effect_that_no_model_has_does_not_stop_the_run(
    copied: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    append("effects:\n  foo: {expression: log(-1 - temperature_c**2), unit: '1'}")(copied)
    assert pipeline("run", copied) == 0
    assert "leaves it out" in capsys.readouterr().err


def test_a_gain_off_the_data_sheet_is_said_with_both_reasons(
    copied: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    edit("full_scale_deg_s: 150", "full_scale_deg_s: 300")(copied)
    assert pipeline("run", copied) == 0
    said = capsys.readouterr().err
    assert "times the data sheet's" in said
    assert "or the rate of the plate is wrong by that factor" in said


def test_a_stated_doubt_of_the_rates_buys_no_gain_and_the_loop_works(tmp_path: Path) -> None:
    """A g-sensitivity of 0.1 °/s per g beside rates of which 3 % are stated as unknown."""
    size = 1.78e-4 * np.outer([1.0, -0.7, 0.4], [0.4, -0.7, 1.0])
    session = simulate(rich_design().scaled(sample_rate=0.2), 3,
                       (Hidden("g_sensitivity", "gyroscope", size),))
    config = write_session(tmp_path, session, film=False).config
    text = config.read_text(encoding="utf-8")
    for name, rate in session.rates.items():
        text = re.sub(rf"(  {name}: .*sd_rad_s: )[\d.e-]+",
                      rf"\g<1>{abs(rate.rate_rad_s) * 0.03:.3g}", text)
    config.write_text(text, encoding="utf-8")
    judged = judge(config, session)
    assert judged.verdicts["gyroscope"] == "effect"
    assert "'g_sensitivity' is missing" in judged.texts["gyroscope"]
    assert np.abs(judged.off["gyroscope"][2]).max() < 4
    head, _, tail = text.rpartition("misalignment]")
    config.write_text(f"{head}misalignment, g_sensitivity]{tail}", encoding="utf-8")
    judged = judge(config, session)
    assert judged.verdicts["gyroscope"] == "nothing_missing"
    assert np.abs(judged.off["gyroscope"]).max() < 4
