"""Users' own physics in the same place as the listed effects, from YAML and from Python."""

from pathlib import Path

import numpy as np
import pytest

from tests.pipeline.stages.user_physics import HEATING, corrected, variant, with_models
from tests.sessions import pipeline, results_in, run_without_page

pytestmark = pytest.mark.usefixtures("bare_page")

MEANS = """\
sensor: {accelerometer: {unit: m_s2}}
site: {gravity_m_s2: 9.80665}
accelerometer: {poses: {means: means.csv}, model: [bias, scale, misalignment]}
effects:
  damp: {unit: "m/s²", %s}
"""


def test_an_expression_is_ranked_named_and_added_like_a_listed_effect(
    damp: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = variant(damp, "heated", HEATING)
    assert pipeline("run", config) == 0
    found = results_in(config.with_suffix(".run"))["gyroscope"]["diagnosis"]
    assert (found["verdict"], found["name"]) == ("effect", "damp")
    assert "'damp' is missing: your own effect." in capsys.readouterr().out
    assert pipeline("add", config, "gyroscope.damp") == 0
    after = results_in(config.with_suffix(".run"))["gyroscope"]
    assert after["diagnosis"]["verdict"] == "nothing_missing"
    assert after["effects"]["damp"]["unit"] == "rad/s per %²"
    assert "damp:  # swelling of the board" in config.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("expression", "says"),
    [
        ("__import__('os').system('touch ran')", "is not allowed in an expression"),
        ("humidity_pct.real", "is not allowed in an expression"),
        ("(lambda: 1)()", "is not allowed in an expression"),
        ("humidity_pct ** time_s", "an exponent must be a number"),
        ("9**9", "is larger than 8"),
        ("humidity_pct +", "is not an expression"),
    ],
)
def test_an_expression_is_never_run_as_code(
    damp: Path, expression: str, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    extra = HEATING.replace("(humidity_pct - 45)**2", repr(expression).replace("'", '"', 2)
                            if "'" not in expression else f'"{expression}"')
    config = variant(damp, "bad", extra)
    assert pipeline("run", config) == 2
    error = capsys.readouterr().err
    assert says in error
    assert "effects.damp" in error
    assert not damp.with_name("ran").exists()


@pytest.mark.parametrize("command", ["check", "run"])
@pytest.mark.parametrize(("expression", "says"), [
    ("humidity_pc", "'humidity_pc' is no logged column, name or shape parameter "
                    "(did you mean 'humidity_pct'?). The logs have: "),
    ("exp(-time_s/tau)", "'tau' is no logged column, name or shape parameter"),
    ("run('17rmp')", "run('17rmp') is no run (did you mean '17rpm'?). There are: 17rpm, m17rpm"),
])
def test_a_name_that_is_not_there_is_said_before_any_fit(
    damp: Path, command: str, expression: str, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    config = variant(damp, "absent", HEATING.replace("(humidity_pct - 45)**2", expression))
    assert pipeline(command, config) == 2
    said = capsys.readouterr()
    assert says in said.err
    assert "effects.damp.expression" in said.err
    assert said.out == ""


@pytest.mark.parametrize(("own", "says"), [
    ('expression: "humidty_pct - 45"',
     "'humidty_pct' is no logged column, name or shape parameter (did you mean 'humidity_pct'?). "
     "The logs have: humidity_pct. "),
    ('expression: "exp(-time_s / tua)", shapes: {tau: [s, 30, 7200]}',
     "the shape parameter 'tau' is not used in 'exp(-time_s / tua)' (did you mean 'tua'?)"),
    ('expression: "exxp(humidity_pct)"', "(did you mean 'exp'?)"),
])
def test_a_misspelt_name_is_said_of_a_table_of_means_too(
    tmp_path: Path, own: str, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = np.random.default_rng(1).normal(size=(14, 7))
    np.savetxt(tmp_path / "means.csv", np.abs(rows), delimiter=",", comments="",
               header="acc_x,acc_y,acc_z,sd_acc_x,sd_acc_y,sd_acc_z,humidity_pct")
    config = tmp_path / "config.yaml"
    config.write_text(MEANS % own, encoding="utf-8")
    assert pipeline("check", config) == 2
    assert says in capsys.readouterr().err


def test_user_effects_that_the_data_cannot_see_are_listed_as_blind(damp_once: Path) -> None:
    config = variant(damp_once, "blind", HEATING.replace("(humidity_pct - 45)**2", "2 * s"))
    found = run_without_page(config)["gyroscope"]["diagnosis"]
    assert "damp" in found["blind"]


def test_a_reference_effect_of_ones_own_acts_on_the_turning_plate_only(damp_once: Path) -> None:
    extra = HEATING.replace("triad: gyroscope", "triad: gyroscope\n    per: reference")
    config = variant(damp_once, "reference", extra.replace("(humidity_pct - 45)**2", "time_s"))
    head, _, tail = config.read_text(encoding="utf-8").rpartition("misalignment]")
    config.write_text(f"{head}misalignment, damp]{tail}", encoding="utf-8")
    found = run_without_page(config)["gyroscope"]["effects"]["damp"]
    assert len(found["values"]) == 1
    assert np.isfinite(found["sd"]).all()


# --- what effects may be made of, from the fit to the correction ---------------------------------


@pytest.fixture(scope="module")
def kinds(damp: Path) -> Path:
    """Results of a session whose models have an effect of every kind that corrects a log."""
    config = with_models(damp, "kinds", "bent, cross", "lean, settle, once, damp")
    run_without_page(config)
    return config.with_suffix(".run")


def log_of(results: Path) -> Path:
    return results.parent / "gyroscope" / "17rpm" / "pose_01.csv"


def test_every_kind_of_effect_is_fitted_and_has_its_parameters(kinds: Path) -> None:
    found = results_in(kinds)
    effects = found["gyroscope"]["effects"] | found["accelerometer"]["effects"]
    assert {name: len(one["values"]) for name, one in effects.items()} == {
        "bent": 3, "cross": 1, "lean": 9, "settle": 4, "once": 3, "damp": 3}
    lean = effects["lean"]
    assert np.abs(np.array(lean["values"]) / np.array(lean["sd"])).max() < 5  # there is none
    assert effects["settle"]["unit"] == "rad/s; tau: s"


def test_every_value_of_an_effect_is_a_row_of_the_table_under_its_name(kinds: Path) -> None:
    assert pipeline("export", kinds, "--to", "csv") == 0
    rows = [line.split(",") for line in (kinds / "calibration.csv").read_text().splitlines()]
    named = [tuple(row[1:3]) for row in rows]
    assert [part for name, part in named if name == "lean"] == [
        f"{i}{j}" for i in "xyz" for j in "xyz"]
    assert ("settle", "tau") in named
    assert [row[5] for row in rows if row[1] == "settle"] == ["rad/s", "rad/s", "rad/s", "s"]
    assert sum(name == "cross" for name, _ in named) == 1


def test_a_correction_is_the_fit_s_own(kinds: Path) -> None:
    """The mean of a corrected pose is what the fit made of the pose's mean."""
    pose = results_in(kinds)["accelerometer"]["poses"][3]
    rows = corrected(kinds, kinds.parent / pose["label"], "--session-clock")
    mean = [rows[f"acc_{axis}_m_s2"].mean() for axis in "xyz"]
    assert mean == pytest.approx(pose["corrected"], abs=2e-4)


def test_a_settling_needs_the_session_s_clock_and_what_belongs_to_one_run_is_of_the_bench(
    kinds: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    corrected(kinds, log_of(kinds))
    assert "add --session-clock" in capsys.readouterr().err
    corrected(kinds, log_of(kinds), "--session-clock")
    assert "once is an effect of the bench" in capsys.readouterr().err


def test_what_a_pose_has_of_the_one_before_is_fitted_and_planned(damp_once: Path) -> None:
    config = with_models(damp_once, "memory", "memory", "damp")
    found = run_without_page(config)["accelerometer"]
    assert len(found["effects"]["memory"]["values"]) == 3
    assert pipeline("plan", config) == 0
    assert pipeline("plan", config, "--effect", "damp") == 0


# --- plan ----------------------------------------------------------------------------------------


def test_plan_goes_with_effects_of_logged_columns(
    damp_once: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = with_models(damp_once, "planned", "temperature_bias", "temperature_bias, damp")
    assert pipeline("plan", config) == 0
    said = capsys.readouterr().out
    assert "planned without" not in said
    assert said.count("degrees of freedom") == 2
    text = config.read_text(encoding="utf-8").replace("pose_*.csv", "coming_*.csv")
    fresh = damp_once.with_name("fresh.yaml")
    fresh.write_text(text, encoding="utf-8")
    assert pipeline("plan", fresh) == 0
    assert ("planned without temperature_bias: the column temperature_c is not in the logs that "
            "are there") in capsys.readouterr().out
