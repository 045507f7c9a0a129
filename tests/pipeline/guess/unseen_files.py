"""Twenty logs that were invented when the importer weighed hypotheses, of many containers."""

import struct
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from tests.pipeline.guess.foreign_files import DEG, Foreign, G
from tests.pipeline.guess.hand_log import HandLog
from tests.pipeline.guess.text_rows import EPOCH_S, counts_of, si_rows, write_lines


def mavlink_dump(folder: Path, log: HandLog) -> Foreign:
    """mavlogdump.py: a message in braces, milli-g and mrad/s by its definition, other fields."""
    rows = []
    for t, a, w in zip(log.time_s, log.acc / G * 1000, log.gyr * 1000, strict=True):
        stamp = datetime.fromtimestamp(EPOCH_S + t, UTC)
        cells = [f"{n} : {v}" for n, v in zip(
            ("xacc", "yacc", "zacc", "xgyro", "ygyro", "zgyro"),
            np.rint([*a, *w]).astype(int), strict=True)]
        rows.append(f"{stamp:%Y-%m-%d %H:%M:%S}.{stamp.microsecond // 10000:02d}: RAW_IMU "
                    f"{{time_usec : {round(t * 1e6)}, {', '.join(cells)}, xmag : 231, ymag : -17, "
                    f"zmag : 402, id : 0, temperature : 2512}}")
    return Foreign([write_lines(folder / "flight.txt", rows)], 1000 / G, 1000.0)


def nmea(folder: Path, log: HandLog) -> Foreign:
    """A talker in front, a checksum in hexadecimal behind."""
    rows = []
    for row in si_rows(log, 1 / G, 1 / DEG):
        body = "PIMU," + ",".join(row)
        check = 0
        for sign in body:
            check ^= ord(sign)
        rows.append(f"${body}*{check:02X}")
    return Foreign([write_lines(folder / "capture.nmea", rows, end="\r\n")], 1 / G, 1 / DEG)


def line_protocol(folder: Path, log: HandLog) -> Foreign:
    """InfluxDB: tags, fields, and nanoseconds at the end."""
    rows = [f"imu,host=pi,place=bench ax={a[0]:.5f},ay={a[1]:.5f},az={a[2]:.5f},gx={w[0]:.6f},"
            f"gy={w[1]:.6f},gz={w[2]:.6f} {round((EPOCH_S + t) * 1e9)}"
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "export.lp", rows)], 1.0, 1.0)


def markdown(folder: Path, log: HandLog) -> Foreign:
    """A table of a notebook, with bars at both ends."""
    rows = ["| " + " | ".join(row) + " |" for row in si_rows(log, 1 / G, 1 / DEG)]
    return Foreign([write_lines(folder / "table.md", [
        "# Run 3", "", "| t (s) | ax (g) | ay (g) | az (g) | gx (dps) | gy (dps) | gz (dps) |",
        "|:---|---:|---:|---:|---:|---:|---:|", *rows])], 1 / G, 1 / DEG)


def html(folder: Path, log: HandLog) -> Foreign:
    """A page saved from a dashboard, a row of the table a line."""
    head = "".join(f"<th>{name}</th>" for name in ("time", "ax", "ay", "az", "gx", "gy", "gz"))
    rows = ["<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in si_rows(log)]
    return Foreign([write_lines(folder / "page.html", [
        "<!DOCTYPE html>", "<html><head><title>IMU</title></head><body><table>",
        f"<tr>{head}</tr>", *rows, "</table></body></html>"])], 1.0, 1.0)


def yaml_lines(folder: Path, log: HandLog) -> Foreign:
    """A list of mappings with vectors."""
    rows = [f"- {{t: {r[0]}, acc: [{', '.join(r[1:4])}], gyr: [{', '.join(r[4:])}]}}"
            for r in si_rows(log)]
    return Foreign([write_lines(folder / "samples.yaml", rows)], 1.0, 1.0)


def in_turn(folder: Path, log: HandLog) -> Foreign:
    """x of both sensors, y of both, z of both; no header."""
    rows = [" ".join(row[i] for i in (0, 1, 4, 2, 5, 3, 6)) for row in si_rows(log, 1, 1 / DEG)]
    return Foreign([write_lines(folder / "pairs.dat", rows)], 1.0, 1 / DEG)


def transposed(folder: Path, log: HandLog) -> Foreign:
    """A row for each channel."""
    columns = zip(*si_rows(log), strict=True)
    names = ("time", "ax", "ay", "az", "gx", "gy", "gz")
    return Foreign([write_lines(folder / "channels.csv", [
        ",".join([name, *cells]) for name, cells in zip(names, columns, strict=True)])], 1.0, 1.0)


def json_arrays(folder: Path, log: HandLog) -> Foreign:
    """An array a line, nothing named."""
    return Foreign([write_lines(folder / "rows.jsonl", [
        f"[{', '.join(row)}]" for row in si_rows(log)])], 1.0, 1.0)


def minutes(folder: Path, log: HandLog) -> Foreign:
    """A stopwatch: minutes, seconds and a fraction."""
    rows = [",".join([f"{int(t // 60):02d}:{t % 60:06.3f}", *row[1:]])
            for t, row in zip(log.time_s, si_rows(log, 1 / G, 1 / DEG), strict=True)]
    return Foreign([write_lines(folder / "watch.csv", [
        "Elapsed,aX,aY,aZ,gX,gY,gZ", *rows])], 1 / G, 1 / DEG)


def unicode_text(folder: Path, log: HandLog) -> Foreign:
    """Excel's `Unicode Text`: UTF-16, tabs, decimal commas."""
    rows = ["\t".join(row).replace(".", ",") for row in si_rows(log, 1 / G, 1 / DEG)]
    head = "Zeit (s)\tax (g)\tay (g)\taz (g)\tgx (°/s)\tgy (°/s)\tgz (°/s)"
    return Foreign([write_lines(folder / "Mappe.txt", [head, *rows], "utf-16", "\r\n")],
                   1 / G, 1 / DEG)


def typographic_minus(folder: Path, log: HandLog) -> Foreign:
    """Numbers through a word processor: U+2212."""
    rows = [";".join(row).replace("-", "−") for row in si_rows(log)]
    return Foreign([write_lines(folder / "notes.csv", ["t;ax;ay;az;gx;gy;gz", *rows])], 1.0, 1.0)


def gals(folder: Path, log: HandLog) -> Foreign:
    """cm/s², as seismologists have it."""
    rows = [",".join([f"{t:.3f}", *(f"{100 * v:.3f}" for v in a)])
            for t, a in zip(log.time_s, log.acc, strict=True)]
    return Foreign([write_lines(folder / "station.csv", [
        "time [s],acc_x [cm/s^2],acc_y [cm/s^2],acc_z [cm/s^2]", *rows])], 100.0, None)


def revolutions(folder: Path, log: HandLog) -> Foreign:
    """A gyroscope in revolutions per minute."""
    rows = [",".join(row) for row in si_rows(log, 1 / G, 30 / np.pi)]
    return Foreign([write_lines(folder / "spin.csv", [
        "t_s,ax_g,ay_g,az_g,gx_rpm,gy_rpm,gz_rpm", *rows])], 1 / G, 30 / np.pi)


def magnetometer_first(folder: Path, log: HandLog) -> Foreign:
    """No header: time, magnetometer in µT, accelerometer, gyroscope in °/s."""
    north = np.cross(log.acc / np.linalg.norm(log.acc, axis=1, keepdims=True), [0.3, -0.5, 0.81])
    field = 48 * north + 21
    rows = [" ".join([row[0], *(f"{v:.2f}" for v in b), *row[1:]])
            for row, b in zip(si_rows(log, 1, 1 / DEG), field, strict=True)]
    return Foreign([write_lines(folder / "nine.txt", rows)], 1.0, 1 / DEG)


def named_directions(folder: Path, log: HandLog) -> Foreign:
    """Forward, left, up; roll, pitch and yaw rate."""
    rows = [",".join(row) for row in si_rows(log, 1 / G, 1 / DEG)]
    return Foreign([write_lines(folder / "vehicle.csv", [
        "Time (s),Forward (g),Left (g),Up (g),Roll rate (deg/s),Pitch rate (deg/s),"
        "Yaw rate (deg/s)", *rows])], 1 / G, 1 / DEG)


def two_bytes(folder: Path, log: HandLog) -> Foreign:
    """High and low byte of each number under the names of the registers, decimal."""
    rows = []
    for t, counts in zip(log.time_s, counts_of(log), strict=True):
        raw = b"".join(struct.pack(">h", max(-32768, min(32767, int(v)))) for v in counts)
        rows.append(",".join([str(round(t * 1000)), *map(str, raw)]))
    head = "ms," + ",".join(f"REG{0x3B + i:02X}" for i in range(12))
    return Foreign([write_lines(folder / "i2c.csv", [head, *rows])], 16384 / G, 131.072 / DEG)


def volts(folder: Path, log: HandLog) -> Foreign:
    """ADXL335 behind a converter: 1.65 V is nothing, 0.33 V are 1 g."""
    rows = [",".join([f"{t:.3f}", *(f"{1.65 + 0.33 * v / G:.5f}" for v in a)])
            for t, a in zip(log.time_s, log.acc, strict=True)]
    return Foreign([write_lines(folder / "adxl335.csv", ["time_s,x_V,y_V,z_V", *rows])], 0.33 / G,
                   None)


def newest_first(folder: Path, log: HandLog) -> Foreign:
    """A dashboard shows the last sample first."""
    rows = [",".join([f"{datetime.fromtimestamp(EPOCH_S + t, UTC):%Y-%m-%d %H:%M:%S.%f}"[:-3],
                      *row[1:]]) for t, row in zip(log.time_s, si_rows(log), strict=True)]
    return Foreign([write_lines(folder / "grafana.csv", [
        "Time,ax,ay,az,gx,gy,gz", *reversed(rows)])], 1.0, 1.0)


def thingspeak(folder: Path, log: HandLog) -> Foreign:
    """Fields by number."""
    rows = [",".join([f"{datetime.fromtimestamp(EPOCH_S + t, UTC):%Y-%m-%dT%H:%M:%S.%f}"[:-3]
                      + "+00:00", str(i + 1), *row[1:]])
            for i, (t, row) in enumerate(zip(log.time_s, si_rows(log, 1, 1 / DEG), strict=True))]
    return Foreign([write_lines(folder / "feeds.csv", [
        "created_at,entry_id,field1,field2,field3,field4,field5,field6", *rows])], 1.0, 1 / DEG)


def floats_in_hexadecimal(folder: Path, log: HandLog) -> Foreign:
    """`Serial.print(*(uint32_t*)&ax, HEX)`: numbers of IEEE 754, and a clock in whole numbers."""
    rows = [f"{round(1000 * t):X}," + ",".join(
        f"{int(word):X}" for word in np.array(row, ">f4").view(">u4"))
        for t, row in zip(log.time_s, np.hstack([log.acc, log.gyr]), strict=True)]
    return Foreign([write_lines(folder / "port.txt", [
        "millis,ax,ay,az,gx,gy,gz", *rows])], 1.0, 1.0)


def names_in_the_rows(folder: Path, log: HandLog) -> Foreign:
    """FitCSVTool: a name, a number in quotes and a unit for each field, under `Field 1,Value 1`."""
    head = ["Type", "Local Number", "Message", *(
        f"{part} {i}" for i in range(1, 6) for part in ("Field", "Value", "Units"))]
    rows = [f'Data,{number},{name}_data,timestamp,"{912345678 + int(t)}",s,'
            f'timestamp_ms,"{round(1000 * t) % 1000}",ms,' + ",".join(
                f'calibrated_{part}_{axis},"{v:.4f}",{unit}' for axis, v in zip(
                    "xyz", row, strict=True)) + ","
            for t, a, w in zip(log.time_s, log.acc / G * 1000, log.gyr / DEG, strict=True)
            for number, name, part, row, unit in ((3, "accelerometer", "accel", a, "mG"),
                                                  (4, "gyroscope", "gyro", w, "deg/s"))]
    return Foreign([write_lines(folder / "activity.csv", [
        ",".join(head) + ",", 'Data,0,file_id,serial_number,"3941",' + 12 * ",", *rows])],
        1000 / G, 1 / DEG)


UNSEEN: dict[str, Callable[[Path, HandLog], Foreign]] = {
    tool.__name__: tool for tool in (
        mavlink_dump, nmea, line_protocol, markdown, html, yaml_lines, in_turn, json_arrays,
        minutes, unicode_text, typographic_minus, gals, revolutions, magnetometer_first,
        named_directions, newest_first, thingspeak, floats_in_hexadecimal, names_in_the_rows)
}
UNSEEN_REFUSED: dict[str, tuple[Callable[[Path, HandLog], Foreign], str]] = {
    "transposed": (transposed, "each row is a channel .*Transpose"),
    "two_bytes": (two_bytes, "are the high and the low byte"),
    "volts": (volts, "volts .*Subtract these and divide by 0.33"),
}
