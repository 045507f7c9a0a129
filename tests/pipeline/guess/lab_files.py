"""Logs of laboratories and of boards on a line, each of a class that a first try failed on."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.pipeline.guess.foreign_files import DEG, Foreign, G
from tests.pipeline.guess.hand_log import HandLog
from tests.pipeline.guess.text_rows import counts_of, si_rows, write_lines


def labview_measurement(folder: Path, log: HandLog) -> Foreign:
    """LVM: settings in rows of numbers above the header, a column of comments that rows leave out.
    """
    def row(name: str, cell: str) -> str:
        return "\t".join([name, *[cell] * 6, ""])

    head = ["LabVIEW Measurement\t", "Decimal_Separator\t,", "***End_of_Header***\t", "\t",
            row("Samples", "100"), row("Date", "2024/05/01"), row("X0", "0,00E+0"),
            row("Delta_X", "0,010000"), "***End_of_Header***\t\t\t\t\t\t\t",
            "X_Value\tAccel_X\tAccel_Y\tAccel_Z\tGyro_X\tGyro_Y\tGyro_Z\tComment"]
    rows = ["\t".join(cells).replace(".", ",") for cells in si_rows(log, 1 / G, 1 / DEG)]
    return Foreign([write_lines(folder / "m.lvm", [*head, *rows], end="\r\n")], 1 / G, 1 / DEG)


def groups_with_units(folder: Path, log: HandLog) -> Foreign:
    """A name with its unit before three numbers, and a clock that nothing names."""
    rows = [f"[{1000 * t:8.0f}] Acc[mg]: {a[0]:5.0f} {a[1]:5.0f} {a[2]:5.0f} | Gyr[mdps]: "
            f"{w[0]:7.0f} {w[1]:7.0f} {w[2]:7.0f} | T[degC]: 24.5"
            for t, a, w in zip(log.time_s, log.acc / G * 1000, log.gyr / DEG * 1000, strict=True)]
    return Foreign([write_lines(folder / "st.log", ["WHO_AM_I = 0x6C", *rows])], 1000 / G,
                   1000 / DEG)


def durations(folder: Path, log: HandLog) -> Foreign:
    """A timetable of MATLAB: `0.02 sec`."""
    rows = [",".join([f"{row[0]} sec", *row[1:]]) for row in si_rows(log)]
    return Foreign([write_lines(folder / "tt.csv", [
        "Time,Acceleration_1,Acceleration_2,Acceleration_3,AngularVelocity_1,AngularVelocity_2,"
        "AngularVelocity_3", *rows])])


def lost_samples(folder: Path, log: HandLog) -> Foreign:
    """Rows that were lost, and a spreadsheet's error in one reading of a few."""
    rng = np.random.default_rng(4)
    rows = []
    for row in si_rows(log, 1 / G, 1 / DEG):
        cells = [*row]
        if rng.random() < 0.02:
            cells[int(rng.integers(1, 7))] = "#N/A"
        if rng.random() > 0.06:
            rows.append(";".join(cells))
    return Foreign([write_lines(folder / "lossy.csv", [
        "Time_s;Ax_g;Ay_g;Az_g;Gx_dps;Gy_dps;Gz_dps", *rows])], 1 / G, 1 / DEG)


def radio(folder: Path, log: HandLog) -> Foreign:
    """A counter of one byte before the clock, a checksum behind, the first line cut."""
    rows = [",".join(map(str, ("0x1A", i % 256, round(1000 * t), *counts, f"{i * 73 % 256:02X}")))
            for i, (t, counts) in enumerate(zip(log.time_s, counts_of(log, 8192.0, 65.536),
                                                strict=True))]
    return Foreign([write_lines(folder / "radio.log", ["02,-881,12,7F", *rows])], 8192 / G,
                   65.536 / DEG)


def bno055_counts(folder: Path, log: HandLog) -> Foreign:
    """100 counts per m/s² and 16 per °/s, which lie close to 16.384."""
    rows = [",".join([f"{t:.3f}", *map(str, counts)]) for t, counts in
            zip(log.time_s, counts_of(log, 100 * G, 16.0), strict=True)]
    return Foreign([write_lines(folder / "bno.csv", [
        "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z", *rows])], 100.0, 16 / DEG)


def fahrenheit(folder: Path, log: HandLog) -> Foreign:
    """Columns in no order, and a temperature that is not in °C."""
    rows = [",".join([row[6], row[2], "77.5", row[4], row[3], row[5], row[1], row[0]])
            for row in si_rows(log, 1 / G, 1 / DEG)]
    return Foreign([write_lines(folder / "log.csv", ["gz,ay,temp_F,gx,az,gy,ax,time_s", *rows])],
                   1 / G, 1 / DEG)


def two_clocks(folder: Path, log: HandLog) -> Foreign:
    """Two sensors side by side, each with its clock, the gyroscope at half the rate."""
    half = [f"{t:.4f},{w[0]:.6f},{w[1]:.6f},{w[2]:.6f}"
            for t, w in zip(log.time_s[::2], log.gyr[::2], strict=True)]
    rows = [f"{','.join(row[:4])},{half[i] if i < len(half) else ',,,'}"
            for i, row in enumerate(si_rows(log))]
    return Foreign([write_lines(folder / "merged.csv", [
        "time_acc,acc_x,acc_y,acc_z,time_gyr,gyr_x,gyr_y,gyr_z", *rows])])


def row_names(folder: Path, log: HandLog) -> Foreign:
    """R's write.table: quoted row names, which the header has no name for."""
    head = " ".join(f'"{name}"' for name in ("time", "acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y",
                                             "gyr_z"))
    rows = [f'"{i}" {" ".join(row)}' for i, row in enumerate(si_rows(log, 1.0, 1 / DEG), 1)]
    return Foreign([write_lines(folder / "r.txt", [head, *rows])], 1.0, 1 / DEG)


def glued_units(folder: Path, log: HandLog) -> Foreign:
    """A unit without a blank behind every number, of which none may be cut at its point."""
    rows = [f"ESF-MEAS t={1000 * t:.0f}ms " + " ".join(
        f"{name}{axis}={v:.4f}{unit}" for name, unit, values in (
            ("acc", "m/s^2", a), ("gyr", "deg/s", w)) for axis, v in zip("XYZ", values, strict=True)
    ) for t, a, w in zip(log.time_s, log.acc, log.gyr / DEG, strict=True)]
    return Foreign([write_lines(folder / "ucenter.txt", rows)], 1.0, 1 / DEG)


def narrow_blanks(folder: Path, log: HandLog) -> Foreign:
    """A French spreadsheet: narrow blanks between thousands, decimal commas, a row of units."""
    rows = [";".join(f"{float(cell):,.2f}".replace(",", "\u202f").replace(".", ",")
                     for cell in (1000 * float(row[0]), *row[1:]))
            for row in si_rows(log, 1000 / G, 1000 / DEG)]
    return Foreign([write_lines(folder / "classeur.csv", [
        "Temps;Acc X;Acc Y;Acc Z;Gyro X;Gyro Y;Gyro Z", "ms;mg;mg;mg;mdps;mdps;mdps", *rows])],
        1000 / G, 1000 / DEG)


def sql_dump(folder: Path, log: HandLog) -> Foreign:
    """Statements of a data base: nothing names their numbers."""
    rows = [f"INSERT INTO imu VALUES({i},{1714557600 + float(row[0]):.3f},{','.join(row[1:])});"
            for i, row in enumerate(si_rows(log), 1)]
    return Foreign([write_lines(folder / "dump.sql", [
        "PRAGMA foreign_keys=OFF;", "BEGIN TRANSACTION;", *rows, "COMMIT;"])])


def whole_mg(folder: Path, log: HandLog) -> Foreign:
    """Whole mg without a unit beside a gyroscope that is no BNO055's."""
    rows = [",".join([f"{t:.3f}", *map(str, counts)]) for t, counts in
            zip(log.time_s, counts_of(log, 1000.0, 32.768), strict=True)]
    return Foreign([write_lines(folder / "board.csv", [
        "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z", *rows])], 1000 / G, 32.768 / DEG)


def plotter(folder: Path, log: HandLog) -> Foreign:
    """Lines for the Arduino plotter in mg and m°/s, without units or times."""
    rows = ["\t".join(f"{name}:{v:.1f}" for name, v in zip(
        ("AccX", "AccY", "AccZ", "GyroX", "GyroY", "GyroZ"), (*a, *w), strict=True))
        for a, w in zip(log.acc / G * 1000, log.gyr / DEG * 1000, strict=True)]
    return Foreign([write_lines(folder / "plotter.txt", rows)], 1000 / G, 1000 / DEG)


def wide_letters(folder: Path, log: HandLog) -> Foreign:
    """UTF-16 without its mark."""
    return Foreign([write_lines(folder / "win.csv", [
        "t_s,ax,ay,az,gx,gy,gz", *map(",".join, si_rows(log))], "utf-16-be")])


def event_lines(folder: Path, log: HandLog) -> Foreign:
    """Words in the cells of readings, in the first row already, and a last line that is cut off."""
    rows = [",".join(row) for row in si_rows(log)]
    rows[400::400] = [f"{row}\n{row.partition(',')[0]},EVENT,button,,,," for row in rows[400::400]]
    return Foreign([write_lines(folder / "events.csv", [
        "time_s,ax,ay,az,gx,gy,gz", "0,EVENT,button,,,,", *rows[:-1], rows[-1][:20]])])


def start_and_rate(folder: Path, log: HandLog) -> Foreign:
    """Empatica's manner: start and rate stand above the readings, once in every column."""
    rows = [",".join(map(str, row)) for row in np.rint(log.acc / G * 4096).astype(int)]
    return Foreign([write_lines(folder / "ACC.csv", [
        ", ".join(["1714557600.000000"] * 3), ", ".join([f"{log.rate_hz:.6f}"] * 3), *rows])],
        4096 / G, None)


def blocks(folder: Path, log: HandLog) -> Foreign:
    """The rests alone, each a block of gnuplot whose clock begins at 0."""
    lines = ["# poses of a board"]
    for pose in range(log.rest.max() + 1):
        at = np.flatnonzero(log.rest == pose)
        table = np.column_stack([log.time_s[at] - log.time_s[at[0]], log.acc[at], log.gyr[at]])
        lines += ["", "", f"# pose {pose}", *(" ".join(f"{v:.5f}" for v in row) for row in table)]
    return Foreign([write_lines(folder / "poses.dat", lines)])


def between_the_lines(folder: Path, log: HandLog) -> Foreign:
    """Adafruit's sketch of an ICM-20948: words between the lines, a unit behind three numbers."""
    lines = ["Adafruit ICM20948 test!", "Gyro range set to: 2000 degrees/s"]
    for a, w in zip(log.acc, log.gyr, strict=True):
        axes = [f"X: {v[0]:.3f} \tY: {v[1]:.3f} \tZ: {v[2]:.3f}" for v in (a, w)]
        lines += ["\t\tTemperature 24.03 deg C", "", f"\t\tAccel {axes[0]} m/s^2 ", "",
                  f"\t\tGyro {axes[1]} radians/s ", ""]
    return Foreign([write_lines(folder / "putty.log", lines)], rate_hz=log.rate_hz)


def both_sensors_in_the_file(folder: Path, log: HandLog) -> Foreign:
    """A file whose name ends in one sensor and whose columns name both."""
    rows = [",".join(row) for row in si_rows(log)]
    return Foreign([write_lines(folder / "Acc and Gyro.csv", [
        "t (s),acc x (m/s^2),acc y (m/s^2),acc z (m/s^2),gyr x (rad/s),gyr y (rad/s),"
        "gyr z (rad/s)", *rows])])


def a_value_a_line(folder: Path, log: HandLog) -> Foreign:
    """ESPHome's log."""
    names = [f"{sensor} {axis}" for sensor in ("Accel", "Gyro") for axis in "XYZ"]
    return Foreign([write_lines(folder / "esphome.log", [
        f"\x1b[0;36m[14:05:{int(t) % 60:02d}][D][sensor:094]: 'MPU6050 {name}': Sending state "
        f"{v:.5f} with 3 decimals of accuracy\x1b[0m" for t, row in zip(
            log.time_s, np.hstack([log.acc, log.gyr]), strict=True)
        for name, v in zip(names, row, strict=True)])])


def samples_beside_each_other(folder: Path, log: HandLog) -> Foreign:
    """All samples in one object of JSON."""
    path = folder / "all.json"
    path.write_text(json.dumps({f"a{i}": v for i, v in enumerate(log.acc[:100].ravel().tolist())}),
                    encoding="utf-8")
    return Foreign([path])


def packets_of_a_bus(folder: Path, log: HandLog) -> Foreign:
    """A logic analyser's."""
    return Foreign([write_lines(folder / "spi.csv", ["Time [s],Packet ID,MOSI,MISO", *(
        f"{t:.9f},{i},0x{i % 256:02X},0x{i * 7 % 256:02X}" for i, t in enumerate(log.time_s))])])


def sensors_in_uneven_turns(folder: Path, log: HandLog) -> Foreign:
    """Five rows of a gyroscope to one of an accelerometer."""
    rows = [f"Motion,{name},{1000 * t:.3f},{v[0]:.6f},{v[1]:.6f},{v[2]:.6f}"
            for i, (t, a, w) in enumerate(zip(log.time_s, log.acc, log.gyr, strict=True))
            for name, v in (("Accel", a), ("Gyro", w)) if name == "Gyro" or i % 5 == 0]
    return Foreign([write_lines(folder / "rs.csv", ["Module,Stream,t (ms),X,Y,Z", *rows])])


LAB: dict[str, Callable[[Path, HandLog], Foreign]] = {
    tool.__name__: tool for tool in (
        two_clocks,
        labview_measurement, groups_with_units, durations, lost_samples, radio, bno055_counts,
        fahrenheit, row_names, glued_units, narrow_blanks, sql_dump, whole_mg,
        plotter, wide_letters, event_lines, start_and_rate, blocks, between_the_lines,
        both_sensors_in_the_file, sensors_in_uneven_turns, a_value_a_line)
}
LAB_REFUSED: dict[str, tuple[Callable[[Path, HandLog], Foreign], str]] = {
    "samples_beside_each_other": (
        samples_beside_each_other, r"it has 300 columns .* Write a row for each sample"),
    "packets_of_a_bus": (packets_of_a_bus, r"with their bytes in hexadecimal"),
}
