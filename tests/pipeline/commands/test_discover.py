"""``pipeline discover``: a formula of what no listed effect describes, then ``pipeline add``."""

import re
import shlex
from dataclasses import replace
from pathlib import Path

import pytest

from pipeline.cli import main
from pipeline.config.edit import add_entry
from pipeline.config.load import load_config
from pipeline.config.yaml_text import read_source
from tests.paths import REAL
from tests.studies.real_sets.logs import LOGS
from tests.world.designs import rich_design
from tests.world.session import simulate
from tests.world.sizes import draw_effect
from tests.world.write import write_session

pytestmark = pytest.mark.usefixtures("bare_page")


def curved_session(folder: Path) -> Path:
    """A gyroscope at rest and at two speeds, whose bias follows the square of a column."""
    design = rich_design().scaled(seconds=0.3, sample_rate=0.5)
    design = replace(design, runs=tuple(run for run in design.runs if run.name[0] != "m"))
    hidden = draw_effect("column_squared:supply_v", "gyroscope", 30.0, design, 3)
    return write_session(folder, simulate(design, 3, (hidden,)), film=False).config


def test_auto_goes_on_with_a_formula_where_no_listed_effect_fits(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = curved_session(tmp_path)
    assert main(["add", str(config), "--auto"]) == 0
    errors = re.findall(r"^leave-one-out.* ([0-9.]+) +([0-9.]+)$", capsys.readouterr().out,
                        re.MULTILINE)
    assert float(errors[-1][1]) < 0.1 * float(errors[0][0])
    (name,) = load_config(config).effects
    assert "supply_v" in name
    assert name in load_config(config).gyroscope.model


def test_a_hidden_curve_in_a_column_of_any_name_is_found_written_and_added(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = curved_session(tmp_path)
    for log in tmp_path.rglob("*.csv"):
        text = log.read_text(encoding="utf-8")
        log.write_text(text.replace("supply_v", '"U {supply} [V], ö\'s"', 1), encoding="utf-8")
    assert main(["diagnose", str(config)]) == 0
    said = capsys.readouterr().out
    assert "no listed effect explains" in said
    assert "gyroscope: the bias of each axis follows" in said
    assert f"next: pipeline discover {config}\n" in said
    assert main(["discover", str(config), "--write"]) == 0
    said = capsys.readouterr().out
    assert "accelerometer: nothing is missing" in said
    assert "gyroscope: the bias of each axis follows" in said
    (name,) = load_config(config).effects
    assert "U_supply_V_s" in name
    add = shlex.split(said.partition("next: pipeline ")[2])
    assert add == ["add", str(config), f"gyroscope.{name}"]
    assert main(add) == 0
    before, after = map(float, re.findall(r"^leave-one-out.* ([0-9.]+) +([0-9.]+)$",
                                          capsys.readouterr().out, re.MULTILINE)[0])
    assert after < 0.2 * before


def test_a_run_whose_rate_is_another_than_stated_is_said_to_differ(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The rate differs by 0.5 %, less than gravity tells here; a sensitivity to gravity was stated
    for that with large odds."""
    design = rich_design().scaled(seconds=0.3, sample_rate=0.5)
    config = write_session(tmp_path, simulate(design, 3), film=False).config
    rate = load_config(config).rate["m33rpm"].rate_rad_s
    assert rate is not None
    text = config.read_text(encoding="utf-8")
    before, _, of_run = text.partition("m33rpm:")
    of_run = re.sub(r"rate_rad_s: [-0-9.]+", f"rate_rad_s: {1.005 * rate}", of_run, count=1)
    config.write_text(f"{before}m33rpm:{of_run}", encoding="utf-8")
    assert main(["discover", str(config)]) == 0
    said = capsys.readouterr().out
    assert "follows whether a pose is of the run m33rpm" in said
    assert "look for a stated rate that is off and for another clamping first" in said
    assert "s * run('m33rpm')" in said


@pytest.mark.skipif(not REAL.is_dir(), reason=f"no measured logs in {REAL}")
def test_where_no_formula_holds_the_course_of_a_bias_can_be_added(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(LOGS["snu good2"].configuration(), encoding="utf-8")
    add = f"next: pipeline add {config} gyroscope.bias_wander\n"
    assert main(["diagnose", str(config)]) == 0
    said = capsys.readouterr().out
    assert "gyroscope: The bias wanders during the session" in said
    assert said.endswith(add)
    assert main(["discover", str(config)]) == 0
    said = capsys.readouterr().out
    assert "gyroscope: no formula." in said
    assert said.endswith(add)
    assert main(["add", str(config), "gyroscope.bias_wander"]) == 0
    assert re.search(r"^verdict +noise +nothing_missing$", capsys.readouterr().out, re.MULTILINE)
    assert main(["discover", str(config)]) == 0
    said = capsys.readouterr().out
    assert "\nnext: for the accelerometer record poses with " in said
    assert "for the gyroscope record the same poses on the turning plate" in said


@pytest.mark.parametrize("text", [
    "title: one\n", "effects:\n  mine: {expression: x, unit: '1'}\ntitle: one\n",
    "effects: {mine: {expression: x, unit: '1'}}", "title: one\neffects: {}\n",
])
def test_an_effect_is_written_wherever_the_section_stands(text: str, tmp_path: Path) -> None:
    path = tmp_path / "config.yaml"
    path.write_text(text, encoding="utf-8")
    changed = add_entry(read_source(path), "effects", "new", "{expression: y, unit: '{u}'}")
    effects = changed.value(("effects",))
    assert effects["new"] == {"expression": "y", "unit": "{u}"}
    assert ("mine" in effects) == ("mine" in text)
