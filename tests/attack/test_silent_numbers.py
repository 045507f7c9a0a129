"""Numbers that would be wrong without a word: each mistake is refused or said, and by its name.

A case is a session, what is done to it, the exit code and what must be said. Nothing is written by
a command that refuses.
"""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from tests.attack.judged import judge
from tests.attack.mistakes import CASES, POSE_7
from tests.attack.spoilt import (
    appended,
    config_text,
    copy_of,
    write_base,
)
from tests.sessions import pipeline
from tests.world.designs import rich_design
from tests.world.hidden import Hidden
from tests.world.session import simulate
from tests.world.write import write_session


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sessions without a fault."""
    folder = tmp_path_factory.mktemp("base")
    write_base(folder)
    return folder


@pytest.mark.parametrize("case", CASES)
def test_a_mistake_is_refused_by_its_name_and_nothing_is_written(
    base: Path, tmp_path: Path, case: str, capsys: pytest.CaptureFixture[str]
) -> None:
    name, spoil, command, code, said = CASES[case]
    config = copy_of(base, name, tmp_path)
    spoil(config)
    before = sorted(config.parent.rglob("*"))
    assert pipeline(command, config) == code
    message = capsys.readouterr().err
    assert [part for part in said.split("|") if part not in message] == [], message
    assert sorted(config.parent.rglob("*")) == before


@pytest.mark.parametrize("name", ["paper", "rich"])
def test_a_session_without_a_fault_is_not_contradicted(
    base: Path, tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    config = copy_of(base, name, tmp_path)
    assert pipeline("check", config) == 0
    assert pipeline("run", config) == 0
    streams = capsys.readouterr()
    assert streams.out.count("Nothing is missing") == 2
    assert "warning" not in streams.err


def test_an_effect_that_no_model_has_does_not_stop_the_run(
    base: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = copy_of(base, "paper", tmp_path)
    appended("\neffects:\n  foo: {expression: log(-1 - temperature_c**2), unit: '1'}\n")(config)
    assert pipeline("run", config) == 0
    assert "leaves it out" in capsys.readouterr().err


def test_a_gain_off_the_data_sheet_is_said_with_both_reasons(
    base: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = copy_of(base, "paper", tmp_path)
    config_text("full_scale_deg_s: 150", "full_scale_deg_s: 300")(config)
    assert pipeline("run", config) == 0
    said = capsys.readouterr().err
    assert "times the data sheet's" in said
    assert "or the rate of the plate is wrong by that factor" in said


def test_results_that_determine_nothing_are_not_applied(base: Path, tmp_path: Path) -> None:
    config = copy_of(base, "paper", tmp_path)
    assert pipeline("run", config) == 0
    results = config.with_suffix(".run") / "results.json"
    text = results.read_text(encoding="utf-8")
    edited = json.loads(text)
    edited["gyroscope"]["sd"]["scale_counts_per_unit"] = [2e4, 2e4, 2e4]
    results.write_text(json.dumps(edited), encoding="utf-8")
    assert pipeline("apply", results, config.parent / POSE_7) == 4
    assert pipeline("export", results, "--to", "json") == 4


@pytest.mark.parametrize("doubt", [0.002, 0.01, 0.03])
def test_a_stated_doubt_of_the_rates_buys_no_gain_and_the_loop_works(
    tmp_path: Path, doubt: float
) -> None:
    """A g-sensitivity of 0.1 °/s per g beside rates of which 0.2 to 3 % are stated as unknown."""
    size = 1.78e-4 * np.outer([1.0, -0.7, 0.4], [0.4, -0.7, 1.0])
    session = simulate(rich_design().scaled(sample_rate=0.2), 3,
                       (Hidden("g_sensitivity", "gyroscope", size),))
    config = write_session(tmp_path, session, film=False).config
    text = config.read_text(encoding="utf-8")
    for name, rate in session.rates.items():
        text = re.sub(rf"(  {name}: .*sd_rad_s: )[\d.e-]+",
                      rf"\g<1>{abs(rate.rate_rad_s) * doubt:.3g}", text)
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
