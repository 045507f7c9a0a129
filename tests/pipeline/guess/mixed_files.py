"""Logs with more, less or other than one table of samples: two sensors, gaps, resets, events."""

import gzip
import json
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from tests.pipeline.guess.foreign_files import DEG, Foreign, G
from tests.pipeline.guess.hand_log import HandLog
from tests.pipeline.guess.text_rows import EPOCH_S, counts_of, si_rows, write_lines


def two_sensors(folder: Path, log: HandLog) -> Foreign:
    """Two units in one file; the first is taken, and that is said."""
    head = "time_ms,acc1_x,acc1_y,acc1_z,gyr1_x,gyr1_y,gyr1_z,acc2_x,acc2_y,acc2_z,gyr2_x,gyr2_y," \
           "gyr2_z"
    rows = [",".join([str(round(float(row[0]) * 1000)), *row[1:], *row[1:]])
            for row in si_rows(log)]
    return Foreign([write_lines(folder / "both_imus.csv", [head, *rows])])


def wide(folder: Path, log: HandLog) -> Foreign:
    """Sixty columns of a data logger, the sensor among them."""
    before = [f"ch{i}" for i in range(25)]
    after = [f"state_{i}" for i in range(28)]
    names = ["time", *before, "imu_accel_x", "imu_accel_y", "imu_accel_z", "imu_gyro_x",
             "imu_gyro_y", "imu_gyro_z", *after]
    rows = [",".join([row[0], *(f"{(i * 37 + j) % 11}" for j in range(25)), *row[1:],
                      *(f"{(i + j) % 5}" for j in range(28))])
            for i, row in enumerate(si_rows(log, 1, 1 / DEG))]
    return Foreign([write_lines(folder / "daq.csv", [",".join(names), *rows])], 1.0, 1 / DEG)


def missing_values(folder: Path, log: HandLog) -> Foreign:
    """NaN, nothing and null where a slower sensor had no sample, and in a few readings."""
    head = "timestamp,ax,ay,az,gx,gy,gz,temperature,pressure"
    rows = [",".join([*row, "25.1" if i % 10 == 0 else "", "1013.2" if i % 25 == 0 else "null"])
            for i, row in enumerate(si_rows(log))]
    for at, word in ((40, "NaN"), (900, ""), (2500, "null")):
        cells = rows[at].split(",")
        rows[at] = ",".join([cells[0], *[word] * 6, *cells[7:]])
    return Foreign([write_lines(folder / "merged.csv", [head, *rows])])


def time_resets(folder: Path, log: HandLog) -> Foreign:
    """The board was reset in the middle: millis begins again."""
    half = len(log.time_s) // 2
    rows = [",".join(map(str, (round((t - (log.time_s[half] if i >= half else 0)) * 1000), *row)))
            for i, (t, row) in enumerate(zip(log.time_s, counts_of(log), strict=True))]
    return Foreign([write_lines(folder / "reset.csv", ["millis,ax,ay,az,gx,gy,gz", *rows])],
                   16384 / G, 131.072 / DEG)


def duplicate_headers(folder: Path, log: HandLog) -> Foreign:
    """`X,Y,Z,X,Y,Z`, and the header again where the logger was started anew."""
    head = "Time,X,Y,Z,X,Y,Z"
    rows = [",".join(row) for row in si_rows(log)]
    return Foreign([write_lines(folder / "xyz.csv", [head, *rows[:2700], head, *rows[2700:]])])


def two_line_header(folder: Path, log: HandLog) -> Foreign:
    """LabVIEW: names, units in a line of their own, tabs."""
    return Foreign([write_lines(folder / "labview.lvm", [
        "LabVIEW Measurement", "Separator\tTab", "***End_of_Header***",
        "X_Value\tAccX\tAccY\tAccZ\tGyrX\tGyrY\tGyrZ", "s\tg\tg\tg\tdeg/s\tdeg/s\tdeg/s",
        *("\t".join(row) for row in si_rows(log, 1 / G, 1 / DEG))])], 1 / G, 1 / DEG)


def android_lines(folder: Path, log: HandLog) -> Foreign:
    """A line for each event of each sensor, as Android delivers them."""
    lines = []
    for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True):
        stamp = round((5000 + t) * 1e9)
        lines.append(f"{stamp},ACC,{a[0]:.6f},{a[1]:.6f},{a[2]:.6f}")
        lines.append(f"{stamp + 1000},GYR,{w[0]:.6f},{w[1]:.6f},{w[2]:.6f}")
    return Foreign([write_lines(folder / "events.csv", ["timestamp_ns,sensor,x,y,z", *lines])])


def shimmer(folder: Path, log: HandLog) -> Foreign:
    """Consensys: `sep=`, names, calibrated flags and units, each in a line; tabs."""
    names = ["Shimmer_5E_Timestamp_Unix_CAL", *(f"Shimmer_5E_Accel_LN_{a}_CAL" for a in "XYZ"),
             *(f"Shimmer_5E_Gyro_{a}_CAL" for a in "XYZ")]
    units = ["ms", *["m/(s^2)"] * 3, *["deg/s"] * 3]
    rows = ["\t".join([f"{(EPOCH_S + float(row[0])) * 1000:.3f}", *row[1:]]) + "\t"
            for row in si_rows(log, 1, 1 / DEG)]
    return Foreign([write_lines(folder / "shimmer.csv", ['"sep=\t"', "\t".join(names) + "\t",
                                                    "\t".join(units) + "\t", *rows])],
                   1.0, 1 / DEG)


def pandas_index(folder: Path, log: HandLog) -> Foreign:
    """DataFrame.to_csv: a column without a name in front."""
    rows = [",".join([str(i), *row]) for i, row in enumerate(si_rows(log))]
    return Foreign([write_lines(folder / "frame.csv",
                           [",t,accel_x,accel_y,accel_z,gyro_x,gyro_y,gyro_z", *rows])])


def gz_blanks(folder: Path, log: HandLog) -> Foreign:
    """Blanks of any number between right-aligned columns, gzip."""
    text = "\n".join("".join(f"{cell:>14}" for cell in row) for row in si_rows(log, 1, 1 / DEG))
    path = folder / "fortran.dat.gz"
    path.write_bytes(gzip.compress(("      TIME        AX        AY        AZ     GX    GY    GZ\n"
                                    + text + "\n").encode()))
    return Foreign([path], 1.0, 1 / DEG)


def nested_json(folder: Path, log: HandLog) -> Foreign:
    """One array of objects, times as ISO 8601."""
    values = [{"timestamp": datetime.fromtimestamp(EPOCH_S + t, UTC).isoformat(),
               "accelerometer": {"x": a[0], "y": a[1], "z": a[2]},
               "gyroscope": {"x": w[0], "y": w[1], "z": w[2]}}
              for t, a, w in zip(log.time_s.tolist(), log.acc.tolist(), log.gyr.tolist(),
                                 strict=True)]
    return Foreign([write_lines(folder / "web.json", [json.dumps(values)])])


def metawear(folder: Path, log: HandLog) -> Foreign:
    """MbientLab: a file for each sensor, three clocks."""
    files = []
    for name, unit, values in (("Accelerometer", "g", log.acc / G),
                               ("Gyroscope", "deg/s", log.gyr / DEG)):
        head = f"epoc (ms),timestamp (+0100),elapsed (s),x-axis ({unit}),y-axis ({unit})," \
               f"z-axis ({unit})"
        rows = [",".join([str(round((EPOCH_S + t) * 1000)),
                          f"{datetime.fromtimestamp(EPOCH_S + t, UTC):%Y-%m-%dT%H:%M:%S.%f}"[:-3],
                          f"{t:.3f}", *(f"{v:.4f}" for v in row)])
                for t, row in zip(log.time_s, values, strict=True)]
        files.append(write_lines(folder / f"MetaWear_2024_{name}.csv", [head, *rows]))
    return Foreign(files, 1 / G, 1 / DEG)


def low_resolution(folder: Path, log: HandLog) -> Foreign:
    """Ten bits of 4 g and two decimals of a degree per second."""
    steps = np.rint(log.acc / G * 128) / 128
    rows = [",".join([f"{t:.2f}", *(f"{v:.3f}" for v in a), *(f"{v:.2f}" for v in w / DEG)])
            for t, a, w in zip(log.time_s, steps, log.gyr, strict=True)]
    head = "sec,accX,accY,accZ,gyroX,gyroY,gyroZ"
    return Foreign([write_lines(folder / "toy.csv", [head, *rows])], 1 / G, 1 / DEG)


def box_drawn(folder: Path, log: HandLog) -> Foreign:
    """A table as ``sqlite3 -box`` prints it, in cm/s²."""
    names = ("t", "acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z")
    bars = ["┬".join(7 * ["─" * 12]).join(ends) for ends in ("┌┐", "├┤", "└┘")]
    head, *rows = ["│".join(f" {cell:<10} " for cell in cells).join("││")
                   for cells in (names, *si_rows(log, 100.0))]
    return Foreign([write_lines(folder / "box.txt", [bars[0], head, bars[1], *rows, bars[2]])],
                   100.0)


def runs_beside(folder: Path, log: HandLog) -> Foreign:
    """Two recordings side by side; each counts from 0."""
    names = ("Time (s)", "Acc X (m/s²)", "Acc Y (m/s²)", "Acc Z (m/s²)",
             "Gyro X (rad/s)", "Gyro Y (rad/s)", "Gyro Z (rad/s)")
    head = [f"Run {run}: {name}" for run in (1, 2) for name in names]
    half = int(np.argmax(log.rest == 9))
    parts = si_rows(log)[:half], si_rows(log)[half:]
    rows = [(*one, before[0], *other[1:]) for one, other, before in zip(
        *parts, parts[0], strict=True)]
    return Foreign([write_lines(folder / "runs.csv", [",".join(row) for row in (head, *rows)])])


MIXED: dict[str, Callable[[Path, HandLog], Foreign]] = {
    tool.__name__: tool for tool in (
        two_sensors, wide, missing_values, time_resets, duplicate_headers, two_line_header,
        android_lines, shimmer, pandas_index, gz_blanks, nested_json, metawear, low_resolution,
        box_drawn, runs_beside)
}
