"""``pipeline fleet`` on one worker and on two: one table, nothing lost, nothing done twice."""

import csv
import json
import os
import shutil
import signal
import sys
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from pipeline.errors import BUG, DONE, UNDETERMINED, UNREADABLE, USAGE
from pipeline.fleet.cluster import connected, run_fleet
from pipeline.fleet.finish import finish_fleet
from pipeline.fleet.record import RECORD_NAME, SessionRecord, folder_of, kept_evidence
from pipeline.fleet.sessions import find_sessions
from pipeline.fleet.worker import FleetTask
from tests.sessions import edit, pipeline, quick_session

FAILURES = {"broken": UNDETERMINED, "empty": UNREADABLE, "misspelt": USAGE}

pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::DeprecationWarning")


@pytest.fixture(scope="module")
def lot(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two evenings of two sensors, and three sessions that fail."""
    folder = tmp_path_factory.mktemp("lot")
    for name, seed in (("a/1", 1), ("a/2", 2), ("b/1", 3), ("b/2", 4)):
        quick_session(folder / name, seed)
    for name in FAILURES:
        shutil.copytree(folder / "a/1", folder / "faulty" / name)
    for pose in (folder / "faulty/broken/accelerometer").glob("pose_0*.csv"):
        pose.unlink()
    (folder / "faulty/empty/accelerometer/pose_03.csv").write_text("", encoding="utf-8")
    edit(folder / "faulty/misspelt/config.yaml", "bias, scale", "bais, scale")
    return folder


def fleet(lot: Path, output: Path) -> int:
    return pipeline("fleet", f"{lot}/{{sensor}}/*/config.yaml", "--output", output,
                    "--workers", "1", "--no-reports")


@pytest.fixture(scope="module")
def table(lot: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a fleet that was run once, by one worker."""
    output = tmp_path_factory.mktemp("once") / "fleet"
    assert fleet(lot, output) == DONE
    return output


def rows_of(output: Path) -> list[dict[str, str]]:
    with (output / "fleet.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_every_session_has_a_row_for_each_triad(table: Path) -> None:
    rows = rows_of(table)
    calibrated = [(r["session"], r["sensor"], r["triad"]) for r in rows if r["exit_code"] == "0"]
    assert calibrated == [(f"{s}/{e}", s, t) for s in "ab" for e in "12"
                          for t in ("accelerometer", "gyroscope")]
    first = json.loads((folder_of(table, "a/1") / "results.json").read_text(encoding="utf-8"))
    scale = first["gyroscope"]["parameters"]["scale_counts_per_unit"]
    assert float(rows[1]["scale_counts_per_unit_y"]) == scale[1]
    assert rows[1]["verdict"] == first["gyroscope"]["diagnosis"]["verdict"]


def test_a_session_that_fails_is_in_the_table_with_its_reason_and_stops_nothing(
    table: Path
) -> None:
    failed = {r["session"].removeprefix("faulty/"): r for r in rows_of(table)
              if r["exit_code"] != "0"}
    assert {name: int(row["exit_code"]) for name, row in failed.items()} == FAILURES
    assert "did you mean 'bias'" in failed["misspelt"]["reason"]
    assert "9 poses" in failed["broken"]["reason"]


def test_parquet_is_the_same_table(table: Path) -> None:
    stored = pq.read_table(table / "fleet.parquet").to_pylist()
    for row, written in zip(rows_of(table), stored, strict=True):
        assert row == {name: "" if each is None else str(each) for name, each in written.items()}


def test_started_again_nothing_is_done_again_but_what_has_changed(
    table: Path, lot: Path, tmp_path: Path
) -> None:
    shutil.copytree(table, tmp_path / "again")
    shutil.copytree(lot, tmp_path / "lot")
    records = list((tmp_path / "again").rglob(RECORD_NAME))
    before = {path: path.stat().st_mtime_ns for path in records}
    edit(tmp_path / "lot/a/2/config.yaml", "title: ", "title: Another ")
    assert fleet(tmp_path / "lot", tmp_path / "again") == DONE
    changed = {path.parent.relative_to(tmp_path / "again/sessions").as_posix()
               for path in records if path.stat().st_mtime_ns != before[path]}
    assert changed == {"a/2", "faulty/misspelt"}  # which is not read further than its mistake
    assert rows_of(tmp_path / "again")[2]["title"].startswith("Another ")


@pytest.fixture(scope="module")
def survived(lot: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a fleet that was run by two workers, of which one was killed."""
    output = tmp_path_factory.mktemp("killed")
    with connected(2) as client:
        tasks = [FleetTask(each, output, False, False)
                 for each in find_sessions(f"{lot}/{{sensor}}/*/config.yaml")]
        records: list[SessionRecord] = []
        victims = list(client.run(os.getpid).values())[:1]

        def kill_once(record: SessionRecord) -> None:
            records.append(record)
            if victims:
                os.kill(victims.pop(), signal.SIGKILL)

        run_fleet(client, tasks, kill_once)
    assert not victims
    finish_fleet(records, output, reports=False)
    return output


def test_a_worker_that_is_killed_loses_nothing(survived: Path, table: Path) -> None:
    assert [row["session"] for row in rows_of(survived)] == [
        row["session"] for row in rows_of(table)]


def test_the_table_is_the_same_whatever_the_number_of_workers(survived: Path, table: Path) -> None:
    for name in ("fleet.csv", "fleet.parquet", "population.json"):
        assert (survived / name).read_bytes() == (table / name).read_bytes()


def test_sessions_without_dates_are_shown_in_their_order(table: Path) -> None:
    lot = json.loads((table / "population.json").read_text(encoding="utf-8"))
    for triad in ("accelerometer", "gyroscope"):
        seen = lot[triad]["over_time"]
        assert {name: one["sessions"] for name, one in seen.items()} == {
            "a": ["a/1", "a/2"], "b": ["b/1", "b/2"]}
        assert all(one["days"] == [None, None] for one in seen.values())
        assert all(one["ageing"] is None for one in seen.values())


def test_the_evidence_of_each_triad_is_kept(table: Path) -> None:
    evidence = kept_evidence(folder_of(table, "b/2") / "evidence_gyroscope.npz")
    assert evidence is not None
    names = {trial.name for trial in evidence.trials}
    assert {"g_sensitivity", "quadratic", "warm_up"} <= names
    assert len(evidence.score) == sum(trial.size for trial in evidence.trials)


def test_a_session_that_shows_a_bug_is_told_and_stops_nothing(
    lot: Path, tmp_path: Path
) -> None:
    sessions = find_sessions(f"{lot}/{{sensor}}/*/config.yaml")[:2]
    tasks = [FleetTask(sessions[0], tmp_path, False, False),
             FleetTask(sessions[1], None, False, False)]  # type: ignore[arg-type]
    records: list[SessionRecord] = []
    with connected(1) as client:
        run_fleet(client, tasks, records.append)
    by_name = {record.name: record for record in records}
    assert by_name["a/1"].exit_code == DONE
    assert by_name["a/2"].exit_code == BUG
    assert "our bug" in by_name["a/2"].reason


@pytest.mark.parametrize(("library", "named"), [
    ("distributed", "Dask"), ("pyarrow", "Parquet"), ("pandas", "pandas")])
def test_a_missing_library_is_named_with_what_installs_it(
    library: str, named: str, lot: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    assert pipeline("fleet", f"{lot}/a/*/config.yaml", "--output", tmp_path / "out") == USAGE
    said = capsys.readouterr().err
    assert named in said
    assert "pip install 'turntable-imu-calibration[fleet]'" in said
    assert not (tmp_path / "out").exists()
