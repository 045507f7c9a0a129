"""Lines of JSON of several shapes: the tables that they make."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipeline.guess.files import guess_files
from pipeline.logs.formats.json_lines import tables
from tests.pipeline.guess.foreign import write_lines
from tests.pipeline.guess.hand_log import hand_log

SAMPLES = [{"ts": 0.01 * i, "imu": {"acc": [0.1 * i, 0.2, 9.8], "gyro": [1.0, 2.0, 3.0]}}
           for i in range(60)]
TURNS = [part for one in SAMPLES for part in (
    {"ts": one["ts"], "acc": one["imu"]["acc"]}, {"ts": one["ts"], "gyro": one["imu"]["gyro"]})]
Rows = list[dict[str, Any]]


def with_message(message: dict[str, Any], at: int) -> Rows:
    return [*SAMPLES[:at], message, *SAMPLES[at:]]


@pytest.mark.parametrize(("rows", "widths"), [
    (SAMPLES, [7]),
    (with_message({"ts": 0.3, "batt_mv": 3911, "rssi": -60}, 20), [7, 3]),
    (with_message({"device": "esp32", "rate_hz": 100}, 0), [7, 1]),
    (with_message({"event": "start"}, 0), [7]),
    ([one | ({"t_c": 20.5} if i % 9 else {}) for i, one in enumerate(SAMPLES)], [7]),
    (TURNS, [4, 4]),
], ids=["one shape", "a battery", "a head", "a word", "a temperature now and then", "in turn"])
def test_lines_of_another_shape_are_another_table(
    tmp_path: Path, rows: Rows, widths: list[int]
) -> None:
    read = tables(write_lines(tmp_path / "log.jsonl", list(map(json.dumps, rows))))
    assert [len(table.columns) for table in read] == widths
    np.testing.assert_allclose(read[0].columns["ts"], [one["ts"] for one in SAMPLES])


@pytest.mark.parametrize("say", [
    lambda t: {"t": t, "battery": 3.91}, lambda t: {"t": t, "lat": 52.1, "lon": 4.9, "hdop": 1.2}])
def test_the_table_with_the_sensor_is_taken(
    tmp_path: Path, say: Callable[[float], dict[str, Any]]
) -> None:
    log, lines = hand_log(rate_hz=25.0), []
    for i, (time_s, acc, gyr) in enumerate(zip(log.time_s, log.acc, log.gyr, strict=True)):
        lines += [json.dumps({"t": time_s, "acc": acc.tolist(), "gyro": gyr.tolist()})]
        lines += [json.dumps(say(time_s))] if i % 400 == 0 else []
    guesses, passed_over = guess_files([write_lines(tmp_path / "mqtt.jsonl", lines)], None)
    assert [(bool(one.accelerometer), bool(one.gyroscope)) for one in guesses] == [(True, True)]
    assert guesses[0].table.rows == len(log.time_s)
    assert not passed_over


@pytest.mark.parametrize("columns", [["t", "ax", "ay", "az"], None])
def test_poses_of_one_object_are_tables_of_their_own(
    tmp_path: Path, columns: list[str] | None
) -> None:
    """Each pose has its name and its samples; what these are stands beside the list of poses."""
    samples = [[0.01 * i, 0.1, 0.2, 9.8] for i in range(30)]
    rows = samples if columns else [dict(zip(("t", "ax", "ay", "az"), one, strict=True))
                                    for one in samples]
    poses = [{"by": "me", "pose": f"face {i}/6", "samples": rows} for i in range(1, 7)]
    path = tmp_path / "poses.json"
    path.write_text(json.dumps({"columns": columns, "poses": poses}), encoding="utf-8")
    read = tables(path)
    assert [table.name for table in read] == [f"face {i}-6" for i in range(1, 7)]
    assert all([*table.columns] == ["t", "ax", "ay", "az"] for table in read)
    packets = [{"at": 0.1 * i, "id": "a", "acc": rows} for i in range(6)]
    path.write_text(json.dumps(packets), encoding="utf-8")
    assert len(tables(path)) == 1  # of one recording
