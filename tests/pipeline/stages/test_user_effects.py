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
    damp.with_name("physics.py").write_text(
        "from pathlib import Path\nPath(__file__).with_name('ran').touch()\n"
        "def damp(at):\n    return at.vector\n",
        encoding="utf-8",
    )
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


def test_a_column_that_was_not_logged_is_said(
    damp: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = variant(damp, "absent", HEATING.replace("humidity_pct", "pressure_pa"))
    assert pipeline("run", config) == 4
    error = capsys.readouterr().err
    assert "effects.damp: the effect is not a number in 90 of 90 poses" in error


def test_own_effects_that_the_data_cannot_see_are_listed_as_blind(damp: Path) -> None:
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
