"""Three minutes on a plate that leans, from logs to both triads."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline.config.load import load_config
from pipeline.console.answers import RATES, answers_of
from pipeline.errors import ConfigError
from pipeline.stages.context import RunContext
from pipeline.stages.run import run_stages
from tests.sessions import pipeline, results_in, run_without_page
from tests.world.designs import tilted_design
from tests.world.hidden import Hidden
from tests.world.make_data import G_SENSITIVITY_DEG_S_PER_G
from tests.world.session import simulate
from tests.world.write import write_session

pytestmark = pytest.mark.usefixtures("bare_page")


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Logs and a configuration whose accelerometer has runs and no poses at rest."""
    per_si = np.radians(G_SENSITIVITY_DEG_S_PER_G) / 9.80665
    session = simulate(replace(tilted_design(20.0), sample_rate_hz=25.0), 41,
                       (Hidden("g_sensitivity", "gyroscope", per_si),))
    return write_session(tmp_path_factory.mktemp("tilted"), session, film=False).config


def test_both_triads_come_from_the_turning_plate(config: Path) -> None:
    results = run_without_page(config)
    assert results["accelerometer"]["diagnosis"]["verdict"] == "nothing_missing"
    assert results["gyroscope"]["diagnosis"]["names"] == ["g_sensitivity"]
    assert pipeline("add", config, "gyroscope.g_sensitivity") == 0
    after = results_in(config.with_suffix(".run"))["gyroscope"]
    assert after["diagnosis"]["verdict"] == "nothing_missing"
    values = np.degrees(after["effects"]["g_sensitivity"]["values"]) * 9.80665
    assert values == pytest.approx(G_SENSITIVITY_DEG_S_PER_G.ravel(), abs=0.06)


def test_a_rate_that_is_stated_wrongly_is_told(config: Path) -> None:
    text = config.read_text(encoding="utf-8")
    (stated,) = re.findall(r"rate_rad_s: ([0-9.]+)", text)
    wrong = config.with_name("wrong.yaml")
    wrong.write_text(text.replace(stated, f"{1.01 * float(stated):.6f}"), encoding="utf-8")
    outcome = run_stages(load_config(wrong), RunContext())
    (told,) = (each for each in outcome.warnings if "slower than stated" in each)
    assert "the plate turned 0.99 ± 0.0" in told
    shorts = [each.short for each in answers_of(outcome, "") if each.subject == RATES]
    assert shorts == ["The rate of 17rpm contradicts the logs by 0.99 %, "
                      "and the scale of the gyroscope may be off by that."]
    sound = run_stages(load_config(config), RunContext())
    assert not any("than stated" in each for each in sound.warnings)
    wrong_one, right = (one.triads[-1].calibration.parameters for one in (outcome, sound))
    assert wrong_one.scale_counts_per_unit * 1.01 == pytest.approx(
        right.scale_counts_per_unit, rel=1e-3)
    assert np.all(wrong_one.sd[2] * 1.2 > right.scale_counts_per_unit * 0.01)
    assert not [each for each in answers_of(sound, "") if each.subject == RATES]


def test_a_plan_has_the_rows_of_the_run(
    config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    results = run_without_page(config)
    assert pipeline("plan", config, "--json") == 0
    planned = json.loads(capsys.readouterr().out)
    for triad in ("accelerometer", "gyroscope"):
        assert planned[triad]["recorded"]["dof"] == results[triad]["dof"]


def test_an_accelerometer_without_poses_and_runs_is_refused_by_its_line(config: Path) -> None:
    text = config.read_text(encoding="utf-8")
    head, _, rest = text.partition("accelerometer:  # the plate leans")
    bare = config.with_name("bare.yaml")
    rest = rest[rest.index("\ngyroscope:") :]
    bare.write_text(f"{head}accelerometer: {{model: [bias]}}\n{rest}", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"poses is missing|is missing; name the logs"):
        load_config(bare)


def test_poses_can_be_left_out_of_a_run(config: Path) -> None:
    text = config.read_text(encoding="utf-8")
    fewer = config.with_name("fewer.yaml")
    run = "pose_*.csv, rate: 17rpm}"
    assert run in text
    fewer.write_text(text.replace(run, "pose_*.csv, rate: 17rpm, exclude: [pose_07]}"),
                     encoding="utf-8")
    outcome = run_stages(load_config(fewer), RunContext())
    assert [len(each.calibration.fit.poses) for each in outcome.triads] == [8, 8]
    assert [each.excluded[0].predicted is not None for each in outcome.triads] == [True, True]
