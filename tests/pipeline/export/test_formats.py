"""``pipeline export``: each format read back corrects a log as the calibration does."""

import csv
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline.export.formats import FORMATS
from pipeline.export.parts import of_gravity, origin
from pipeline.export.write import EXPORTERS
from pipeline.results.read import Stored, load_results
from tests.pipeline.conftest import RunSession
from tests.pipeline.export.stored_results import with_effects
from tests.sessions import pipeline

COUNTS = np.array([[20_000.0, 31_000.0, 45_000.0], [32_768.0, 32_768.0, 32_768.0]])


def corrected(stored: Stored, triad: str) -> np.ndarray:
    """By the calibration itself."""
    (own,) = (each for each in stored.triads if each.name == triad)
    matrix, offset = own.correction.linear_form()
    return own.correction.spec.nominal(COUNTS) @ matrix.T + offset


def test_imu_tk_reads_back_as_the_same_correction(finished: RunSession) -> None:
    stored = load_results(finished.folder)
    files = EXPORTERS["imu_tk"](stored).files
    for triad, name in (("accelerometer", "acc.calib"), ("gyroscope", "gyro.calib")):
        blocks = files[name].strip().split("\n\n")
        t, k, b = (np.loadtxt(block.splitlines(), ndmin=2) for block in blocks)
        assert (t.shape, k.shape, b.shape) == ((3, 3), (3, 3), (3, 1))
        by_export = (COUNTS - b[:, 0]) @ (t @ k).T
        assert by_export == pytest.approx(corrected(stored, triad), rel=1e-9)


def test_json_reads_back_as_the_same_correction(finished: RunSession) -> None:
    stored = load_results(finished.folder)
    found = json.loads(EXPORTERS["json"](stored).files["calibration.json"])
    for triad in ("accelerometer", "gyroscope"):
        matrix, bias = np.array(found[triad]["matrix"]), np.array(found[triad]["bias_counts"])
        assert (COUNTS - bias) @ matrix.T == pytest.approx(corrected(stored, triad), rel=1e-12)
    assert found["gyroscope"]["unit"] == "rad/s"


def test_csv_has_every_parameter_with_its_sd_and_unit(finished: RunSession, tmp_path: Path) -> None:
    stored = with_effects(finished, tmp_path, "accelerometer", {"warm_up": [0.1, 0.2, 0.3]})
    rows = list(csv.DictReader(EXPORTERS["csv"](stored).files["calibration.csv"].splitlines()))
    assert len(rows) == 2 * 9 + 3
    first = rows[0]
    assert (first["triad"], first["parameter"], first["axis"]) == (
        "accelerometer", "misalignment_rad", "x",
    )
    assert float(first["value"]) == stored.triads[0].parameters.misalignment_rad[0]
    assert float(first["sd"]) == stored.triads[0].parameters.sd[0][0]
    assert rows[8]["unit"] == "counts/(m/s²)"
    assert [(row["parameter"], row["axis"], row["value"]) for row in rows[9:12]] == [
        ("warm_up", "x", "0.1"), ("warm_up", "y", "0.2"), ("warm_up", "z", "0.3"),
    ]


def test_csv_says_what_a_value_may_stand_for(finished: RunSession, tmp_path: Path) -> None:
    stored = with_effects(finished, tmp_path, "accelerometer", {"quadratic": [0.1, 0.2, 0.3]})
    effects = stored.triads[0].section.effects
    effects["quadratic"] = effects["quadratic"].model_copy(
        update={"stands_for": ["asymmetry", "cubic"]})
    rows = list(csv.DictReader(EXPORTERS["csv"](stored).files["calibration.csv"].splitlines()))
    told = {row["parameter"]: row["stands_for"] for row in rows}
    assert told.pop("quadratic") == "asymmetry cubic"
    assert not any(told.values())


@pytest.mark.parametrize("form", ["json", "imu_tk"])
def test_an_effect_that_a_format_cannot_hold_is_named(
    finished: RunSession, tmp_path: Path, form: str
) -> None:
    plain = EXPORTERS[form](load_results(finished.folder))
    assert not any("quadratic" in says for says in plain.loses)
    stored = with_effects(finished, tmp_path, "gyroscope", {"quadratic": [0.1, 0.2, 0.3]})
    loses = EXPORTERS[form](stored).loses
    assert any("quadratic" in says and "gyroscope" in says for says in loses)


def test_the_command_writes_the_files_and_says_where(
    finished: RunSession, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("export", finished.folder, "--to", "imu_tk", "--output", tmp_path / "out") == 0
    said = capsys.readouterr()
    written = [tmp_path / "out" / name for name in ("acc.calib", "gyro.calib")]
    assert said.out.splitlines() == [str(path) for path in written]
    assert all(path.exists() for path in written)
    assert said.err.startswith("note: The file does not contain the uncertainties.")


def test_the_help_lists_every_format_that_can_be_written(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert list(FORMATS) == list(EXPORTERS)
    assert pipeline("export", "--help") == 0
    said = capsys.readouterr().out
    assert all(f"{name:<11}  {says}" in said for name, says in FORMATS.items())


def test_a_wrong_format_is_answered_with_the_nearest_and_the_list(
    finished: RunSession, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("export", finished.folder, "--to", "imutk") == 2
    said = capsys.readouterr().err
    assert "no format is named 'imutk' (did you mean 'imu_tk'?); there are: json, csv" in said


def test_no_export_repeats_a_data_sheet_that_the_gain_refutes(finished: RunSession) -> None:
    """The session's results with half the full scale in the configuration."""
    stored = load_results(finished.folder)
    triad = next(one for one in stored.triads if one.name == "accelerometer")
    spec = triad.correction.spec
    halved = replace(spec, full_scale=spec.full_scale / 2)
    refuted = replace(triad, correction=replace(triad.correction, spec=halved))
    before, after = (
        next(line for line in origin(replace(stored, triads=(one,))) if "bits" in line)
        for one in (triad, refuted))
    assert f"over +-{spec.full_scale:.6g} " in before
    by_gain = re.search(r"about \+-([0-9.]+)", after)
    assert by_gain is not None
    assert float(by_gain[1]) == pytest.approx(spec.full_scale, rel=0.3)
    assert f"refutes the +-{halved.full_scale:.6g} of the configuration" in after


@pytest.mark.parametrize(("axis", "notes"), [("acc_x", 0), ("minus_acc_x", 1)])
def test_logs_that_hold_gravity_are_noted(finished: RunSession, axis: str, notes: int) -> None:
    stored = load_results(finished.folder)
    contents = stored.contents.model_copy(update={"columns": [{axis: "userAccelerationX"}]})
    assert len(of_gravity(replace(stored, contents=contents))) == notes
