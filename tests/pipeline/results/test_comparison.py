"""Sessions side by side: the same sensor agrees, a changed one is told, models of one session are
not measured by their sds.
"""

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipeline.results.comparison import compare_calibrations
from pipeline.results.read import load_results
from tests.sessions import edit, pipeline, quick_session, run_without_page
from tests.world.designs import paper_design
from tests.world.session import simulate
from tests.world.write import write_session

MOVED_COUNTS = 40.0  #: about 80 sds of a bias in these sessions


@pytest.fixture(scope="module")
def sessions(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two evenings of one sensor, one after its bias has moved, and the first with a cubic term."""
    folder = tmp_path_factory.mktemp("sessions")
    for name, seed in (("first", 1), ("second", 2)):
        run_without_page(quick_session(folder / name, seed)[0])
    design = paper_design().scaled(seconds=0.5)
    accelerometer = design.sensor.accelerometer
    offset = accelerometer.offset + np.array([0.0, MOVED_COUNTS, 0.0])
    moved = replace(design, sensor=replace(
        design.sensor, accelerometer=replace(accelerometer, offset=offset)))
    written = write_session(folder / "moved", simulate(moved, 3), film=False)
    run_without_page(written.config)
    shutil.copytree(folder / "first", folder / "cubic")
    edit(folder / "cubic" / "config.yaml", "model: [bias, scale, misalignment]",
         "model: [bias, scale, misalignment, cubic]")
    run_without_page(folder / "cubic" / "config.yaml")
    return folder


def run_of(folder: Path) -> Path:
    return folder / "config.run"


def test_sessions_of_one_sensor_agree(
    sessions: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("compare", sessions / "first" / "config.yaml",
                    run_of(sessions / "second") / "results.json") == 0
    out = capsys.readouterr().out
    assert "accelerometer: first and second agree" in out
    assert "gyroscope: first and second agree" in out


def test_a_folder_stands_for_the_run_of_the_configuration_in_it(
    sessions: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("compare", sessions / "first", sessions / "second") == 0
    by_folder = capsys.readouterr().out
    assert pipeline("compare", run_of(sessions / "first"), run_of(sessions / "second")) == 0
    assert capsys.readouterr().out == by_folder
    assert pipeline("compare", sessions / "first", sessions / "second", "--limit",
                    "accelerometer=50") == 0  # recorded minutes apart
    assert "accelerometer: when it passes the limit is not known" in capsys.readouterr().out
    for name in ("first", "first/config.yaml", "first/config.run/results.json"):
        assert pipeline("export", sessions / name, "--to", "json", "--output", tmp_path,
                        "--force") == 0


def test_each_calibration_errs_more_on_the_poses_of_the_other_session(sessions: Path) -> None:
    results = [load_results(run_of(sessions / name)) for name in ("first", "second")]
    for each in compare_calibrations(results):
        errors = each.error_on_poses
        own = np.array([one.section.residual_rms for one in each.stored if one])
        assert np.diag(errors) == pytest.approx(own, rel=1e-6)
        left_out = max(one.section.loo_rms for one in each.stored if one)
        assert (errors[[0, 1], [1, 0]] > own.max()).all()
        assert errors.max() < 1.5 * left_out


def test_a_sensor_that_has_changed_is_told_with_the_parameter(
    sessions: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("compare", sessions / "first" / "config.yaml",
                    sessions / "moved" / "config.yaml") == 0
    assert "accelerometer: first and moved differ: bias y by" in capsys.readouterr().out
    first, moved = (load_results(run_of(sessions / name)) for name in ("first", "moved"))
    accelerometer = compare_calibrations([first, moved])[0]
    (bias,) = [each for each in accelerometer.parameters if each.name == "bias y"]
    assert bias.values[1] - bias.values[0] == pytest.approx(MOVED_COUNTS, abs=3.0)
    # 40 counts are 0.07 m/s².
    assert accelerometer.error_on_poses[0][1] == pytest.approx(
        MOVED_COUNTS / first.triads[0].parameters.scale_counts_per_unit[1] / np.sqrt(3), rel=0.2)


def test_models_of_one_session_are_not_measured_by_their_sds(
    sessions: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("compare", sessions / "first" / "config.yaml",
                    sessions / "cubic" / "config.yaml") == 0
    out = capsys.readouterr().out
    assert "first and cubic are of the same poses" in out
    rows = [line.split("]")[1].split() for line in out.splitlines() if line.startswith("  cubic x")]
    assert len(rows) == 2  # of both triads
    for first, _, plus_minus, *_ in rows:
        assert (first, plus_minus) == ("-", "±")


def test_a_program_reads_the_same(sessions: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = [run_of(sessions / name) for name in ("first", "second", "moved")]
    assert pipeline("compare", *names, "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["results"] == [str(name / "results.json") for name in names]
    triad = told["accelerometer"]
    assert triad["same_poses"] == [True, False, False]
    by_name = {each["name"]: each for each in triad["parameters"]}
    stored = json.loads((names[1] / "results.json").read_text())["accelerometer"]
    assert by_name["scale z"]["values"][1] == stored["parameters"]["scale_counts_per_unit"][2]
    value, sd = by_name["bias y"]["values"], by_name["bias y"]["sd"]
    assert by_name["bias y"]["apart_sd"][2] == pytest.approx(
        (value[2] - value[0]) / np.hypot(sd[0], sd[2]))
    assert [len(row) for row in triad["error_on_poses"]] == [3, 3, 3]


def altered(folder: Path, to: Path, change: Callable[[dict[str, Any]], None]) -> Path:
    """A copy of results in which one thing differs."""
    contents = json.loads((run_of(folder) / "results.json").read_text())
    change(contents)
    to.mkdir()
    (to / "results.json").write_text(json.dumps(contents))
    return to


def test_counts_of_another_data_sheet_are_not_compared(
    sessions: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def without_gyroscope(contents: dict[str, Any]) -> None:
        contents["gyroscope"] = None

    of_table = quick_session(tmp_path / "wide", 4)[0]
    edit(of_table, "full_scale_m_s2: 50", "full_scale_m_s2: 100")
    run_without_page(of_table)
    one = altered(sessions / "first", tmp_path / "one", without_gyroscope)
    assert pipeline("compare", one, of_table) == 0
    out = capsys.readouterr().out
    assert "have other data sheets" in out
    assert "gyroscope" not in out
    assert "error on the poses of one" in out
    apart = {each.name: each.apart_sd[1] for each in compare_calibrations(
        [load_results(one), load_results(of_table.with_suffix(".run"))])[0].parameters}
    assert np.isnan(apart["bias x"])
    assert apart["misalignment x"] is not None


def test_what_cannot_be_compared_is_refused(
    sessions: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first = run_of(sessions / "first")
    assert pipeline("compare", first) == 2
    assert "name two sessions or more" in capsys.readouterr().err
    assert pipeline("compare", first, tmp_path / "nowhere") == 2
    assert "there is no" in capsys.readouterr().err
    config = quick_session(tmp_path / "not run", 5)[0]
    assert pipeline("compare", first, config) == 2
    assert "Type: pipeline run" in capsys.readouterr().err
