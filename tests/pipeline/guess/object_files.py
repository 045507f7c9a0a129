"""Recordings in JSON and in the archives of telephones."""

import json
import zipfile
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from tests.pipeline.guess.foreign import (
    AXES,
    DEG,
    EPOCH_S,
    Foreign,
    G,
    Values,
    Writer,
    comma,
    json_of,
    rows,
    samples,
)
from tests.pipeline.guess.hand_log import HandLog

NAMES = ("t", *AXES.split(","))
Array = np.ndarray


def axes(row: Array) -> dict[str, float]:
    """x, y and z by their names."""
    return dict(zip("xyz", row.tolist(), strict=True))


def sensor_logger(
    name: str, tables: Callable[[Array, Array, Array], dict[str, Array]], acc: float = 1.0,
) -> Writer:
    """The archive of Sensor Logger: axes in the order z, y, x; times are nanoseconds since 1970.

    ``tables`` are made of the accelerometer, of gravity in it, and of the gyroscope.
    """
    def write(folder: Path, log: HandLog) -> Foreign:
        gravity = G * log.acc / np.linalg.norm(log.acc, axis=1, keepdims=True)
        with zipfile.ZipFile(folder / name, "w") as archive:
            for table, values in tables(log.acc, gravity, log.gyr).items():
                archive.writestr(f"{table}.csv", "\n".join(["time,seconds_elapsed,z,y,x", *(
                    f"{EPOCH_S * 10**9 + round(t * 1e9)},{t:.7f},{Values(row[::-1]):,.7g}"
                    for t, row in zip(log.time_s, values, strict=True))]))
            archive.writestr("Metadata.csv", "version,device name\n3,iPhone\n")
        return Foreign([folder / name], acc)

    return write


def phyphox(
    name: str, heads: dict[str, str], between: str, changed: Callable[[str], str], beside: str,
) -> Writer:
    """The archive of phyphox: a table for each sensor, and what it says of itself."""
    def write(folder: Path, log: HandLog) -> Foreign:
        with zipfile.ZipFile(folder / name, "w") as archive:
            for (table, head), values in zip(heads.items(), (log.acc, log.gyr), strict=True):
                archive.writestr(f"{table}.csv", "\n".join([head, *(
                    changed(between.join(f"{v:.9E}" for v in (t, *row)))
                    for t, row in zip(log.time_s, values, strict=True))]))
            archive.writestr("meta/time.csv", beside)
        return Foreign([folder / name])

    return write


def packets_deep_inside(log: HandLog) -> object:
    """Movesense: four samples in an object of each row, with one time."""
    return {"data": [{"Body": {"Timestamp": round(1000 * log.time_s[i])} | {
        name: list(map(axes, values[i : i + 4].round(4)))
        for name, values in (("ArrayAcc", log.acc), ("ArrayGyro", log.gyr / DEG))}, "Method": "PUT"}
        for i in range(0, len(log.time_s) - 3, 4)]}


def rare_kinds(lines: list[str]) -> None:
    """Now and then an object of another class, with keys of its own."""
    other = json.dumps({"class": "TPV", "mode": 3, "lat": 48.1, "lon": 11.5})
    lines[::25] = [other for _ in lines[::25]]


OBJECTS: dict[str, Writer] = {
    "json_lines": rows("imu.jsonl", "", lambda s: json.dumps(
        {"ts": round(s.t * 1e3), "accel": s.a, "gyro": dict(zip("xyz", s.w, strict=True))})),
    # one array of objects, times as ISO 8601
    "nested_json": json_of("web.json", lambda log: [
        {"timestamp": datetime.fromtimestamp(EPOCH_S + t, UTC).isoformat(),
         "accelerometer": axes(a), "gyroscope": axes(w)}
        for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]),
    # events of a web page: the acceleration without gravity first; alpha is about x
    "browser": json_of("motion.json", lambda log: [
        {"timeStamp": round(t * 1000 + 5123.4, 1), "acceleration": {"x": 0.0, "y": 0.01, "z": 0.0},
         "accelerationIncludingGravity": dict(zip("xyz", map(str, a), strict=True)),
         "rotationRate": dict(zip(("alpha", "beta", "gamma"), w, strict=True))}
        for t, a, w in zip(log.time_s, log.acc, log.gyr / DEG, strict=True)], gyr=1 / DEG),
    # an object that holds the list of samples among other things
    "wrapped_json": json_of("export.json", lambda log: {
        "device": "phone", "tags": [1, 2], "samples": [
            {"t": s.t, "a": s.a, "g": s.w} for s in samples(log)]}),
    "columns_of_json": json_of("columns.json", lambda log: dict(zip(("time", *NAMES[1:]), np.hstack(
        [log.time_s[:, None], log.acc, log.gyr]).T.tolist(), strict=True)), indent=1),
    # Edge Impulse: rows of numbers deep in an object, whose names stand beside them
    "vectors_under_names": json_of("idle.1.json", lambda log: {"signature": "0", "payload": {
        "interval_ms": 1000 / log.rate_hz, "sensors": [
            {"name": f"{name}{axis}", "units": unit}
            for name, unit in (("acc", "m/s2"), ("gyr", "dps")) for axis in "XYZ"],
        "values": np.hstack([log.acc, log.gyr / DEG]).round(4).tolist()}}, gyr=1 / DEG),
    "packets_deep_inside": json_of("imu6_stream.json", packets_deep_inside, gyr=1 / DEG),
    # a spreadsheet's table in JSON: rows of quoted cells, the names in the first of them
    "names_in_the_first_row": json_of("sheet.json", lambda log: {"range": "Log!A1:G", "values": [
        ["t_s", *NAMES[1:]], *(s.cells for s in samples(log))]}),
    # messages of MQTT: the payload is JSON in a text of JSON
    "json_in_a_string": rows("mqtt.ndjson", "", lambda s: json.dumps(
        {"topic": "imu/1", "t_s": s.t, "payload": json.dumps({"acc": s.a, "gyro": s.w})})),
    # `mosquitto_sub -v`: a topic and an object
    "mqtt": rows("mqtt.log", "", lambda s: "bench/imu/1 " + json.dumps(
        {"ts": round((EPOCH_S + s.t) * 1000), "a": np.round(s.a, 5).tolist(),
         "w": np.round(s.w, 5).tolist()}), 1 / G, 1 / DEG),
    # gpsd
    "rare_kinds_of_objects": rows("gpsd.json", "", lambda s: json.dumps({"class": "ATT"} | dict(zip(
        ("t", "acc_x", "acc_y", "acc_z", "gyro_x", "gyro_y", "gyro_z"), map(float, s.cells),
        strict=True))), change=rare_kinds),
    # `to_json(orient="split")`: the numbers of the rows are a list too, and as long
    "split_of_pandas": json_of("split.json", lambda log: {
        "columns": NAMES, "index": [*range(len(log.time_s))],
        "data": [[*map(float, s.cells)] for s in samples(log)]}),
    # `to_json()`: each value under the number of its row
    "columns_of_pandas": json_of("columns.json", lambda log: {
        name: {str(i): float(v) for i, v in enumerate(column)} for name, column in zip(
            NAMES, zip(*(s.cells for s in samples(log)), strict=True), strict=True)}),
    "phyphox": phyphox("phone.zip", {
        name: ",".join(['"Time (s)"', *(f'"{words} {axis} ({unit})"' for axis in "xyz")])
        for name, words, unit in (("Accelerometer", "Acceleration", "m/s^2"),
                                  ("Gyroscope", "Gyroscope", "rad/s"))}, ",", str,
        '"property","value"\n"deviceModel","Pixel"\n'),
    # semicolons, decimal commas, and names in German
    "phyphox_german": phyphox("phyphox 2024-03-11.zip", {
        name: ";".join(['"Zeit (s)"', *(f'"{name} {axis} ({unit})"' for axis in "xyz")])
        for name, unit in (("Beschleunigung", "m/s^2"), ("Gyroskop", "rad/s"))}, ";", comma,
        '"event";"experiment time";"system time"\n"START";0,000000000E0;1,710147E9\n'),
    "sensor_logger": sensor_logger("recording.zip", lambda acc, _, gyr: {
        "TotalAcceleration": acc, "Gyroscope": gyr}),
    # what the app computes stands beside the readings: gravity, and what is left without it
    "sensor_logger_uncalibrated": sensor_logger("2024-03-11.zip", lambda acc, gravity, gyr: {
        "TotalAcceleration": acc, "Gyroscope": gyr, "Accelerometer": acc - gravity,
        "Gravity": gravity, "Orientation": gyr}),
    # one recording twice, both in m/s²
    "sensor_logger_android": sensor_logger("android.zip", lambda acc, _, gyr: {
        "TotalAcceleration": acc * 1.001, "AccelerometerUncalibrated": acc, "Gyroscope": gyr,
        "GyroscopeUncalibrated": gyr}),
    # one recording twice, the raw one in g and with Apple's sign
    "sensor_logger_ios": sensor_logger("ios.zip", lambda acc, _, gyr: {
        "AccelerometerUncalibrated": -acc / G, "TotalAcceleration": acc, "Gyroscope": gyr}),
}
