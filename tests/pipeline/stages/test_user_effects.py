"""Users' own physics in the same place as the listed effects, from YAML and from Python."""

from pathlib import Path

import numpy as np
import pytest

from tests.sessions import pipeline, results_in
from tests.trials import drawn
from tests.world.designs import rich_design
from tests.world.session import simulate
from tests.world.write import write_session

RICH = rich_design().scaled(sample_rate=0.1)
HEATING = """
effects:
  damp:  # swelling of the board, with the square of the humidity above 45 %
    expression: (humidity_pct - 45)**2
    unit: rad/s per %²
    triad: gyroscope
"""
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


@pytest.fixture(scope="module")
def damp(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session with an effect that no catalogue has."""
    hidden = drawn("column_squared:humidity_pct", "gyroscope", 8.0, RICH, 5)
    assert hidden is not None
    folder = tmp_path_factory.mktemp("damp")
    return write_session(folder, simulate(RICH, 5, (hidden,)), film=False).config


def variant(damp: Path, name: str, extra: str) -> Path:
    """The same session under another configuration, with results of its own."""
    config = damp.with_name(f"{name}.yaml")
    config.write_text(damp.read_text(encoding="utf-8") + extra, encoding="utf-8")
    return config


def test_an_expression_is_ranked_named_and_added_like_a_listed_effect(
    damp: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plain = variant(damp, "plain", "")
    assert pipeline("run", plain) == 0
    assert results_in(plain.with_suffix(".run"))["gyroscope"]["diagnosis"]["verdict"] == "unknown"
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


def test_a_python_function_gives_the_same_as_the_expression(damp: Path) -> None:
    damp.with_name("physics.py").write_text(
        "import numpy as np\n"
        "def damp(at):\n"
        "    square = (at.column('humidity_pct') - 45) ** 2\n"
        "    return np.tile(square[:, None], 3)\n",
        encoding="utf-8",
    )
    effects = []
    for name, extra in (("one", HEATING), ("two", IN_PYTHON)):
        text = extra.replace("effects:", "effects:", 1)
        config = variant(damp, name, text)
        allowed = ["--allow-python"] if name == "two" else []
        assert pipeline("add", config, "gyroscope.damp", *allowed) == 0
        effects.append(results_in(config.with_suffix(".run"))["gyroscope"]["effects"]["damp"])
    assert effects[0]["values"] == pytest.approx(effects[1]["values"], rel=1e-9)
    assert effects[0]["sd"] == pytest.approx(effects[1]["sd"], rel=1e-6)


def test_python_does_not_run_unless_the_command_allows_it(
    damp: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    damp.with_name("physics.py").write_text(TOUCHING, encoding="utf-8")
    config = variant(damp, "python", IN_PYTHON)
    assert pipeline("run", config) == 2
    assert "runs only when you allow it: add --allow-python" in capsys.readouterr().err
    assert not damp.with_name("ran").exists()


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


@pytest.mark.parametrize(("python", "says"), [
    ("physics.py:dam", "defines no function 'dam' (did you mean 'damp'?)"),
    ("nowhere.py:damp", "does not name a function"),
])
def test_check_finds_the_function_without_running_it(
    damp: Path, python: str, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    damp.with_name("physics.py").write_text(TOUCHING, encoding="utf-8")
    config = variant(damp, "named", IN_PYTHON)
    assert pipeline("check", config) == 0
    config = variant(damp, "misnamed", IN_PYTHON.replace("physics.py:damp", python))
    assert pipeline("check", config) == 2
    assert says in capsys.readouterr().err
    assert not damp.with_name("ran").exists()


def test_user_effects_that_the_data_cannot_see_are_listed_as_blind(damp: Path) -> None:
    config = variant(damp, "blind", HEATING.replace("(humidity_pct - 45)**2", "2 * s"))
    assert pipeline("run", config) == 0
    found = results_in(config.with_suffix(".run"))["gyroscope"]["diagnosis"]
    assert "damp" in found["blind"]
    assert pipeline("add", config, "gyroscope.damp") == 4


def test_a_reference_effect_of_ones_own_acts_on_the_turning_plate_only(damp: Path) -> None:
    extra = HEATING.replace("triad: gyroscope", "triad: gyroscope\n    per: reference")
    config = variant(damp, "reference", extra.replace("(humidity_pct - 45)**2", "time_s"))
    assert pipeline("add", config, "gyroscope.damp") == 0
    found = results_in(config.with_suffix(".run"))["gyroscope"]["effects"]["damp"]
    assert len(found["values"]) == 1
    assert np.isfinite(found["sd"]).all()


# --- what effects may be made of, from the fit to the correction ---------------------------------

KINDS = """
effects:
  settle: {expression: exp(-time_s/tau), shapes: {tau: [s, 30, 7200]}, unit: rad/s}
  lean: {expression: f, per: matrix, unit: (rad/s)/(m/s²), triad: gyroscope}
  memory: {expression: tanh(p/3), unit: "{u}", triad: accelerometer}
  bent: {expression: f**2, unit: 1/(m/s²), triad: accelerometer}
  cross: {expression: other_x, per: common, unit: (m/s²)/(rad/s), triad: accelerometer}
  once: {expression: run('17rpm'), unit: rad/s, triad: gyroscope}
  damp: {expression: (humidity_pct - 45)**2, unit: rad/s per %², triad: gyroscope}
"""


def with_models(damp: Path, name: str, accelerometer: str = "", gyroscope: str = "") -> Path:
    """The session with these user-defined effects in its models."""
    text = damp.read_text(encoding="utf-8") + KINDS
    base = "model: [bias, scale, misalignment"
    first, second, third = text.split(base)
    added = [f", {names}" if names else "" for names in (accelerometer, gyroscope)]
    config = damp.with_name(f"{name}.yaml")
    config.write_text(first + base + added[0] + second + base + added[1] + third, "utf-8")
    return config


def corrected(results: Path, log: Path, *options: str) -> np.ndarray:
    """What ``apply`` makes of a log, columns as named."""
    output = results / "corrected.csv"
    assert pipeline("apply", results, log, "--output", output, *options) == 0
    return np.genfromtxt(output, delimiter=",", names=True)


def test_every_kind_of_effect_is_fitted_planned_and_has_its_parameters(damp: Path) -> None:
    config = with_models(damp, "kinds", "memory", "lean, settle, once, damp")
    assert pipeline("run", config) == 0
    found = results_in(config.with_suffix(".run"))
    lean = found["gyroscope"]["effects"]["lean"]
    assert len(lean["values"]) == 9
    assert np.abs(np.array(lean["values"]) / np.array(lean["sd"])).max() < 5  # there is none
    assert len(found["gyroscope"]["effects"]["settle"]["values"]) == 4
    assert found["gyroscope"]["effects"]["settle"]["unit"] == "rad/s; tau: s"
    assert len(found["gyroscope"]["effects"]["once"]["values"]) == 3
    assert len(found["accelerometer"]["effects"]["memory"]["values"]) == 3
    assert pipeline("plan", config) == 0
    assert pipeline("plan", config, "--effect", "damp") == 0


def test_what_belongs_to_one_run_is_no_error_of_the_sensor(
    damp: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = with_models(damp, "once", "", "once, damp")
    assert pipeline("run", config) == 0
    log = damp.parent / "gyroscope" / "17rpm" / "pose_01.csv"
    corrected(config.with_suffix(".run"), log)
    assert "once is an effect of the bench" in capsys.readouterr().err


@pytest.mark.parametrize("names", ["bent", "cross"])
def test_a_correction_is_the_fit_s_own(damp: Path, names: str) -> None:
    """The mean of a corrected pose is what the fit made of the pose's mean."""
    config = with_models(damp, names, names, "damp")
    assert pipeline("run", config) == 0
    results = config.with_suffix(".run")
    pose = results_in(results)["accelerometer"]["poses"][3]
    rows = corrected(results, damp.parent / pose["label"])
    mean = [rows[f"acc_{axis}_m_s2"].mean() for axis in "xyz"]
    assert mean == pytest.approx(pose["corrected"], abs=2e-4)


def test_a_settling_needs_the_session_s_clock(
    damp: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = with_models(damp, "settling", "", "settle, damp")
    assert pipeline("run", config) == 0
    log = damp.parent / "gyroscope" / "17rpm" / "pose_01.csv"
    assert pipeline("apply", config.with_suffix(".run"), log) == 4
    assert "add --session-clock" in capsys.readouterr().err
    corrected(config.with_suffix(".run"), log, "--session-clock")


# --- Python beyond the fit -----------------------------------------------------------------------

SQUARE = """\
import numpy as np
def damp(at):
    square = (at.column('humidity_pct') - 45) ** 2
    return np.tile(square[:, None], 3)
"""


def test_python_reaches_apply_plan_and_export_and_only_the_file_that_was_fitted(
    damp: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    physics = damp.with_name("physics.py")
    physics.write_text(SQUARE, encoding="utf-8")
    config = with_models(damp, "coded", "", "damp")
    text = config.read_text(encoding="utf-8")
    config.write_text(text.replace("expression: (humidity_pct - 45)**2", "python: physics.py:damp"),
                      encoding="utf-8")
    assert pipeline("run", config, "--allow-python") == 0
    results = config.with_suffix(".run")
    stored = results_in(results)["gyroscope"]["correction"]["own_effects"]["damp"]
    assert stored["python"] == "physics.py:damp"
    assert len(stored["python_sha256"]) == 64
    log = damp.parent / "gyroscope" / "17rpm" / "pose_01.csv"

    capsys.readouterr()
    assert pipeline("apply", results, log) == 4
    assert "add --allow-python to the command if you trust physics.py" in capsys.readouterr().err
    assert pipeline("plan", config) == 2
    assert pipeline("plan", config, "--allow-python") == 0
    assert pipeline("export", results, "--to", "kalibr", "--output", results) == 0
    assert "cannot store damp of the gyroscope" in capsys.readouterr().err
    by_python = corrected(results, log, "--allow-python")

    expression = with_models(damp, "expressed", "", "damp")
    assert pipeline("run", expression) == 0
    by_expression = corrected(expression.with_suffix(".run"), log)
    assert by_python["gyr_x_rad_s"] == pytest.approx(by_expression["gyr_x_rad_s"], abs=1e-7)

    physics.write_text(SQUARE + "# changed\n", encoding="utf-8")
    assert pipeline("apply", results, log, "--allow-python") == 3
    assert "is not the file that was fitted" in capsys.readouterr().err
    physics.unlink()
    assert pipeline("apply", results, log, "--allow-python") == 3
    assert "was not found in" in capsys.readouterr().err


def test_a_function_that_fails_is_named_and_no_bug_of_ours(
    damp: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    damp.with_name("physics.py").write_text("def damp(at):\n    return at.wetness\n", "utf-8")
    config = variant(damp, "failing", IN_PYTHON)
    assert pipeline("run", config, "--allow-python") == 0  # no model has it
    assert "the diagnosis of the gyroscope leaves it out" in capsys.readouterr().err
    assert pipeline("add", config, "gyroscope.damp", "--allow-python") == 4
    text = config.read_text(encoding="utf-8")
    head, _, tail = text.rpartition("misalignment]")
    config.write_text(f"{head}misalignment, damp]{tail}", encoding="utf-8")
    assert pipeline("run", config, "--allow-python") == 4
    error = capsys.readouterr().err
    assert "effects.damp: the Python function raised AttributeError" in error


# --- plan ----------------------------------------------------------------------------------------


def test_plan_goes_with_effects_of_logged_columns(
    damp: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = with_models(damp, "planned", "temperature_bias", "temperature_bias, damp")
    assert pipeline("plan", config) == 0
    said = capsys.readouterr().out
    assert "planned without" not in said
    assert said.count("degrees of freedom") == 2
    text = config.read_text(encoding="utf-8").replace("pose_*.csv", "coming_*.csv")
    fresh = damp.with_name("fresh.yaml")
    fresh.write_text(text, encoding="utf-8")
    assert pipeline("plan", fresh) == 0
    assert ("planned without temperature_bias: the column temperature_c is not in the logs that "
            "are there") in capsys.readouterr().out
