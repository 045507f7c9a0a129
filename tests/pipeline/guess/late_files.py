"""Logs that were thought of after the importer was written, and that it did not read at first."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.pipeline.guess.foreign_files import DEG, Foreign, G
from tests.pipeline.guess.hand_log import HandLog
from tests.pipeline.guess.text_rows import counts_of, si_rows, write_lines

TICKS = 2**32  #: of a counter, which then begins again


def movella_dot(folder: Path, log: HandLog) -> Foreign:
    """SampleTimeFine in microseconds, where an MTi's ticks at 10 kHz, and it wraps."""
    head = ["sep=,", "DeviceTag:,Xsens DOT 3", "OutputRate:,100Hz", "",
            "PacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z,"]
    rows = [f"{i + 1},{(round(t * 1e6) + TICKS - 50_000_000) % TICKS},"
            + "".join(f"{v:.6f}," for v in (*a, *(w / DEG)))
            for i, (t, a, w) in enumerate(zip(log.time_s, log.acc, log.gyr, strict=True))]
    return Foreign([write_lines(folder / "Xsens DOT 3_D422CD00.csv", [*head, *rows])],
                   1.0, 1 / DEG)


def registers(folder: Path, log: HandLog) -> Foreign:
    """Sixteen bits in hexadecimal, as they stand in the sensor."""
    rows = [" ".join([str(round(t * 1000)), *(f"0x{v & 0xFFFF:04X}" for v in counts)])
            for t, counts in zip(log.time_s, np.clip(counts_of(log), -32768, 32767), strict=True)]
    return Foreign([write_lines(folder / "raw.log", ["t_ms AX AY AZ GX GY GZ", *rows])],
                   16384 / G, 131.072 / DEG)


def fortran(folder: Path, log: HandLog) -> Foreign:
    """Exponents with a D, and a C in front of the names."""
    rows = ["  ".join(f"{float(v):.7E}".replace("E", "D") for v in row) for row in si_rows(log)]
    head = "C  TIME/S  FX/(M/S2)  FY  FZ  WX/(RAD/S)  WY  WZ"
    return Foreign([write_lines(folder / "fort.21", [head, *rows])], 1.0, 1.0)


def spreadsheet(folder: Path, log: HandLog) -> Foreign:
    """Days since 1900, as a spreadsheet stores a date."""
    rows = [",".join([f"{46085.41666667 + t / 86400:.10f}", *(f"{v:.5f}" for v in (*a / G, *w))])
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    head = "Date,AccX [g],AccY [g],AccZ [g],GyroX [rad/s],GyroY [rad/s],GyroZ [rad/s]"
    return Foreign([write_lines(folder / "sheet.csv", [head, *rows])], 1 / G, 1.0)


def taking_turns(folder: Path, log: HandLog) -> Foreign:
    """Each row has the readings of one sensor, the cells of the other are empty."""
    rows = [row for t, *cells in si_rows(log)
            for row in (",".join([t, *cells[:3], "", "", ""]),
                        ",".join([f"{float(t) + 0.002:.4f}", "", "", "", *cells[3:]]))]
    return Foreign([write_lines(folder / "turns.csv", ["t,ax,ay,az,gx,gy,gz", *rows])])


def tagged_lines(folder: Path, log: HandLog) -> Foreign:
    """A sample in three lines, each with a name and three numbers: Razor AHRS."""
    counts = counts_of(log, 256.0, 14.375)
    lines = [f"#{name}=" + ",".join(f"{v}.00" for v in row) for a in counts
             for name, row in (("A-R", a[:3]), ("M-R", a[:3] // 9), ("G-R", a[3:]))]
    return Foreign([write_lines(folder / "razor.txt", lines)], 256 / G, 14.375 / DEG, log.rate_hz)


def vectors_under_names(folder: Path, log: HandLog) -> Foreign:
    """Edge Impulse: rows of numbers deep in an object, whose names stand beside them."""
    sensors = [{"name": f"{name}{axis}", "units": unit} for name, unit in (
        ("acc", "m/s2"), ("gyr", "dps")) for axis in "XYZ"]
    values = np.hstack([log.acc, log.gyr / DEG]).round(4).tolist()
    path = folder / "idle.1.json"
    path.write_text(json.dumps({"signature": "0", "payload": {
        "interval_ms": 1000 / log.rate_hz, "sensors": sensors, "values": values}}),
        encoding="utf-8")
    return Foreign([path], 1.0, 1 / DEG)


def packets_deep_inside(folder: Path, log: HandLog) -> Foreign:
    """Movesense: four samples in an object of each row, with one time."""
    packets = [{"Body": {"Timestamp": round(1000 * log.time_s[i])} | {
        name: [dict(zip("xyz", row, strict=True)) for row in values[i : i + 4].round(4).tolist()]
        for name, values in (("ArrayAcc", log.acc), ("ArrayGyro", log.gyr / DEG))}, "Method": "PUT"}
        for i in range(0, len(log.time_s) - 3, 4)]
    path = folder / "imu6_stream.json"
    path.write_text(json.dumps({"data": packets}), encoding="utf-8")
    return Foreign([path], 1.0, 1 / DEG)


def means_with_sds(folder: Path, log: HandLog) -> Foreign:
    """A student's table: a mean and its sd in each cell, with decimal commas."""
    cells = [[f"{a.mean():.4f} ± {a.std() / 5:.4f}" for a in log.acc[log.rest == i].T]
             for i in range(18)]
    rows = [";".join([str(i + 1), *row]).replace(".", ",") for i, row in enumerate(cells)]
    return Foreign([write_lines(folder / "Mittelwerte.csv", [
        "Lage;ax (m/s²);ay (m/s²);az (m/s²)", *rows], "cp1252")], 1.0, None)


def gains_of_their_own(folder: Path, log: HandLog) -> Foreign:
    """An MTi's raw counts in a file for each sensor, of gains that no list of ranges has."""
    per_m_s2, per_rad_s = 415.0, 4780.0
    files = [write_lines(folder / f"mti_{name}.txt", [
        " ".join([f"{t:.5f}", *map(str, row)])
        for t, row in zip(log.time_s, np.rint(values * per).astype(int) + 32768, strict=True)])
        for name, values, per in (("acc", log.acc, per_m_s2), ("gyro", log.gyr, per_rad_s))]
    return Foreign(files, per_m_s2, per_rad_s)


def names_in_the_first_row(folder: Path, log: HandLog) -> Foreign:
    """A spreadsheet's table in JSON: rows of quoted cells, the names in the first of them."""
    path = folder / "sheet.json"
    path.write_text(json.dumps({"range": "Log!A1:G", "values": [
        ["t_s", "ax", "ay", "az", "gx", "gy", "gz"], *si_rows(log)]}), encoding="utf-8")
    return Foreign([path])


def index_without_a_name(folder: Path, log: HandLog) -> Foreign:
    """pandas: the first column has no name, so that the header begins with a tab."""
    rows = ["\t".join([str(i), *row]) for i, row in enumerate(si_rows(log))]
    return Foreign([write_lines(folder / "df.tsv", [
        "\tt_s\tIMU.acc.x\tIMU.acc.y\tIMU.acc.z\tIMU.gyr.x\tIMU.gyr.y\tIMU.gyr.z", *rows])])


def json_in_a_string(folder: Path, log: HandLog) -> Foreign:
    """Messages of MQTT: the payload is JSON in a text of JSON."""
    return Foreign([write_lines(folder / "mqtt.ndjson", [json.dumps({
        "topic": "imu/1", "t_s": t, "payload": json.dumps({"acc": a, "gyro": w})})
        for t, a, w in zip(log.time_s.tolist(), log.acc.tolist(), log.gyr.tolist(), strict=True)])])


def time_with_a_colon(folder: Path, log: HandLog) -> Foreign:
    """Milliseconds with a colon behind them, and a bar of text between the sensors."""
    rows = [f"{1000 * t:.0f}: {' '.join(map(str, row[:3]))} / {' '.join(map(str, row[3:]))}"
            for t, row in zip(log.time_s, counts_of(log, 4096.0, 16.384), strict=True)]
    return Foreign([write_lines(folder / "teensy.txt", ["# raw", *rows])], 4096 / G, 16.384 / DEG)


def axes_in_rows_of_their_own(folder: Path, log: HandLog) -> Foreign:
    """Science Journal: a row for each axis, whose cells of the others are empty."""
    rows = [",".join([str(round(1000 * t) + k), *(f"{v:.6f}" if j == k else "" for j in range(3))])
            for t, a in zip(log.time_s, log.acc, strict=True) for k, v in enumerate(a)]
    return Foreign([write_lines(folder / "recording.csv", ["relative_time,AccX,AccY,AccZ", *rows])],
                   1.0, None)


def rare_kinds_of_objects(folder: Path, log: HandLog) -> Foreign:
    """gpsd: now and then an object of another class, with keys of its own."""
    names = ("t", "acc_x", "acc_y", "acc_z", "gyro_x", "gyro_y", "gyro_z")
    rows = [{"class": "ATT"} | dict(zip(names, map(float, row), strict=True))
            for row in si_rows(log)]
    rows[::25] = [{"class": "TPV", "mode": 3, "lat": 48.1, "lon": 11.5} for _ in rows[::25]]
    return Foreign([write_lines(folder / "gpsd.json", list(map(json.dumps, rows)))])


def three_lines_of_names(folder: Path, log: HandLog) -> Foreign:
    """Origin: long names, units and comments, with what each line holds in its first cell."""
    head = ["Long Name\tTime" + "\tAcceleration" * 3 + "\tAngular rate" * 3,
            "Units\tms" + "\tmg" * 3 + "\tdps" * 3, "Comments\t" + "\tx\ty\tz" * 2]
    rows = ["\t".join(["", f"{1000 * float(row[0]):.0f}", *row[1:]])
            for row in si_rows(log, 1000 / G, 1 / DEG)]
    return Foreign([write_lines(folder / "Book1.dat", [*head, *rows])], 1000 / G, 1 / DEG)


def printed_frame(folder: Path, log: HandLog) -> Foreign:
    """pandas: the first column counts the rows, and the line of names has none for it; minutes."""
    rows = [f"{i:<6d}{float(row[0]) / 60:12.8f}" + "".join(f"{cell:>12}" for cell in row[1:])
            for i, row in enumerate(si_rows(log))]
    head = " " * 6 + "".join(f"{name:>12}" for name in ("min", "ax", "ay", "az", "gx", "gy", "gz"))
    return Foreign([write_lines(folder / "frame.txt", [head, *rows])])


def brick_logger(folder: Path, log: HandLog) -> Foreign:
    """Tinkerforge: a value, its name and its unit in each row, with numbers in units and names."""
    rows = [f"2026-03-04T14:05:{t:06.3f}+01:00;IMU Brick 2.0;{name}-{axis};{v:.0f};{unit}"
            for t, a, w in zip(log.time_s, log.acc * 100, log.gyr / DEG * 16, strict=True)
            for name, unit, row in (("Acceleration", "cm/s²", a),
                                    ("Angular Velocity", "1/16 °/s", w))
            for axis, v in zip("XYZ", row, strict=True)]
    return Foreign([write_lines(folder / "bricks.csv", ["TIME;NAME;VAR;RAW;UNIT", *rows])], 100.0,
                   16 / DEG)


def sensors_in_folders(folder: Path, log: HandLog) -> Foreign:
    """A folder for each sensor, with files and columns of the same names."""
    files = []
    for name, values in (("acc", log.acc), ("gyro", log.gyr)):
        (folder / name).mkdir()
        rows = [",".join([f"{t:.3f}", *(f"{v:.6f}" for v in row)])
                for t, row in zip(log.time_s, values, strict=True)]
        files.append(write_lines(folder / name / "data.csv", ["timestamp,x,y,z", *rows]))
    return Foreign(files)


def bare_hexadecimal(folder: Path, log: HandLog) -> Foreign:
    """Registers without 0x, of which some look like decimal numbers, as do the times."""
    rows = [",".join([str(round(1000 * t)), *(f"{int(v) & 0xFFFF:04X}" for v in row)])
            for t, row in zip(log.time_s, counts_of(log), strict=True)]
    return Foreign([write_lines(folder / "hex.csv", ["t_ms,ax,ay,az,gx,gy,gz", *rows])],
                   16384 / G, 131.072 / DEG)


def lines_of_a_console(folder: Path, log: HandLog) -> Foreign:
    """Adafruit's test of a BNO055: tabs between a name and its axes, and lines of the state."""
    lines = ["Orientation Sensor Test", "", *(
        line for a, w in zip(log.acc, log.gyr / DEG, strict=True)
        for line in (*(f"{name}:\t\tx= {x:.3f} |\ty= {y:.3f} |\tz= {z:.3f}" for name, (x, y, z) in (
            ("Accl", a), ("Gyro", w))), "", "temperature: 24", "Calibration: Sys=0 Gyro=3", "--"))]
    return Foreign([write_lines(folder / "bno.log", lines)], 1.0, 1 / DEG, log.rate_hz)


def row_number_and_interval(folder: Path, log: HandLog) -> Foreign:
    """The rows are counted, and each states the time since the one before."""
    rows = [f"{i} acc=[{a[0]: .5f} {a[1]: .5f} {a[2]: .5f}] gyro=[{w[0]: .6f} {w[1]: .6f} "
            f"{w[2]: .6f}] dt={1 / log.rate_hz:.4f}"
            for i, (a, w) in enumerate(zip(log.acc, log.gyr, strict=True))]
    return Foreign([write_lines(folder / "print.txt", rows)])


def gravity_removed(folder: Path, log: HandLog) -> Foreign:
    """The teapot's sketch: counts of an acceleration that nothing names."""
    up = G * log.acc / np.linalg.norm(log.acc, axis=1, keepdims=True)
    at_rest = log.rest[:, None] >= 0
    force = np.where(at_rest, 0.02 * (log.acc - up), log.acc - up) + np.array([0.2, -0.1, 0.3])
    rows = ["\t".join(["areal", *map(str, row)]) for row in np.rint(force * 835).astype(int)]
    return Foreign([write_lines(folder / "teapot.txt", rows)])


def notifications(folder: Path, log: HandLog) -> Foreign:
    """Bytes that a telephone received, with dashes between them."""
    counts = np.clip(counts_of(log), -32768, 32767).astype("<i2")
    return Foreign([write_lines(folder / "ble.txt", [
        f"A\t14:05:{t:06.3f}\tNotification, value: (0x) {row.tobytes().hex('-').upper()}"
        for t, row in zip(log.time_s, counts, strict=True)])])


def other_order(folder: Path, log: HandLog) -> Foreign:
    """A file that was continued with other columns."""
    rows = [",".join(row) for row in si_rows(log)]
    turned = [",".join([row[0], *row[4:], *row[1:4]]) for row in si_rows(log)[1000:]]
    return Foreign([write_lines(folder / "appended.csv", [
        "t,ax,ay,az,gx,gy,gz", *rows[:1000], "t,gx,gy,gz,ax,ay,az", *turned])])


def an_axis_a_file(folder: Path, log: HandLog) -> Foreign:
    """Arduino Cloud: a file with times and values for each variable."""
    return Foreign([write_lines(folder / f"acc_{axis}.csv", ["time,value", *(
        f"{t:.3f},{v:.5f}" for t, v in zip(log.time_s, values, strict=True))])
        for axis, values in zip("xyz", log.acc.T, strict=True)])


def bytes_of_a_port(folder: Path, log: HandLog) -> Foreign:
    """A terminal's view of what a sensor sends, of which some bytes read as numbers."""
    counts = np.clip(counts_of(log), -32768, 32767).astype("<i2")
    return Foreign([write_lines(folder / "hex.txt", [
        f"55 51 {row.tobytes().hex(' ')}".upper() for row in counts])])


def poses_side_by_side(folder: Path, log: HandLog) -> Foreign:
    """A pose in each column, in a code page, with units in its row names."""
    means = np.array([log.acc[log.rest == i].mean(axis=0) for i in range(18)])
    return Foreign([write_lines(folder / "poses.csv", [
        ";".join(["", *(f"Lage {i + 1}" for i in range(18))]), *(
            ";".join([f"a{axis} [m/s²]", *(f"{v:.4f}" for v in row)])
            for axis, row in zip("xyz", means.T, strict=True))], "cp1252")])


LATE_REFUSED: dict[str, tuple[Callable[[Path, HandLog], Foreign], str]] = {
    "gravity_removed": (gravity_removed, "the same in every rest, so that gravity is removed"),
    "notifications": (notifications, "with their bytes in hexadecimal"),
    "other_order": (other_order, "appended.csv:1002: from here on the columns are t, gx, gy, gz"),
    "an_axis_a_file": (an_axis_a_file, "each row holds one value, as .*merge_asof"),
    "bytes_of_a_port": (bytes_of_a_port, "with their bytes in hexadecimal"),
    "poses_side_by_side": (poses_side_by_side, "each row is a channel .ax .m/s².*Transpose"),
}
LATE: dict[str, Callable[[Path, HandLog], Foreign]] = {
    tool.__name__: tool for tool in (
        movella_dot, registers, fortran, spreadsheet, taking_turns, tagged_lines,
        vectors_under_names, packets_deep_inside, means_with_sds, gains_of_their_own,
        axes_in_rows_of_their_own, rare_kinds_of_objects, three_lines_of_names,
        bare_hexadecimal, lines_of_a_console, row_number_and_interval,
        printed_frame, brick_logger, sensors_in_folders,
        names_in_the_first_row, index_without_a_name, json_in_a_string, time_with_a_colon)
}
