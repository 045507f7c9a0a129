"""Tables with a row for each sample: names, units, separators, alphabets and numbers."""

import io
from pathlib import Path

import numpy as np
from scipy.io import savemat

from tests.pipeline.guess.foreign import (
    DEG,
    EPOCH_S,
    Foreign,
    G,
    Sample,
    Values,
    Writer,
    comma,
    counts_of,
    per_triad,
    rows,
    samples,
    write_lines,
)
from tests.pipeline.guess.hand_log import HandLog

NINE_ZEROS = ",".join(["0.0"] * 9)
MANY_SETTINGS = "\n".join(f'"setting_{i}",{i}' for i in range(90))
PER_COUNT = {"acc": 16384 / G, "gyr": 131.072 / DEG}


def spaced(sample: Sample) -> str:
    return f"{sample.t:.3f} {sample.a: .6f} {sample.w: .6f}"


def lose_readings(lines: list[str]) -> None:
    """NaN, nothing and null in three rows."""
    for at, word in ((40, "NaN"), (900, ""), (2500, "null")):
        cells = lines[at].split(",")
        lines[at] = ",".join([cells[0], *[word] * 6, *cells[7:]])


def lose_samples(lines: list[str]) -> None:
    """Rows that are lost, and a spreadsheet's error in one reading of a few."""
    rng = np.random.default_rng(4)
    kept = []
    for line in lines:
        cells = line.split(";")
        if rng.random() < 0.02:
            cells[int(rng.integers(1, 7))] = "#N/A"
        if rng.random() > 0.06:
            kept.append(";".join(cells))
    lines[:] = kept


def cut_a_line(lines: list[str]) -> None:
    """What a card holds after power was lost."""
    lines[700] = lines[700][:9] + "\0" * 512
    lines.append("\0" * 512)


def begin_again(lines: list[str]) -> None:
    """The header once more, where the logger was started anew."""
    lines.insert(2700, "Time,X,Y,Z,X,Y,Z")


def event_lines(lines: list[str]) -> None:
    """Words in the cells of some rows, and a last line that is cut off."""
    lines[400::400] = [f"{line}\n{line.partition(',')[0]},EVENT,button,,,,"
                       for line in lines[400::400]]
    lines[-1] = lines[-1][:20]


def attitude(sample: Sample) -> Values:
    """A unit quaternion that turns as the readings do; the accelerometer is in m/s²."""
    four = np.append(np.array(sample.a) / G + 0.3, np.linalg.norm(sample.a) / G)
    return Values(four / np.linalg.norm(four))


def field_beside(sample: Sample) -> Values:
    """A magnetometer, µT."""
    up = np.array(sample.a) / np.linalg.norm(sample.a)
    return Values(48 * np.cross(up, [0.3, -0.5, 0.81]) + 21)


def unsigned(folder: Path, log: HandLog) -> Foreign:
    counts = counts_of(log, 4096, 65.536) % 65536
    lines = ["\t".join(map(str, (round(1000 * t), *row)))
             for t, row in zip(log.time_s, counts, strict=True)]
    return Foreign([write_lines(folder / "dump.txt", lines)], 4096 / G, 65.536 / DEG)


def matlab(folder: Path, log: HandLog) -> Foreign:
    """A struct, as `data.acc = ...` makes it."""
    savemat(folder / "cal.mat", {"data": {"t": log.time_s, "acc": log.acc, "gyro": log.gyr}})
    return Foreign([folder / "cal.mat"])


def nine_unnamed(folder: Path, log: HandLog) -> Foreign:
    """No header: a counter, then counts of gyroscope, magnetometer and accelerometer."""
    up = log.acc / np.linalg.norm(log.acc, axis=1, keepdims=True)
    field = np.rint(300 * np.cross(up, [0.2, 0.9, -0.4]) + [40, -90, 15]).astype(int)
    lines = ["\t".join(map(str, (i % 256, *c[3:], *m, *c[:3])))
             for i, (c, m) in enumerate(zip(counts_of(log, 8192.0, 65.536), field, strict=True))]
    return Foreign([write_lines(folder / "dump9.txt", lines)], 8192 / G, 65.536 / DEG, log.rate_hz)


def mt_manager(folder: Path, log: HandLog) -> Foreign:
    """The counter is the clock, and it wraps."""
    text = io.StringIO()
    counter = (65_500 + np.arange(len(log.time_s))) % 65536
    np.savetxt(text, np.column_stack([counter, log.acc, log.gyr, np.full((len(counter), 2), 0.5)]),
               "%.8g", "\t", comments="", header=(
        f"// Start Time: Unknown\n// Update Rate: {log.rate_hz}Hz\n"
        "PacketCounter\tAcc_X\tAcc_Y\tAcc_Z\tGyr_X\tGyr_Y\tGyr_Z\tMag_X\tRoll"))
    return Foreign([write_lines(folder / "MT_0001.txt", text.getvalue().splitlines())])


def xsens_header(folder: Path, log: HandLog) -> Foreign:
    """MT Manager: comments with //, fine time in 1e-4 s, quaternions beside."""
    return rows("MT_03782EBF-000.txt", (
        "// General information:\n//  MT Manager version: 2021.4\n// Device information:\n"
        f"//  DeviceId: 03782EBF\n//  Update Rate: {log.rate_hz}Hz\n"
        "PacketCounter\tSampleTimeFine\tQuat_q0\tQuat_q1\tQuat_q2\tQuat_q3\tAcc_X\tAcc_Y\tAcc_Z"
        "\tGyr_X\tGyr_Y\tGyr_Z\tMag_X\tMag_Y\tMag_Z"),
        lambda s: f"{(65_000 + s.i) % 65536:05d}\t{s.t * 10_000:.0f}\t0.70711\t0.0\t0.70711\t0.0\t"
                  f"{s.a:\t.6f}\t{s.w:\t.6f}\t0.4\t-0.2\t0.9", end="\r\n")(folder, log)


def start_and_rate(folder: Path, log: HandLog) -> Foreign:
    """Empatica's manner: start and rate stand above the readings, once in every column."""
    return rows("ACC.csv", ", ".join(["1714557600.000000"] * 3) + "\n"
                + ", ".join([f"{log.rate_hz:.6f}"] * 3),
                lambda s: f"{Values(s.c[:3]):,d}", 4096 / G, None)(folder, log)


def increments(folder: Path, log: HandLog) -> Foreign:
    """Delta velocities in m/s and delta angles in rad, as navigation sensors give them."""
    per = 1 / log.rate_hz
    return rows("nav.csv", "time,dvx,dvy,dvz,dax,day,daz",
                lambda s: f"{s.t:.3f},{s.a:,.7f},{s.w:,.7f}", per, per)(folder, log)


def footer(folder: Path, log: HandLog) -> Foreign:
    """Statistics below the rows."""
    values = np.hstack([log.acc / G, log.gyr / DEG])
    below = [f"{name},{Values(of(values, axis=0)):,.5f}" for name, of in (
        ("Mean", np.mean), ("Std", np.std), ("Min", np.min), ("Max", np.max))]
    return rows("report.csv", "Measurement report\nSensor: GY-521\n\n"
                "Time (s),aX (g),aY (g),aZ (g),gX (deg/s),gY (deg/s),gZ (deg/s)", lambda s: s.s,
                1 / G, 1 / DEG, change=lambda lines: lines.extend(
                    ["", "Statistics", *below, "End of file"]))(folder, log)


def low_resolution(folder: Path, log: HandLog) -> Foreign:
    """Ten bits of 4 g and two decimals of a degree per second."""
    return rows("toy.csv", "sec,accX,accY,accZ,gyroX,gyroY,gyroZ", lambda s: (
        f"{s.t:.2f},{Values(round(v * 128) / 128 for v in s.a):,.3f},{s.w:,.2f}"),
        1 / G, 1 / DEG)(folder, log)


def box_drawn(folder: Path, log: HandLog) -> Foreign:
    """A table as ``sqlite3 -box`` prints it, in cm/s²."""
    names = ["t", *(f"{kind}_{axis}" for kind in ("acc", "gyr") for axis in "xyz")]
    bars = ["┬".join(7 * ["─" * 12]).join(ends) for ends in ("┌┐", "├┤", "└┘")]
    head, *lines = ["│".join(f" {cell:<10} " for cell in cells).join("││")
                    for cells in (names, *(each.cells for each in samples(log, 100.0)))]
    return Foreign([write_lines(folder / "box.txt", [bars[0], head, bars[1], *lines, bars[2]])],
                   100.0)


def two_clocks(folder: Path, log: HandLog) -> Foreign:
    """Two sensors side by side, each with its clock, the gyroscope at half the rate."""
    half = [f"{each.t:.4f},{each.w:,.6f}" for each in samples(log)[::2]]
    return rows("merged.csv", "time_acc,acc_x,acc_y,acc_z,time_gyr,gyr_x,gyr_y,gyr_z", lambda s: (
        f"{s.t:.3f},{s.a:,.6f},{half[s.i] if s.i < len(half) else ',,,'}"))(folder, log)


UNNAMED: dict[str, Writer] = {
    "unsigned": unsigned, "nine_unnamed": nine_unnamed,
    "offset_binary": per_triad(
        {"imu_acc.mat": "", "imu_gyro.mat": ""}, "",
        lambda t, v: f"{t:.7e}   {Values(round(x + 32768) for x in v):   .7e}", 415, 4778),
    "no_header_no_time": rows("imu.log", "", lambda s: f"{s.a: .5f} {s.w: .5f}", timed=False),
    "magnetometer_first": rows("nine.txt", "", lambda s: (
        f"{s.t:.3f} {field_beside(s): .2f} {s.a: .6f} {s.w: .6f}"), gyr=1 / DEG),
    "unnamed_quaternion": rows("fusion.txt", "", lambda s: (
        f"{s.t:.3f} {attitude(Sample(s.i, s.t, Values(G * v for v in s.a), s.w)): .5f} "
        f"{s.a: .5f} {s.w: .5f}"), 1 / G, 1 / DEG),
    # x of both sensors, y of both, z of both
    "in_turn": rows("pairs.dat", "", lambda s: " ".join(
        s.cells[k] for k in (0, 1, 4, 2, 5, 3, 6)), gyr=1 / DEG),
    "json_arrays": rows("rows.jsonl", "", lambda s: f"[{', '.join(s.cells)}]"),
    # what a board says when it starts, dates among it
    "messages_with_numbers": rows(
        "boot.csv", "ets Jul 29 2019 12:21:46\nrst:0x1 (POWERON_RESET),boot:0x13\n"
        "configsip: 0, SPIWP:0xee", lambda s: f"{1000 * s.t:.0f},{s.a:,.4f},{s.w:,.4f}",
        gyr=1 / DEG),
    # a counter of one byte before the clock, a checksum behind, the first line cut
    "radio": rows("radio.log", "02,-881,12,7F", lambda s: (
        f"0x1A,{s.i % 256},{1000 * s.t:.0f},{s.c:,d},{s.i * 73 % 256:02X}"), 8192 / G,
        65.536 / DEG),
    # `ros2 topic echo --csv`: seconds beside nanoseconds, zeros of covariances
    "ros2_csv": rows("imu.csv", "", lambda s: (
        f"{EPOCH_S + int(s.t)},{s.t % 1 * 1e9:.0f},imu_link,0.0,0.0,0.0,1.0,{NINE_ZEROS},"
        f"{s.w:,},{NINE_ZEROS},{s.a:,},{NINE_ZEROS}")),
}

NAMED: dict[str, Writer] = {
    "matlab": matlab, "mt_manager": mt_manager, "xsens_header": xsens_header,
    "increments": increments, "footer": footer, "low_resolution": low_resolution,
    "box_drawn": box_drawn, "two_clocks": two_clocks, "start_and_rate": start_and_rate,
    # blanks of any number between right-aligned columns, gzip
    "gz_blanks": rows(
        "fortran.dat.gz", "      TIME        AX        AY        AZ     GX    GY    GZ",
        lambda s: "".join(f"{cell:>14}" for cell in s.cells), gyr=1 / DEG),
    "arduino": rows("serial.csv", "millis,ax,ay,az,gx,gy,gz",
                    lambda s: f"{1000 * s.t:.0f},{s.c:,d}", **PER_COUNT),
    "gyroscope_first": rows("imu.txt", "t wx wy wz tx ty tz",
                            lambda s: f"{s.t:.7g} {s.w: .7g} {s.a: .7g}"),
    # blackbox_decode's names have a blank in front, and flags are text
    "blackbox": rows(
        "LOG00001.01.csv", "loopIteration, time (us), axisP[0], axisP[1], axisP[2], gyroADC[0], "
        "gyroADC[1], gyroADC[2], accSmooth[0], accSmooth[1], accSmooth[2], flightModeFlags (flags)",
        lambda s: f"{s.i}, {s.t * 1e6:.0f}, 1, 2, 3, {s.w:, .3f}, {Values(s.c[:3]):, d}, "
                  "ANGLE_MODE", 2048 / G, 1 / DEG),
    # the CSV of Betaflight's explorer: a hundred lines of settings in front
    "betaflight_header_block": rows(
        "btfl_001.bbl.csv", '"Product","Blackbox flight data recorder by Nicholas Sherlock"\n'
        '"firmwareType","Cleanflight"\n"looptime",125\n"acc_1G",2048\n"gyro_scale","0x3f800000"\n'
        f'{MANY_SETTINGS}\n"loopIteration","time","axisP[0]","axisP[1]","axisP[2]","gyroADC[0]",'
        '"gyroADC[1]","gyroADC[2]","accSmooth[0]","accSmooth[1]","accSmooth[2]","flightModeFlags"',
        lambda s: f"{s.i},{s.t * 1e6:.0f},1,-2,3,{s.w:,.3f},{Values(s.c[:3]):,d},0", 2048 / G,
        1 / DEG),
    "phyphox_absolute": rows(
        "Raw Data.csv", '"Time (s)","Acceleration x (m/s^2)","Acceleration y (m/s^2)",'
        '"Acceleration z (m/s^2)","Absolute acceleration (m/s^2)"',
        lambda s: f"{s.t:.9E},{s.a:,.9E},{np.linalg.norm(s.a):.9E}", 1.0, None),
    # lines of text before the header and between the rows
    "arduino_noise": rows(
        "capture.csv", "Connected to COM3\nStarting...\nmillis,ax,ay,az,gx,gy,gz",
        lambda s: f"{1000 * s.t:.0f},{s.c:,d}", **PER_COUNT, change=lambda lines: (
            lines.insert(700, "FIFO overflow!"), lines.insert(2000, "FIFO overflow!"))),
    "bosch": rows("BMI270_Gen2_log.csv", "Time[ms];Accel_X[g];Accel_Y[g];Accel_Z[g];Gyro_X[dps];"
                  "Gyro_Y[dps];Gyro_Z[dps];Temperature[degC]", lambda s: (
                      f"{s.t * 1000:.1f};{s.a:;.5f};{s.w:;.5f};24.5"), 1 / G, 1 / DEG),
    "invensense": rows("icm42688.csv", "TIMESTAMP_US,ACCEL_X,ACCEL_Y,ACCEL_Z,GYRO_X,GYRO_Y,GYRO_Z,"
                       "TEMP", lambda s: f"{s.t * 1e6:.0f},{s.c:,d},4120", 2048 / G, 16.384 / DEG),
    "vectornav": rows(
        "vn100.csv", "TimeStartup,Yaw,Pitch,Roll,UncompAccX,UncompAccY,UncompAccZ,UncompGyroX,"
        "UncompGyroY,UncompGyroZ,Pressure", lambda s: (
            f"{(12 + s.t) * 1e9:.0f},10.0,-1.0,0.5,{s.a:,.6f},{s.w:,.6f},101.325")),
    # `rostopic echo -p /imu`: every field, covariances too
    "rostopic_echo": rows("imu.csv", ",".join([
        "%time,field.header.seq,field.header.stamp,field.header.frame_id",
        *(f"field.orientation.{a}" for a in "xyzw"),
        *(f"field.orientation_covariance{i}" for i in range(9)),
        *(f"field.{name}{part}" for name in ("angular_velocity", "linear_acceleration")
          for part in (".x", ".y", ".z", *(f"_covariance{i}" for i in range(9))))]), lambda s: (
        f"{EPOCH_S * 10**9 + round(s.t * 1e9)},{s.i},{EPOCH_S * 10**9 + round(s.t * 1e9)},imu_link,"
        f"0.0,0.0,0.0,1.0,{NINE_ZEROS},{s.w:,.8f},{NINE_ZEROS},{s.a:,.8f},{NINE_ZEROS}")),
    # Excel's `CSV UTF-8`: a byte order mark, semicolons, decimal commas, CRLF, empty rows
    "excel_bom": rows(
        "Mappe1.csv", "Zeit [s];Beschl. X [m/s²];Beschl. Y [m/s²];Beschl. Z [m/s²];"
        "Drehrate X [°/s];Drehrate Y [°/s];Drehrate Z [°/s]", lambda s: comma(";".join(s.cells)),
        gyr=1 / DEG, encoding="utf-8-sig", end="\r\n",
        change=lambda lines: lines.extend([";;;;;;"] * 2)),
    "excel_sep": rows("export.csv", "sep=;\nt_ms;ax_g;ay_g;az_g;gx_dps;gy_dps;gz_dps",
                      lambda s: f"{1000 * s.t:.0f};{s.a:;.6f};{s.w:;.6f}", 1 / G, 1 / DEG),
    # Fortran's exponents with a D, and a C in front of the names
    "fortran": rows("fort.21", "C  TIME/S  FX/(M/S2)  FY  FZ  WX/(RAD/S)  WY  WZ", lambda s: (
        "  ".join(f"{float(cell):.7E}" for cell in s.cells).replace("E", "D"))),
    # pandas: the first column has no name, so that the header begins with a tab
    "index_without_a_name": rows(
        "df.tsv", "\tt_s\tIMU.acc.x\tIMU.acc.y\tIMU.acc.z\tIMU.gyr.x\tIMU.gyr.y\tIMU.gyr.z",
        lambda s: "\t".join([str(s.i), *s.cells])),
    "pandas_index": rows("frame.csv", ",t,accel_x,accel_y,accel_z,gyro_x,gyro_y,gyro_z",
                         lambda s: f"{s.i},{s.s}"),
    # Origin: long names, units and comments, with what each line holds in its first cell
    "three_lines_of_names": rows(
        "Book1.dat", "Long Name\tTime" + "\tAcceleration" * 3 + "\tAngular rate" * 3
        + "\nUnits\tms" + "\tmg" * 3 + "\tdps" * 3 + "\nComments\t" + "\tx\ty\tz" * 2,
        lambda s: f"\t{1000 * s.t:.0f}\t{s.a:\t.6f}\t{s.w:\t.6f}", 1000 / G, 1 / DEG),
    # two levels of columns, as pandas writes them
    "nested_header": rows("multi.csv", ",accel,accel,accel,gyro,gyro,gyro\ntime,x,y,z,x,y,z",
                          lambda s: s.s, 1 / G, 1 / DEG),
    # LabVIEW: names, units in a line of their own, tabs
    "two_line_header": rows(
        "labview.lvm", "LabVIEW Measurement\nSeparator\tTab\n***End_of_Header***\n"
        "X_Value\tAccX\tAccY\tAccZ\tGyrX\tGyrY\tGyrZ\ns\tg\tg\tg\tdeg/s\tdeg/s\tdeg/s",
        lambda s: "\t".join(s.cells), 1 / G, 1 / DEG),
}
