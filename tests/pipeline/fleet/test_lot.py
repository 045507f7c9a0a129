"""``pipeline fleet TABLE --design DESIGN``: a lot in one table, against the truth that made it."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet
import pytest

from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.parameters import triad_parameters
from pipeline.cli import main
from pipeline.errors import UnreadableInput
from pipeline.fleet.lot_table import sensor_blocks
from tests.fitting import spec_of
from tests.lot_tables import lot_columns, write_design, write_lot
from tests.lots import pose_sets_of
from tests.world.designs import paper_design
from tests.world.imu import mpu6050
from tests.world.lot import Lot, LotPlan, draw_lot


def accelerometers(count: int, **plan: Any) -> Lot:
    return draw_lot(paper_design(mpu6050()), LotPlan(count, **plan), 1)


def run(folder: Path, lot: Lot, columns: dict[str, Any], name: str = "lot.parquet") -> int:
    write_lot(folder / name, columns)
    write_design(folder / "design.yaml", lot)
    return main(["fleet", str(folder / name), "--design", str(folder / "design.yaml"),
                 "--output", str(folder / "out")])


def population(folder: Path) -> Any:
    return json.loads((folder / "out/population.json").read_text(encoding="utf-8"))


def test_parameters_of_all_sensors_and_what_the_lot_is_missing(tmp_path: Path) -> None:
    lot = accelerometers(120, hidden="cubic", common_sd=0.7)
    assert run(tmp_path, lot, lot_columns(lot)) == 0
    missing = population(tmp_path)["accelerometer"]["missing"]
    assert missing[0]["name"] == "cubic"
    table = pyarrow.parquet.read_table(tmp_path / "out/fleet.parquet")
    assert table.num_rows == 120
    assert 0.8 < np.mean(np.array(table["chi2"]) / np.array(table["dof"])) < 1.4
    spec, sets = spec_of(lot.triad, lot.triad.full_scale), pose_sets_of(lot)
    for k in (0, 57, 119):
        one = fit(sets[k], Model.of(BASE))
        single = triad_parameters(one.model, one.theta, one.cov, spec)
        row = table.slice(k, 1).to_pylist()[0]
        assert row["sensor"] == f"unit_{k:06d}"
        for i, axis in enumerate("xyz"):
            assert row[f"scale_counts_per_unit_{axis}"] == pytest.approx(
                single.scale_counts_per_unit[i], rel=1e-9)
            assert row[f"bias_counts_{axis}"] == pytest.approx(single.bias_counts[i], abs=1e-6)


def test_a_further_effect_of_the_design_has_its_largest_size(tmp_path: Path) -> None:
    lot = accelerometers(4, hidden="cubic", common_sd=20)
    write_lot(tmp_path / "lot.csv", lot_columns(lot))
    write_design(tmp_path / "design.yaml", lot)
    design = (tmp_path / "design.yaml").read_text(encoding="utf-8")
    (tmp_path / "design.yaml").write_text(design.replace("ment]", "ment, cubic]"), encoding="utf-8")
    assert main(["fleet", str(tmp_path / "lot.csv"), "--design", str(tmp_path / "design.yaml"),
                 "--output", str(tmp_path / "out")]) == 0
    rows = pyarrow.parquet.read_table(tmp_path / "out/fleet.parquet").to_pylist()
    for row, poses in zip(rows, pose_sets_of(lot), strict=True):
        theta = fit(poses, Model.of((*BASE, "cubic"))).theta[-3:]
        assert row["size_cubic"] == pytest.approx(max(theta, key=abs), rel=1e-9)
        assert 0 < row["size_sd_cubic"] < abs(row["size_cubic"])


def test_the_stated_sds_are_those_of_the_errors(tmp_path: Path) -> None:
    """Truth: the parameters of the same sensors without noise, which nine numbers fit exactly."""
    lot = accelerometers(150)
    assert run(tmp_path, lot, lot_columns(lot)) == 0
    spec, exact = spec_of(lot.triad, lot.triad.full_scale), replace(lot, counts=lot.true_counts)
    rows = pyarrow.parquet.read_table(tmp_path / "out/fleet.parquet").to_pylist()
    off = []
    for row, poses in zip(rows, pose_sets_of(exact), strict=True):
        true = fit(poses, Model.of(BASE))
        assert true.chi2 < 1e-9
        value = triad_parameters(true.model, true.theta, true.cov, spec)
        for key in ("misalignment_rad", "bias_counts", "scale_counts_per_unit"):
            off += [(row[f"{key}_{axis}"] - getattr(value, key)[i]) / row[f"{key}_{axis}_sd"]
                    for i, axis in enumerate("xyz")]
    assert abs(np.mean(off)) < 0.1
    assert 0.93 < np.std(off) < 1.07  # 1350 of them
    assert population(tmp_path)["accelerometer"]["missing"] == []


def test_csv_is_parquet(tmp_path: Path) -> None:
    lot = accelerometers(12)
    for folder, name in ((tmp_path / "a", "lot.parquet"), (tmp_path / "b", "lot.csv")):
        folder.mkdir()
        assert run(folder, lot, lot_columns(lot), name) == 0
    first, second = (pyarrow.parquet.read_table(tmp_path / each / "out/fleet.parquet")
                     for each in "ab")
    assert first.equals(second)
    table = tmp_path / "b/lot.csv"
    text = table.read_text(encoding="utf-8")
    table.write_text(text.replace(",", ";").replace(".", ","), encoding="utf-8")
    assert main(["fleet", str(table), "--design", str(tmp_path / "b/design.yaml"),
                 "--output", str(tmp_path / "c/out")]) == 0
    assert first.equals(pyarrow.parquet.read_table(tmp_path / "c/out/fleet.parquet"))


def test_a_station_that_is_wrong_shows_between_stations(tmp_path: Path) -> None:
    """A plate that states 3 % too little: all gains measured there come out 3 % too large."""
    lot = accelerometers(120)
    columns = lot_columns(lot)
    sensor = np.repeat(np.arange(120), 18)
    columns["station"] = np.array(["north", "south", "west"])[sensor % 3]
    wrong = columns["station"] == "west"
    for axis in "xyz":
        columns[f"acc_{axis}"] = columns[f"acc_{axis}"] * np.where(wrong, 1.03, 1.0)
    assert run(tmp_path, lot, columns) == 0
    stations = population(tmp_path)["accelerometer"]["stations"]
    assert stations["p_same"] < 1e-3
    off = {name: each["value"] for name, each in stations["gain_off"].items()}
    sd = stations["gain_off"]["west"]["sd"]
    assert off["west"] - (off["north"] + off["south"]) / 2 == pytest.approx(0.03, abs=4 * sd)


def test_a_sensor_without_enough_poses_leaves_the_others_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lot = accelerometers(10)
    columns = {name: np.delete(values, np.arange(18 * 3 + 8, 18 * 4))
               for name, values in lot_columns(lot).items()}
    assert run(tmp_path, lot, columns) == 0
    words = " ".join(capsys.readouterr().out.split())
    assert "10 sensors: 9 calibrated" in words
    assert "unit_000003: accelerometer: 8 poses give 8 equations for 9 parameters" in words
    rows = pyarrow.parquet.read_table(tmp_path / "out/fleet.parquet").to_pylist()
    refused = next(row for row in rows if row["sensor"] == "unit_000003")
    assert refused["exit_code"] == 4
    assert "8 poses give 8 equations for 9 parameters" in refused["reason"]


@pytest.mark.parametrize(("spoil", "said"), [
    (lambda c: {name: values for name, values in c.items() if name != "sd_acc_y"},
     "no column sd_acc_y"),
    (lambda c: {name: np.roll(values, 9) for name, values in c.items()}, "do not stand together"),
    (lambda c: c | {"acc_x": np.where(np.arange(180) == 40, np.nan, c["acc_x"])},
     "sensor unit_000002, pose_05: column acc_x: found nan"),
    (lambda c: c | {"sd_acc_x": np.zeros(180)}, "a positive number is expected"),
    (lambda c: c | {"station": np.tile(["north", "south"], 90)}, "of the stations north, south"),
    (lambda c: {name: values[:0] for name, values in c.items()}, "has no row"),
    (lambda c: c | {"sensor": np.full(180, " ")}, "has no name in its column `sensor`"),
], ids=["a column is absent", "not sorted", "not a number", "an sd of nothing", "two stations",
        "empty", "nameless"])
def test_a_spoilt_table_is_refused(
    spoil: Any, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lot = accelerometers(10)
    assert run(tmp_path, lot, spoil(lot_columns(lot))) == 3
    assert said in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "out/fleet.parquet").exists()


def test_a_design_names_no_poses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """They would take the place of the table's."""
    lot = accelerometers(2)
    write_lot(tmp_path / "lot.csv", lot_columns(lot))
    write_design(tmp_path / "design.yaml", lot)
    with (tmp_path / "design.yaml").open("a", encoding="utf-8") as design:
        design.write("  poses: rest/*.csv\n")
    assert main(["fleet", str(tmp_path / "lot.csv"), "--design", str(tmp_path / "design.yaml"),
                 "--output", str(tmp_path / "out")]) == 2
    assert "design.yaml:7: accelerometer.poses: a design has no poses" in " ".join(
        capsys.readouterr().err.split())


def test_of_several_settings_the_table_says_which(tmp_path: Path) -> None:
    """Else the poses on the turning plate would count as poses at rest."""
    columns = {name: values for name, values in lot_columns(accelerometers(2)).items()
               if name != "run"}
    write_lot(tmp_path / "lot.csv", columns)
    with pytest.raises(UnreadableInput, match="no column run"):
        next(sensor_blocks(tmp_path / "lot.csv", ["acc_x"], {"stopped", "33rpm"}))
    block = next(sensor_blocks(tmp_path / "lot.csv", ["acc_x"], {"33rpm"}))
    assert block[0].run == ("33rpm",) * 18


@pytest.mark.parametrize(("factor", "reason"), [
    (0.0, "reads 0 m/s²"), (9.0, "counts run from"), (1.6, None)])
@pytest.mark.parametrize("spoilt", [0, 3])
def test_each_sensor_of_a_lot_is_checked_as_in_a_session(
    tmp_path: Path, spoilt: int, factor: float, reason: str | None,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Beyond the converter or far from gravity one is refused alone; a wrong gain is told."""
    lot = accelerometers(6)
    columns = lot_columns(lot)
    for axis in "xyz":
        columns[f"acc_{axis}"][18 * spoilt : 18 * (spoilt + 1)] *= factor
    assert run(tmp_path, lot, columns) == 0
    rows = pyarrow.parquet.read_table(tmp_path / "out/fleet.parquet").to_pylist()
    refused = [row for row in rows if row["exit_code"]]
    told = f"1 sensor (unit_{spoilt:06d} first) with a gain more than 30 % off the data sheet's"
    assert (told in capsys.readouterr().out) == (reason is None)
    assert [row["sensor"] for row in refused] == [f"unit_{spoilt:06d}"] * (reason is not None)
    assert all(reason in row["reason"] for row in refused)


def test_a_lot_of_refused_sensors_is_a_table_of_reasons(tmp_path: Path) -> None:
    lot = accelerometers(1)
    few = {name: values[:5] for name, values in lot_columns(lot).items()}
    assert run(tmp_path, lot, few) == 4
    assert "5 poses give" in pyarrow.parquet.read_table(
        tmp_path / "out/fleet.parquet").to_pylist()[0]["reason"]
