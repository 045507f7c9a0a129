"""Files of which no calibration can come, each with the sentence that says why."""

import base64
import io
import sqlite3
import tarfile
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
    counts_of,
    json_of,
    means_of,
    rows,
    samples,
    write_lines,
)
from tests.pipeline.guess.hand_log import HandLog
from tests.pipeline.guess.object_files import sensor_logger

PER_COUNT = {"acc": 16384 / G, "gyr": 131.072 / DEG}


def words_of(values: Values, order: str) -> bytes:
    """Sixteen-bit words."""
    return np.array(values).astype(f"{order}i2").tobytes()


def gravity_removed(folder: Path, log: HandLog) -> Foreign:
    """The teapot's sketch: counts of an acceleration that nothing names."""
    up = G * log.acc / np.linalg.norm(log.acc, axis=1, keepdims=True)
    at_rest = log.rest[:, None] >= 0
    force = np.where(at_rest, 0.02 * (log.acc - up), log.acc - up) + np.array([0.2, -0.1, 0.3])
    return Foreign([write_lines(folder / "teapot.txt", [
        "\t".join(["areal", *map(str, row)]) for row in np.rint(force * 835).astype(int)])])


def gravity_removed_beside_a_gyroscope(folder: Path, log: HandLog) -> Foreign:
    """A bias of 0.65 m/s² left is nearer to 1 g in g than to gravity in m/s²."""
    up = G * log.acc / np.linalg.norm(log.acc, axis=1, keepdims=True)
    moves = 0.02 * (log.acc - up) + np.where(log.rest[:, None] < 0, np.sin(9 * log.gyr), 0.0)
    force = moves + np.array([0.4, -0.2, 0.5])
    table = np.column_stack([log.time_s, force, log.gyr])
    return Foreign([write_lines(folder / "linear.csv", ["t,ax,ay,az,gx,gy,gz", *(
        ",".join(f"{v:.4f}" for v in row) for row in table)])])


def transposed(folder: Path, log: HandLog) -> Foreign:
    """A row for each channel."""
    columns = zip(*(each.cells for each in samples(log)), strict=True)
    return Foreign([write_lines(folder / "channels.csv", [
        ",".join([name, *cells])
        for name, cells in zip(f"time,{AXES}".split(","), columns, strict=True)])])


def poses_side_by_side(folder: Path, log: HandLog) -> Foreign:
    """A pose in each column, in a code page, with units in its row names."""
    return Foreign([write_lines(folder / "poses.csv", [
        ";".join(["", *(f"Lage {i + 1}" for i in range(18))]), *(
            f"a{axis} [m/s²];{Values(row):;.4f}"
            for axis, row in zip("xyz", np.transpose(means_of(log)), strict=True))], "cp1252")])


def other_order(folder: Path, log: HandLog) -> Foreign:
    """A file that was continued with other columns."""
    every = samples(log)
    return Foreign([write_lines(folder / "appended.csv", [
        f"t,{AXES}", *(each.s for each in every[:1000]), "t,gx,gy,gz,ax,ay,az",
        *(f"{each.t:.3f},{each.w:,.6f},{each.a:,.6f}" for each in every[1000:])])])


def an_axis_a_file(folder: Path, log: HandLog) -> Foreign:
    """Arduino Cloud: a file with times and values for each variable."""
    return Foreign([write_lines(folder / f"acc_{axis}.csv", ["time,value", *(
        f"{t:.3f},{v:.5f}" for t, v in zip(log.time_s, values, strict=True))])
        for axis, values in zip("xyz", log.acc.T, strict=True)])


def axes_apart(folder: Path, log: HandLog) -> Foreign:
    return Foreign([write_lines(folder / f"{axis} 1.txt", [f"{v:.5f}" for v in values])
                    for axis, values in zip("xyz", log.acc.T, strict=True)])


def tarball(folder: Path, log: HandLog) -> Foreign:
    path = folder / "poses.tar.gz"
    with tarfile.open(path, "w:gz") as tar:
        data = "\n".join(each.s for each in samples(log)).encode()
        info = tarfile.TarInfo("pose_01.csv")
        info.size = len(data)
        tar.addfile(info, io.BytesIO(data))
    return Foreign([path])


def database(folder: Path, log: HandLog) -> Foreign:
    path = folder / "imu.db"
    with sqlite3.connect(path) as base:
        base.execute("create table imu (t real, ax real, ay real, az real)")
        base.executemany("insert into imu values (?, ?, ?, ?)",
                         [each.cells[:4] for each in samples(log)])
    return Foreign([path])


def attitudes(folder: Path, log: HandLog) -> Foreign:
    """Angles that a filter computed; nothing names them."""
    x, y, z = log.acc.T
    angles = np.degrees([np.arctan2(y, z), np.arctan2(-x, np.hypot(y, z)), np.cumsum(
        log.gyr[:, 2]) / log.rate_hz])
    return Foreign([write_lines(folder / "euler.txt", [
        f"{t:.3f},{a:.2f},{b:.2f},{c % 360:.2f}"
        for t, a, b, c in zip(log.time_s, *angles, strict=True)])])


def bytes_of_a_bus(folder: Path, log: HandLog) -> Foreign:
    """A logic analyser: a byte a line."""
    octets = np.clip(counts_of(log), -32768, 32767)[:200].astype(">i2").tobytes()
    return Foreign([write_lines(folder / "digital.csv", ["name,type,start_time,ack,data", *(
        f'"I2C","data",{i / 1e4:.5f},true,0x{octet:02X}' for i, octet in enumerate(octets))])])


REFUSED: dict[str, tuple[Writer, str]] = {
    # gravity removed and in a table of its own
    "sensor_logger_default": (sensor_logger("default.zip", lambda acc, gravity, gyr: {
        "Accelerometer": acc - gravity, "Gravity": gravity, "Gyroscope": gyr}),
        "gravity is removed from its readings .*Total Acceleration"),
    # readings divided by their own length
    "normalised": (rows("unit.csv", "time_s,ax,ay,az", lambda s: (
        f"{s.t:.3f},{Values(s.a / np.linalg.norm(s.a)):,.6f}")),
        "all its readings have the length 1"),
    "thousands": (rows("sheet.csv", "Zeit_ms;ax;ay;az;gx;gy;gz", lambda s: ";".join(
        f"{v:,}".replace(",", ".") for v in (round(1000 * s.t), *s.c)), **PER_COUNT),
        "points separate the thousands"),
    "commas_between_decimal_commas": (rows("sheet.csv", "t,ax,ay,az", lambda s: ",".join(
        f"{v:.3f}".replace(".", ",") for v in (s.t, *s.a))), "commas stand between them too"),
    "transposed": (transposed, "each row is a channel .*Transpose"),
    # high and low byte of each number under the names of the registers, decimal
    "two_bytes": (rows("i2c.csv", "ms," + ",".join(f"REG{0x3B + i:02X}" for i in range(12)),
                       lambda s: f"{1000 * s.t:.0f},{Values(words_of(s.c16, '>')):,d}",
                       **PER_COUNT), "are the high and the low byte"),
    # ADXL335 behind a converter: 1.65 V is nothing, 0.33 V are 1 g
    "volts": (rows("adxl335.csv", "time_s,x_V,y_V,z_V", lambda s: (
        f"{s.t:.3f},{Values(1.65 + v for v in s.a):,.5f}"), 0.33 / G, None),
        "volts .*Subtract these and divide by 0.33"),
    # columns of ten characters that are full: no blank stands between them
    "run_together": (rows("run.out", "", lambda s: f"{s.t:9.4f}{s.a:9.4f}{s.w:9.4f}", 10,
                          100 / DEG), "two numbers without a blank between them"),
    "tarball": (tarball, "an archive of tar. Unpack it by `tar xf poses.tar.gz`"),
    "database": (database, "a database of SQLite"),
    # counts as a spreadsheet shows them
    "quoted_thousands_of_counts": (rows("sheet.csv", "Seconds,AX,AY,AZ,GX,GY,GZ", lambda s: (
        f"{s.t:.2f}," + ",".join(f'"{v:,}"' for v in s.c)), **PER_COUNT),
        "may be a decimal comma or separate thousands"),
    # a matrix as MATLAB shows it: a factor above few digits
    "diary": (rows("diary.txt", "ans =\n\n   1.0e+03 *\n\n", lambda s: "   ".join(
        f"{v / 1000:10.6f}" for v in (s.t, *s.a, *s.w))), r"multiplied by 1.0e\+03"),
    "letters": (rows("packets.txt", "", lambda s: base64.b64encode(
        words_of(s.c16, "<")).decode(), **PER_COUNT), "base64"),
    # `candump -l`
    "can_bus": (rows("can.log", "", lambda s: "\n".join(
        f"({EPOCH_S + s.t:.6f}) can0 0{17 + i}#"
        + words_of(Values(s.c16[3 * i : 3 * i + 3]), ">").hex().upper() for i in range(2)),
        **PER_COUNT), "messages of a bus .*cantools decode"),
    # all samples in one object of JSON
    "samples_beside_each_other": (json_of("all.json", lambda log: {
        f"a{i}": v for i, v in enumerate(log.acc[:100].ravel().tolist())}),
        r"it has 300 columns .* Write a row for each sample"),
    # a logic analyser's
    "packets_of_a_bus": (rows("spi.csv", "Time [s],Packet ID,MOSI,MISO", lambda s: (
        f"{s.t:.9f},{s.i},0x{s.i % 256:02X},0x{s.i * 7 % 256:02X}")),
        r"with their bytes in hexadecimal"),
    "gravity_removed": (gravity_removed, "the same in every rest, so that gravity is removed"),
    "gravity_removed_beside_a_gyroscope": (
        gravity_removed_beside_a_gyroscope, "the same in every rest, so that gravity is removed"),
    # bytes that a telephone received, with dashes between them
    "notifications": (rows("ble.txt", "", lambda s: (
        f"A\t14:05:{s.t:06.3f}\tNotification, value: (0x) "
        + words_of(s.c16, "<").hex("-").upper()), **PER_COUNT), "with their bytes in hexadecimal"),
    "other_order": (other_order, "appended.csv:1002: from here on the columns are t, gx, gy, gz"),
    "an_axis_a_file": (an_axis_a_file, "each row holds one value, as .*merge_asof"),
    # a terminal's view of what a sensor sends, of which some bytes read as numbers
    "bytes_of_a_port": (rows("hex.txt", "", lambda s: (
        f"55 51 {words_of(s.c16, '<').hex(' ')}".upper()), **PER_COUNT),
        "with their bytes in hexadecimal"),
    "poses_side_by_side": (poses_side_by_side, "each row is a channel .ax .m/s².*Transpose"),
    "axes_apart": (axes_apart, "paste -d ',' .*'.*x 1.txt' .*'.*z 1.txt' >log.csv"),
    "attitudes": (attitudes, "not called another quantity .* computed angles do not replace"),
    "bytes_of_a_bus": (bytes_of_a_bus, "the bytes of a bus, one by one"),
}
