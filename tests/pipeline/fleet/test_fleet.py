"""``pipeline fleet`` on one worker and on two: one table, nothing lost, nothing done twice."""

import csv
import json
import os
import shutil
import signal
import socket
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from distributed import Client, LocalCluster

from pipeline.errors import BUG, DEVICE, DONE, UNDETERMINED, UNREADABLE, USAGE
from pipeline.fleet.cluster import connected, run_fleet
from pipeline.fleet.finish import finish_fleet
from pipeline.fleet.sessions import (
    RECORD_NAME,
    SessionRecord,
    find_sessions,
    folder_of,
    kept_evidence,
)
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


@pytest.fixture(scope="module")
def cluster() -> Iterator[LocalCluster]:
    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=":0") as started:
        yield started


def fleet(lot: Path, output: Path, cluster: LocalCluster, *options: str) -> int:
    return pipeline("fleet", f"{lot}/{{sensor}}/*/config.yaml", "--output", output,
                    "--scheduler", cluster.scheduler_address, "--no-reports", *options)


@pytest.fixture(scope="module")
def table(lot: Path, cluster: LocalCluster, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a fleet that was run once, by the one worker of a cluster elsewhere."""
    output = tmp_path_factory.mktemp("once") / "fleet"
    assert fleet(lot, output, cluster) == DONE
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


def test_a_fleet_of_which_nothing_is_calibrated_fails(
    lot: Path, cluster: LocalCluster, tmp_path: Path
) -> None:
    """With the exit code of all sessions, or of different ones with that of undetermined data."""
    for name, expected in (("empty", UNREADABLE), ("*", UNDETERMINED)):
        assert pipeline("fleet", f"{lot}/faulty/{name}/config.yaml", "--output", tmp_path / "out",
                        "--scheduler", cluster.scheduler_address, "--no-reports") == expected


def test_parquet_is_the_same_table(table: Path) -> None:
    stored = pq.read_table(table / "fleet.parquet").to_pylist()
    for row, written in zip(rows_of(table), stored, strict=True):
        assert row == {name: "" if each is None else str(each) for name, each in written.items()}


def test_started_again_nothing_is_done_again_but_what_has_changed(
    table: Path, lot: Path, cluster: LocalCluster, tmp_path: Path
) -> None:
    shutil.copytree(table, tmp_path / "again")
    shutil.copytree(lot, tmp_path / "lot")
    records = list((tmp_path / "again").rglob(RECORD_NAME))
    before = {path: path.stat().st_mtime_ns for path in records}
    edit(tmp_path / "lot/a/2/config.yaml", "title: ", "title: Another ")
    assert fleet(tmp_path / "lot", tmp_path / "again", cluster) == DONE
    changed = {path.parent.relative_to(tmp_path / "again/sessions").as_posix()
               for path in records if path.stat().st_mtime_ns != before[path]}
    assert changed == {"a/2", "faulty/misspelt"}  # which is not read further than its mistake
    assert rows_of(tmp_path / "again")[2]["title"].startswith("Another ")


@pytest.fixture(scope="module")
def survived(lot: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a fleet that was run by two workers, of which one was killed."""
    output = tmp_path_factory.mktemp("killed")
    with connected(None, 2) as client:
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
    lot: Path, cluster: LocalCluster, tmp_path: Path
) -> None:
    sessions = find_sessions(f"{lot}/{{sensor}}/*/config.yaml")[:2]
    tasks = [FleetTask(sessions[0], tmp_path, False, False),
             FleetTask(sessions[1], None, False, False)]  # type: ignore[arg-type]
    records: list[SessionRecord] = []
    with Client(cluster.scheduler_address) as client:
        run_fleet(client, tasks, records.append)
    by_name = {record.name: record for record in records}
    assert by_name["a/1"].exit_code == DONE
    assert by_name["a/2"].exit_code == BUG
    assert "our bug" in by_name["a/2"].reason


def test_a_scheduler_that_does_not_answer_is_told_at_once(
    lot: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("pipeline.fleet.cluster.ANSWER_S", 0.2)
    begun = time.monotonic()
    assert pipeline("fleet", f"{lot}/a/*/config.yaml", "--output", tmp_path / "out",
                    "--scheduler", "tcp://127.0.0.1:9") == DEVICE
    assert time.monotonic() - begun < 30
    assert "no Dask scheduler answers there" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_what_accepts_and_is_silent_is_no_scheduler(
    lot: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pipeline.fleet.cluster.ANSWER_S", 0.2)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        begun = time.monotonic()
        assert pipeline("fleet", f"{lot}/a/*/config.yaml", "--output", tmp_path / "out",
                        "--scheduler", f"127.0.0.1:{silent.getsockname()[1]}") == DEVICE
    assert time.monotonic() - begun < 20


@pytest.mark.parametrize("address", ["nonsense://x", "tls://127.0.0.1:9", "ucx://127.0.0.1:9"])
def test_an_address_that_is_none_is_a_mistake_of_usage(
    lot: Path, tmp_path: Path, address: str
) -> None:
    assert pipeline("fleet", f"{lot}/a/*/config.yaml", "--output", tmp_path / "out",
                    "--scheduler", address) == USAGE


def test_workers_and_a_scheduler_exclude_each_other(lot: Path, tmp_path: Path) -> None:
    assert pipeline("fleet", f"{lot}/a/*/config.yaml", "--output", tmp_path, "--workers", "2",
                    "--scheduler", "tcp://127.0.0.1:9") == USAGE


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
