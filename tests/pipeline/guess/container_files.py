"""More logs: of reports, monitors, home automation and people's own scripts."""

import base64
import io
import json
import sqlite3
import tarfile
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.pipeline.guess.foreign_files import DEG, Foreign, G
from tests.pipeline.guess.hand_log import HandLog
from tests.pipeline.guess.text_rows import EPOCH_S, counts_of, si_rows, write_lines


def korean(folder: Path, log: HandLog) -> Foreign:
    head = ("시간(초),가속도X(m/s²),가속도Y(m/s²),가속도Z(m/s²),각속도X(deg/s),각속도Y(deg/s),"
            "각속도Z(deg/s)")
    rows = [",".join(row) for row in si_rows(log, 1, 1 / DEG)]
    return Foreign([write_lines(folder / "측정.csv", [head, *rows], "cp949")], 1.0, 1 / DEG)


def increments(folder: Path, log: HandLog) -> Foreign:
    """Delta velocities in m/s and delta angles in rad, as navigation sensors give them."""
    rows = [",".join([f"{t:.3f}", *(f"{v / log.rate_hz:.7f}" for v in (*a, *w))])
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "nav.csv", ["time,dvx,dvy,dvz,dax,day,daz", *rows])],
                   1 / log.rate_hz, 1 / log.rate_hz)


def footer(folder: Path, log: HandLog) -> Foreign:
    """Statistics below the rows."""
    values = np.hstack([log.acc / G, log.gyr / DEG])
    below = [",".join([name, *(f"{v:.5f}" for v in of(values, axis=0))]) for name, of in (
        ("Mean", np.mean), ("Std", np.std), ("Min", np.min), ("Max", np.max))]
    return Foreign([write_lines(folder / "report.csv", [
        "Measurement report", "Sensor: GY-521", "",
        "Time (s),aX (g),aY (g),aZ (g),gX (deg/s),gY (deg/s),gZ (deg/s)",
        *(",".join(row) for row in si_rows(log, 1 / G, 1 / DEG)), "", "Statistics", *below,
        "End of file"])], 1 / G, 1 / DEG)


def headed_blocks(folder: Path, log: HandLog) -> Foreign:
    """`Pose 3` and the header again above each block; times begin again in each.

    Nothing in rests shows the range of a gyroscope.
    """
    out = []
    for k in range(int(log.rest.max()) + 1):
        at = np.flatnonzero(log.rest == k)
        out += [f"Pose {k + 1}", "t_ms\tax\tay\taz\tgx\tgy\tgz",
                *("\t".join(map(str, (round(1000 * (t - log.time_s[at[0]])), *row)))
                  for t, row in zip(log.time_s[at], counts_of(log)[at], strict=True)), ""]
    return Foreign([write_lines(folder / "all_poses.txt", out)], 16384 / G, None)


def ros2_echo(folder: Path, log: HandLog) -> Foreign:
    """`ros2 topic echo /imu`: documents of YAML."""
    def vector(name: str, values: np.ndarray) -> list[str]:
        return [f"{name}:", *(f"  {axis}: {v:.8f}" for axis, v in zip("xyz", values, strict=True)),
                f"{name}_covariance:", *["- 0.0"] * 9]
    out = []
    for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True):
        out += ["header:", "  stamp:", f"    sec: {EPOCH_S + int(t)}",
                f"    nanosec: {round((t % 1) * 1e9)}", "  frame_id: imu_link", "orientation:",
                "  x: 0.0", "  y: 0.0", "  z: 0.0", "  w: 1.0", *vector("angular_velocity", w),
                *vector("linear_acceleration", a), "---"]
    return Foreign([write_lines(folder / "imu.yaml", out)])


def micro_g(folder: Path, log: HandLog) -> Foreign:
    """Whole µg and degrees an hour."""
    rows = [";".join([f"{t:.3f}", *(f"{v:.0f}" for v in (*(a / G * 1e6), *(w / DEG * 3600)))])
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "fog.csv", [
        "t[s];a_x[µg];a_y[µg];a_z[µg];w_x[°/h];w_y[°/h];w_z[°/h]", *rows])], 1e6 / G, 3600 / DEG)


def mqtt(folder: Path, log: HandLog) -> Foreign:
    """`mosquitto_sub -v`: a topic and an object."""
    return Foreign([write_lines(folder / "mqtt.log", ["bench/imu/1 " + json.dumps(
        {"ts": round((EPOCH_S + t) * 1000), "a": np.round(a, 5).tolist(),
         "w": np.round(w, 5).tolist()})
        for t, a, w in zip(log.time_s, log.acc / G, log.gyr / DEG, strict=True)])], 1 / G, 1 / DEG)


def feet(folder: Path, log: HandLog) -> Foreign:
    rows = [",".join(row) for row in si_rows(log, 1 / 0.3048, 1 / DEG)]
    return Foreign([write_lines(folder / "test 4.csv", [
        "Time,Ax (ft/s^2),Ay (ft/s^2),Az (ft/s^2),P (deg/s),Q (deg/s),R (deg/s)", *rows])],
        1 / 0.3048, 1 / DEG)


def nested_header(folder: Path, log: HandLog) -> Foreign:
    """Two levels of columns, as pandas writes them."""
    rows = [",".join(row) for row in si_rows(log, 1 / G, 1 / DEG)]
    return Foreign([write_lines(folder / "multi.csv", [
        ",accel,accel,accel,gyro,gyro,gyro", "time,x,y,z,x,y,z", *rows])], 1 / G, 1 / DEG)


def micropython(folder: Path, log: HandLog) -> Foreign:
    """`print()` of a dictionary, z first."""
    rows = [f"{{'GyZ': {c[5]}, 'GyY': {c[4]}, 'GyX': {c[3]}, 'Temp': {24.5 + i / 9000:.2f}, "
            f"'AcZ': {c[2]}, 'AcY': {c[1]}, 'AcX': {c[0]}}}" for i, c in enumerate(counts_of(log))]
    return Foreign([write_lines(folder / "repl.txt", [
        "MPY: soft reboot", "MPU6050 found at 0x68", *rows])], 16384 / G, 131.072 / DEG,
        log.rate_hz)


def units_inside(folder: Path, log: HandLog) -> Foreign:
    """A row number, columns without names, units before the axis, a comma at the end."""
    rows = [",".join([str(i), row[0], "", *row[1:4], "", *row[4:], ""])
            for i, row in enumerate(si_rows(log, 1000 / G, 1 / DEG))]
    return Foreign([write_lines(folder / "DATA.CSV", [
        "#,T[S],,A[MG]X,A[MG]Y,A[MG]Z,,W[DPS]X,W[DPS]Y,W[DPS]Z,", *rows], end="\r\n")],
        1000 / G, 1 / DEG)


def nine_unnamed(folder: Path, log: HandLog) -> Foreign:
    """No header: a counter, then counts of gyroscope, magnetometer and accelerometer."""
    up = log.acc / np.linalg.norm(log.acc, axis=1, keepdims=True)
    field = np.rint(300 * np.cross(up, [0.2, 0.9, -0.4]) + [40, -90, 15]).astype(int)
    rows = ["\t".join(map(str, (i % 256, *c[3:], *m, *c[:3])))
            for i, (c, m) in enumerate(zip(counts_of(log, 8192.0, 65.536), field, strict=True))]
    return Foreign([write_lines(folder / "dump9.txt", rows)], 8192 / G, 65.536 / DEG, log.rate_hz)


def run_together(folder: Path, log: HandLog) -> Foreign:
    """Columns of ten characters that are full: no blank stands between them."""
    rows = ["".join(f"{v:9.4f}" for v in (t, *(10 * a), *(100 * w / DEG)))
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "run.out", rows)])


def tarball(folder: Path, log: HandLog) -> Foreign:
    path = folder / "poses.tar.gz"
    with tarfile.open(path, "w:gz") as tar:
        data = "\n".join(map(",".join, si_rows(log))).encode()
        info = tarfile.TarInfo("pose_01.csv")
        info.size = len(data)
        tar.addfile(info, io.BytesIO(data))
    return Foreign([path])


def database(folder: Path, log: HandLog) -> Foreign:
    path = folder / "imu.db"
    with sqlite3.connect(path) as base:
        base.execute("create table imu (t real, ax real, ay real, az real)")
        base.executemany("insert into imu values (?, ?, ?, ?)", [row[:4] for row in si_rows(log)])
    return Foreign([path])


def quoted_thousands(folder: Path, log: HandLog) -> Foreign:
    """Counts as a spreadsheet shows them."""
    rows = [",".join([f"{t:.2f}", *(f'"{v:,}"' for v in counts)])
            for t, counts in zip(log.time_s, counts_of(log), strict=True)]
    return Foreign([write_lines(folder / "sheet.csv", ["Seconds,AX,AY,AZ,GX,GY,GZ", *rows])])


def diary(folder: Path, log: HandLog) -> Foreign:
    """A matrix as MATLAB shows it: a factor above few digits."""
    values = np.hstack([log.time_s[:, None], log.acc, log.gyr]) / 1000
    return Foreign([write_lines(folder / "diary.txt", [
        "ans =", "", "   1.0e+03 *", "", *("   ".join(f"{v:10.6f}" for v in row)
                                           for row in values)])])


def letters(folder: Path, log: HandLog) -> Foreign:
    """Samples in base64."""
    counts = np.clip(counts_of(log), -32768, 32767).astype("<i2")
    return Foreign([write_lines(folder / "packets.txt", [
        base64.b64encode(row.tobytes()).decode() for row in counts])])


def can_bus(folder: Path, log: HandLog) -> Foreign:
    """`candump -l`."""
    counts = np.clip(counts_of(log), -32768, 32767).astype(">i2")
    return Foreign([write_lines(folder / "can.log", [
        f"({EPOCH_S + t:.6f}) can0 0{17 + i}#{row[3 * i:3 * i + 3].tobytes().hex().upper()}"
        for t, row in zip(log.time_s, counts, strict=True) for i in range(2)])])


def dmp(folder: Path, log: HandLog) -> Foreign:
    """i2cdevlib's DMP: as many words above the rows as they have numbers, and a word in front."""
    return Foreign([write_lines(folder / "dmp.txt", [
        "Initializing I2C devices...", "DMP ready! Waiting for first interrupt...",
        *("areal\t" + "\t".join(map(str, c[:3])) for c in counts_of(log))])], 16384 / G, None,
        log.rate_hz)


def intervals(folder: Path, log: HandLog) -> Foreign:
    """Microseconds since the sample before."""
    steps = 1e6 / log.rate_hz + np.random.default_rng(1).integers(-40, 40, len(log.time_s))
    rows = [",".join([f"{step:.0f}", *row[1:]])
            for step, row in zip(steps, si_rows(log, 1 / G, 1 / DEG), strict=True)]
    return Foreign([write_lines(folder / "teensy.csv", ["dt_us,ax,ay,az,gx,gy,gz", *rows])],
                   1 / G, 1 / DEG)


def zip_of_poses(folder: Path, log: HandLog) -> Foreign:
    """A file for each rest in an archive, in a folder."""
    path = folder / "session.zip"
    rows = si_rows(log, 1 / G, 1 / DEG)
    with zipfile.ZipFile(path, "w") as archive:
        for k in range(int(log.rest.max()) + 1):
            pose = [",".join(row) for row, i in zip(rows, log.rest, strict=True) if i == k]
            archive.writestr(f"session/pose_{k + 1:02d}.csv", "\n".join([
                "time,accX,accY,accZ,gyroX,gyroY,gyroZ", *pose, ""]))
    return Foreign([path], 1 / G, 1 / DEG)


CONTAINERS: dict[str, Callable[[Path, HandLog], Foreign]] = {
    tool.__name__: tool for tool in (
        korean, increments, footer, headed_blocks, ros2_echo, micro_g, mqtt, feet, nested_header,
        micropython, units_inside, nine_unnamed, dmp, intervals, zip_of_poses)
}
CONTAINERS_REFUSED: dict[str, tuple[Callable[[Path, HandLog], Foreign], str]] = {
    "run_together": (run_together, "two numbers without a blank between them"),
    "tarball": (tarball, "an archive of tar. Unpack it by `tar xf poses.tar.gz`"),
    "database": (database, "a database of SQLite"),
    "quoted_thousands": (quoted_thousands, "may be a decimal comma or separate thousands"),
    "diary": (diary, r"multiplied by 1.0e\+03"),
    "letters": (letters, "base64"),
    "can_bus": (can_bus, "messages of a bus .*cantools decode"),
}
