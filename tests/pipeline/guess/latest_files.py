"""Logs of whole classes: a number a line, the same labels from the first line on."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.pipeline.guess.foreign_files import DEG, Foreign, G
from tests.pipeline.guess.hand_log import HandLog
from tests.pipeline.guess.text_rows import counts_of, si_rows, write_lines


def a_number_a_line(folder: Path, log: HandLog) -> Foreign:
    """`Serial.println` of one value after another."""
    return Foreign([write_lines(folder / "monitor.txt", [
        cell for row in si_rows(log, 1.0, 1 / DEG) for cell in row])], 1.0, 1 / DEG)


def counts_a_line(folder: Path, log: HandLog) -> Foreign:
    """Counts of seven channels, the temperature among them, between words and empty lines."""
    rows = np.insert(counts_of(log), 3, -1700, axis=1)
    return Foreign([write_lines(folder / "port.log", [
        "MPU6050 ready", *(cell for row in rows for cell in (*map(str, row), ""))])],
        16384 / G, 131.072 / DEG, log.rate_hz)


def labels_from_the_first_line(folder: Path, log: HandLog) -> Foreign:
    """Means of poses, none of which may be lost."""
    means = [log.acc[log.rest == i].mean(axis=0) for i in range(18)]
    return Foreign([write_lines(folder / "faces.txt", [
        f"X: {x:.4f} Y: {y:.4f} Z: {z:.4f}" for x, y, z in means])], 1.0, None)


def an_axis_a_file(folder: Path, log: HandLog) -> Foreign:
    return Foreign([write_lines(folder / f"{axis} 1.txt", [f"{v:.5f}" for v in values])
                    for axis, values in zip("xyz", log.acc.T, strict=True)])


def sign_extended(folder: Path, log: HandLog) -> Foreign:
    """`Serial.print(ax, HEX)`: negative numbers have eight digits, small ones few."""
    return Foreign([write_lines(folder / "com5.txt", [
        ",".join([f"{round(1000 * t)}", *(f"{int(v) & 0xFFFFFFFF:X}" for v in row)])
        for t, row in zip(log.time_s, counts_of(log), strict=True)])], 16384 / G, 131.072 / DEG)


def quoted_thousands(folder: Path, log: HandLog) -> Foreign:
    """American cells with a separator of thousands."""
    rows = [",".join([f"{t:.3f}", *(f'"{v:,.1f}"' if abs(v) >= 1000 else f"{v:.1f}" for v in row)])
            for t, row in zip(log.time_s, log.acc * 1000 / G, strict=True)]
    return Foreign([write_lines(folder / "Book1.csv", [
        "Time (s),Accel X (mg),Accel Y (mg),Accel Z (mg)", *rows])], 1000 / G, None)


def zero_bytes(folder: Path, log: HandLog) -> Foreign:
    """What a port holds when it is opened, and a card after power was lost."""
    rows = [",".join(row) for row in si_rows(log)]
    rows[700] = rows[700][:9] + "\0" * 512
    return Foreign([write_lines(folder / "card.csv", [
        "\0boot", "t,ax,ay,az,gx,gy,gz", *rows, "\0" * 512])])


def poses_beside_each_other(folder: Path, log: HandLog) -> Foreign:
    """A block of columns for each pose in one sheet, with a title above and an empty column."""
    poses = [[f"{t:.2f},{x:.4f},{y:.4f},{z:.4f}" for t, (x, y, z) in zip(
        log.time_s, log.acc[log.rest == i], strict=False)] for i in range(18)]
    return Foreign([write_lines(folder / "sheet.csv", [
        ",,,,".join(f"Pose {i + 1}," for i in range(18)), ",,".join(["t [s],ax,ay,az"] * 18),
        *map(",,".join, zip(*poses, strict=True))])], 1.0, None)


def a_field_after_another(folder: Path, log: HandLog) -> Foreign:
    """A query of InfluxDB as its page saves it: all values of one name, then of the next."""
    names = ("ax", "ay", "az", "gx", "gy", "gz")
    values = np.hstack([log.acc, log.gyr])
    return Foreign([write_lines(folder / "influx.csv", [
        "#datatype,string,long,dateTime:RFC3339,double,string", ",result,table,_time,_value,_field",
        *(f",,{j},2026-11-27T17:{int(t // 60):02d}:{t % 60:06.3f}Z,{v:.6f},{name}"
          for j, name in enumerate(names) for t, v in zip(log.time_s, values[:, j], strict=True)),
        ""])])


def topics_of_a_broker(folder: Path, log: HandLog) -> Foreign:
    """Two topics at two rates."""
    rows = []
    for i, (t, *cells) in enumerate(si_rows(log, 1 / G, 1 / DEG)):
        for name, (x, y, z) in (("acc", cells[:3]), ("gyr", cells[3:]))[: 2 - i % 2]:
            rows.append(f'bench/{name} {{"ts":{1000 * float(t):.0f},"x":{x},"y":{y},"z":{z}}}')
    return Foreign([write_lines(folder / "mqtt.log", rows)], 1 / G, 1 / DEG)


def two_units_of_a_message(folder: Path, log: HandLog) -> Foreign:
    """ArduPilot: a message for each of two sensors, told by their number."""
    rows = ["FMT, 163, 58, IMU, QBffffff, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"]
    for t, *cells in si_rows(log):
        other = [f"{float(cell) + 0.4:.6f}" for cell in cells]
        rows += [f"ATT, {1e6 * float(t):.0f}, 1.5, 2.5, 180.2", *(
            ", ".join(["IMU", f"{1e6 * float(t):.0f}", str(i), *six[3:], *six[:3]])
            for i, six in enumerate((cells, other)))]
    return Foreign([write_lines(folder / "00000012.log", rows)])


def rows_of_other_widths(folder: Path, log: HandLog) -> Foreign:
    """A short file for each pose, in which a few rows are those of other sensors."""
    files = []
    for i in range(18):
        rows = ["sensor,TSND", "kind,time[ms],X,Y,Z,gyro X,gyro Y,gyro Z"]
        for j, (t, *cells) in enumerate(np.array(si_rows(log, 1.0, 1 / DEG))[log.rest == i]):
            rows.append(",".join(["ags", f"{1000 * float(t):.0f}", *cells]))
            if j % 10 == 0:
                rows += [f"geo,{1000 * float(t) + 1:.0f},-105,{254 + j},-395", "pres,7,101312,23"]
        files.append(write_lines(folder / f"p{i:02d}.csv", rows))
    return Foreign(files, 1.0, 1 / DEG)


def messages_of_a_vehicle(folder: Path, log: HandLog) -> Foreign:
    """mavlogdump with other messages between those of the sensor."""
    rows = []
    for i, (t, *six) in enumerate(si_rows(log, 1000 / G, 1000.0)):
        values = ", ".join(f"{name} : {float(cell):.0f}" for name, cell in zip(
            ("xacc", "yacc", "zacc", "xgyro", "ygyro", "zgyro"), six, strict=True))
        stamp = f"2026-11-27 18:11:{float(t):05.2f}"
        rows.append(f"{stamp}: SCALED_IMU2 {{time_boot_ms : {1000 * float(t):.0f}, {values}}}")
        if i % 5 == 0:
            rows.append(f"{stamp}: HEARTBEAT {{type : 2, autopilot : 3, base_mode : 81}}")
    return Foreign([write_lines(folder / "rest.mavlog.txt", rows)], 1000 / G, None)


def a_clock_beside_every_channel(folder: Path, log: HandLog) -> Foreign:
    """EMG at three times the rate in the same table, whose header repeats the name of its clock."""
    rows = [",".join([f"{i / 150:.5f}", f"{1e-5 * np.sin(i):.3e}", *(
        cell for v in values for cell in (f"{i / 50:.4f}", v))])
        for i, (_, *values) in enumerate(si_rows(log, 1 / G, 1 / DEG))]
    units = [f"{name}.{axis} 4 (IM)[{unit}]" for name, unit in (("ACC", "g"), ("GYRO", "deg/s"))
             for axis in "XYZ"]
    return Foreign([write_lines(folder / "Run.csv", [
        ",".join(f"X[s],{name}" for name in ("EMG 4[V]", *units)), *rows])], 1 / G, 1 / DEG)


def logcat(folder: Path, log: HandLog) -> Foreign:
    """Android's log: dates without a year before lines of two sensors."""
    rows = ["--------- beginning of main"]
    for t, *cells in si_rows(log):
        stamp = f"11-27 18:{9 + int(float(t)) // 60:02d}:{float(t) % 60:06.3f}"
        rows += [f"{stamp}  8123  8190 D SensorDump: {name} x={x} y={y} z={z} acc=3"
                 for name, (x, y, z) in (("ACC", cells[:3]), ("GYR", cells[3:]))]
    return Foreign([write_lines(folder / "logcat.txt", rows)])


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
    return Foreign([write_lines(folder / "digital.csv", [
        "name,type,start_time,ack,data", *(f'"I2C","data",{i / 1e4:.5f},true,0x{octet:02X}'
                                           for i, octet in enumerate(octets))])])


def properties_above(folder: Path, log: HandLog) -> Foreign:
    """LabVIEW's TDMS as a table: what holds for each channel stands above it, with its name in a
    column of its own; numbers among it are no readings."""
    above = {"Group": "IMU", "Channel": "", "wf_start_time": "03/11/2024 10:11:12 AM",
             "wf_increment": 1 / log.rate_hz, "wf_samples": len(log.time_s)}
    lines = [",".join([name, *[str(value)] * 6]) for name, value in above.items()]
    lines[1] = "Channel," + ",".join(f"{name} {axis}" for name in ("Acc", "Gyro") for axis in "XYZ")
    lines.insert(2, "unit_string,g,g,g,deg/s,deg/s,deg/s")
    rows = [",".join(["", *row[1:]]) for row in si_rows(log, 1 / G, 1 / DEG)]
    return Foreign([write_lines(folder / "tdms.csv", [*lines, *rows])], 1 / G, 1 / DEG)


def milliseconds_without_zeros(folder: Path, log: HandLog) -> Foreign:
    """`printf("%d.%d", s, ms)`: 12.20 is followed by 12.40, and 12.980 by 13.0."""
    rows = [",".join([f"10:11:{int(t):02d}.{round(1000 * t) % 1000}", *row[1:]])
            for t, row in zip(log.time_s, si_rows(log, 1 / G, 1 / DEG), strict=True)]
    return Foreign([write_lines(folder / "rtc.csv", ["time,ax,ay,az,gx,gy,gz", *rows])], 1 / G,
                   1 / DEG)


def clock_face(folder: Path, log: HandLog) -> Foreign:
    """101159980, followed by 101200000: hours, minutes, seconds and milliseconds in one number."""
    times = [f"10{11 + int(t) // 60}{t % 60:06.3f}".replace(".", "") for t in log.time_s + 20]
    rows = [",".join([t, *row[1:]])
            for t, row in zip(times, si_rows(log, 1 / G, 1 / DEG), strict=True)]
    return Foreign([write_lines(folder / "face.csv", ["time,ax,ay,az,gx,gy,gz", *rows])], 1 / G,
                   1 / DEG)


def nanoseconds_without_zeros(folder: Path, log: HandLog) -> Foreign:
    """`f"{stamp.secs}.{stamp.nsecs}"`."""
    rows = [",".join([f"{1_700_000_000 + int(t)}.{round(1e9 * t) % 10**9}", *row[1:]])
            for t, row in zip(log.time_s, si_rows(log), strict=True)]
    return Foreign([write_lines(folder / "ros.csv", ["stamp,ax,ay,az,gx,gy,gz", *rows])])


def numbers_of_numpy(folder: Path, log: HandLog) -> Foreign:
    """A dictionary as Python prints it where NumPy 2 made its numbers."""
    names = ("t", "ax", "ay", "az", "gx", "gy", "gz")
    rows = ["{" + ", ".join(f"'{name}': np.float64({value})" for name, value in zip(
        names, row, strict=True)) + "}" for row in si_rows(log)]
    return Foreign([write_lines(folder / "print.txt", rows)])


def objects_without_quotes(folder: Path, log: HandLog) -> Foreign:
    """`console.log` of an object: it begins as JSON does, and its names have no quotes."""
    rows = [f"{{\n  t: {t},\n  acc: {{ x: {x}, y: {y}, z: {z} }},\n"
            f"  gyro: {{ x: {p}, y: {q}, z: {r} }}\n}}" for t, x, y, z, p, q, r in si_rows(log)]
    return Foreign([write_lines(folder / "console.txt", rows)])


def negative_in_brackets(folder: Path, log: HandLog) -> Foreign:
    """Numbers in brackets, which accountants write for negative ones."""
    rows = [",".join(f"({v[1:]})" if v[0] == "-" else v for v in row) for row in si_rows(log)]
    return Foreign([write_lines(folder / "book.csv", ["t,ax,ay,az,gx,gy,gz", *rows])])


def series_with_labels(folder: Path, log: HandLog) -> Foreign:
    """Grafana: labels with numbers in the names, units in the cells, a file for each rest."""
    head = ",".join(["Time", *(f"{name}_{axis} {{board=esp32-1}}" for name in ("acc", "gyr")
                               for axis in "xyz")])
    units = ["g"] * 3 + ["cdps"] * 3
    rows = np.column_stack([log.acc / G, 100 * log.gyr / DEG])
    return Foreign([write_lines(folder / f"p{i:02d}.csv", [head, *(
        ",".join([f"2024-03-11 10:11:{t:06.3f}", *(
            f"{v:.4f} {unit}" for v, unit in zip(row, units, strict=True))])
        for t, row in zip(log.time_s[log.rest == i], rows[log.rest == i], strict=True))])
        for i in range(18)], 1 / G, 100 / DEG)


def units_below_known_names(folder: Path, log: HandLog) -> Foreign:
    """A file for each rest: nothing turns gravity, and the unit stands in the second line alone."""
    rows = np.column_stack([1000 * log.time_s, log.acc / G, 100 * log.gyr / DEG])
    head = ["time,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z", "ms,g,g,g,cdps,cdps,cdps"]
    return Foreign([write_lines(folder / f"p{i:02d}.csv", [*head, *(
        ",".join(f"{v:.5f}" for v in row) for row in rows[log.rest == i])]) for i in range(18)],
        1 / G, 100 / DEG)


def units_that_cannot_be(folder: Path, log: HandLog) -> Foreign:
    """A header that was left as it was when the numbers were converted."""
    head = "time_ms,ax_mg,ay_mg,az_mg,gx_dps,gy_dps,gz_dps"
    rows = [",".join(row) for row in si_rows(log, 1 / G, 1 / DEG)]
    return Foreign([write_lines(folder / "converted.csv", [head, *rows])], 1 / G, 1 / DEG)


NAMES = ("t", "ax", "ay", "az", "gx", "gy", "gz")


def differences_of_pandas(folder: Path, log: HandLog) -> Foreign:
    """`0 days 00:00:01.02`."""
    rows = [",".join([f"0 days 00:00:{float(t):09.6f}", *row]) for t, *row in si_rows(log)]
    return Foreign([write_lines(folder / "delta.csv", [",".join(NAMES), *rows])])


def split_of_pandas(folder: Path, log: HandLog) -> Foreign:
    """`to_json(orient="split")`: the numbers of the rows are a list too, and as long."""
    rows = [[float(v) for v in row] for row in si_rows(log)]
    whole = {"columns": NAMES, "index": [*range(len(rows))], "data": rows}
    return Foreign([write_lines(folder / "split.json", [json.dumps(whole)])])


def columns_of_pandas(folder: Path, log: HandLog) -> Foreign:
    """`to_json()`: each value under the number of its row."""
    columns = zip(*si_rows(log), strict=True)
    whole = {name: {str(i): float(v) for i, v in enumerate(column)}
             for name, column in zip(NAMES, columns, strict=True)}
    return Foreign([write_lines(folder / "columns.json", [json.dumps(whole)])])


LATEST: dict[str, Callable[[Path, HandLog], Foreign]] = {
    tool.__name__: tool for tool in (
        a_number_a_line, counts_a_line, labels_from_the_first_line, sign_extended,
        quoted_thousands, zero_bytes,
        poses_beside_each_other, a_field_after_another, topics_of_a_broker,
        two_units_of_a_message, rows_of_other_widths, messages_of_a_vehicle,
        a_clock_beside_every_channel, logcat, properties_above, milliseconds_without_zeros,
        clock_face, nanoseconds_without_zeros, numbers_of_numpy, units_below_known_names,
        objects_without_quotes, negative_in_brackets, series_with_labels,
        units_that_cannot_be, differences_of_pandas, split_of_pandas, columns_of_pandas)
}
LATEST_REFUSED: dict[str, tuple[Callable[[Path, HandLog], Foreign], str]] = {
    "axes_apart": (an_axis_a_file, "paste -d ',' .*'.*x 1.txt' .*'.*z 1.txt' >log.csv"),
    "attitudes": (attitudes, "not called another quantity .* computed angles do not replace"),
    "bytes_of_a_bus": (bytes_of_a_bus, "the bytes of a bus, one by one"),
}
