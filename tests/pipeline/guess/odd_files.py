"""Logs of tools and sensors as people really write them: text noise, dialects, odd clocks."""

import zipfile
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from tests.pipeline.guess.foreign_files import DEG, Foreign, G
from tests.pipeline.guess.hand_log import HandLog
from tests.pipeline.guess.text_rows import EPOCH_S, counts_of, si_rows, write_lines


def phyphox_german(folder: Path, log: HandLog) -> Foreign:
    """Semicolons, decimal commas, and names in German."""
    with zipfile.ZipFile(folder / "phyphox 2024-03-11.zip", "w") as archive:
        for name, title, unit, values in (
                ("Beschleunigung", "Beschleunigung", "m/s^2", log.acc),
                ("Gyroskop", "Gyroskop", "rad/s", log.gyr)):
            head = ";".join(['"Zeit (s)"', *(f'"{title} {axis} ({unit})"' for axis in "xyz")])
            rows = [";".join(f"{v:.9E}".replace(".", ",") for v in (t, *row))
                    for t, row in zip(log.time_s, values, strict=True)]
            archive.writestr(f"{name}.csv", "\n".join([head, *rows]))
        archive.writestr("meta/time.csv", '"event";"experiment time";"system time"\n'
                                          '"START";0,000000000E0;1,710147E9\n')
    return Foreign([folder / "phyphox 2024-03-11.zip"])


def phyphox_absolute(folder: Path, log: HandLog) -> Foreign:
    """One CSV with the absolute value beside the axes."""
    head = ('"Time (s)","Acceleration x (m/s^2)","Acceleration y (m/s^2)","Acceleration z (m/s^2)",'
            '"Absolute acceleration (m/s^2)"')
    rows = [",".join(f"{v:.9E}" for v in (t, *a, np.linalg.norm(a)))
            for t, a in zip(log.time_s, log.acc, strict=True)]
    return Foreign([write_lines(folder / "Raw Data.csv", [head, *rows])], 1.0, None)


def sensor_logger_uncalibrated(folder: Path, log: HandLog) -> Foreign:
    """What the app computes stands beside the readings: gravity, and what is left without it."""
    force = G * log.acc / np.linalg.norm(log.acc, axis=1, keepdims=True)
    with zipfile.ZipFile(folder / "2024-03-11.zip", "w") as archive:
        for name, values in (
                ("TotalAcceleration", log.acc), ("Gyroscope", log.gyr),
                ("Accelerometer", log.acc - force), ("Gravity", force), ("Orientation", log.gyr)):
            rows = [f"{(EPOCH_S * 10**9) + round(t * 1e9)},{t:.7f},{z:.7g},{y:.7g},{x:.7g}"
                    for t, (x, y, z) in zip(log.time_s, values, strict=True)]
            archive.writestr(f"{name}.csv", "\n".join(["time,seconds_elapsed,z,y,x", *rows]))
        archive.writestr("Metadata.csv", "version,device name\n3,iPhone\n")
    return Foreign([folder / "2024-03-11.zip"])


def betaflight_header_block(folder: Path, log: HandLog) -> Foreign:
    """The CSV of Betaflight's explorer: a hundred lines of settings in front."""
    above = ['"Product","Blackbox flight data recorder by Nicholas Sherlock"',
             '"firmwareType","Cleanflight"', '"looptime",125', '"acc_1G",2048',
             '"gyro_scale","0x3f800000"', *(f'"setting_{i}",{i}' for i in range(90))]
    head = ('"loopIteration","time","axisP[0]","axisP[1]","axisP[2]","gyroADC[0]","gyroADC[1]",'
            '"gyroADC[2]","accSmooth[0]","accSmooth[1]","accSmooth[2]","flightModeFlags"')
    rows = [",".join([str(i), str(round(t * 1e6)), "1", "-2", "3", *(f"{v:.3f}" for v in w / DEG),
                      *(str(round(v)) for v in a / G * 2048), "0"])
            for i, (t, a, w) in enumerate(zip(log.time_s, log.acc, log.gyr, strict=True))]
    path = write_lines(folder / "btfl_001.bbl.csv", [*above, head, *rows])
    return Foreign([path], 2048 / G, 1 / DEG)


def serial_labels(folder: Path, log: HandLog) -> Foreign:
    """A sketch that prints `ax:123 ay:..`; no times."""
    rows = ["ax:{} ay:{} az:{} gx:{} gy:{} gz:{}".format(*row) for row in counts_of(log)]
    return Foreign([write_lines(folder / "putty.log", rows)], 16384 / G, 131.072 / DEG, log.rate_hz)


def serial_equals(folder: Path, log: HandLog) -> Foreign:
    rows = [f"t={round(t * 1000)}, aX = {a[0]:.3f}, aY = {a[1]:.3f}, aZ = {a[2]:.3f}, "
            f"gX = {w[0]:.4f}, gY = {w[1]:.4f}, gZ = {w[2]:.4f}"
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "serial_monitor.txt", rows)])


def tab_labels(folder: Path, log: HandLog) -> Foreign:
    """i2cdevlib's `a/g:` in front of tabs."""
    rows = ["\t".join(["a/g:", *map(str, row)]) for row in counts_of(log)]
    return Foreign([write_lines(folder / "mpu.txt", ["Initializing I2C devices...",
                                                "Testing device connections...",
                                                "MPU6050 connection successful", *rows])],
                   16384 / G, 131.072 / DEG, log.rate_hz)


def arduino_noise(folder: Path, log: HandLog) -> Foreign:
    """Lines of text before the header and between the rows."""
    rows = [",".join(map(str, (round(t * 1000), *row)))
            for t, row in zip(log.time_s, counts_of(log), strict=True)]
    rows.insert(700, "FIFO overflow!")
    rows.insert(2000, "FIFO overflow!")
    return Foreign([write_lines(folder / "capture.csv", [
        "Connected to COM3", "Starting...", "millis,ax,ay,az,gx,gy,gz", *rows])],
        16384 / G, 131.072 / DEG)


def arduino_ide_stamps(folder: Path, log: HandLog) -> Foreign:
    """`12:00:00.010 -> ` before every line, as the serial monitor puts it."""
    rows = [f"{datetime.fromtimestamp(EPOCH_S + t, UTC):%H:%M:%S.%f}"[:-3] + " -> "
            + ",".join(map(str, row)) for t, row in zip(log.time_s, counts_of(log), strict=True)]
    return Foreign([write_lines(folder / "monitor.txt", rows)], 16384 / G, 131.072 / DEG)


def xsens_header(folder: Path, log: HandLog) -> Foreign:
    """MT Manager: comments with //, fine time in 1e-4 s, quaternions beside."""
    head = ["// General information:", "//  MT Manager version: 2021.4",
            "// Device information:", "//  DeviceId: 03782EBF", f"//  Update Rate: {log.rate_hz}Hz",
            "PacketCounter\tSampleTimeFine\tQuat_q0\tQuat_q1\tQuat_q2\tQuat_q3\tAcc_X\tAcc_Y\tAcc_Z"
            "\tGyr_X\tGyr_Y\tGyr_Z\tMag_X\tMag_Y\tMag_Z"]
    rows = ["\t".join([f"{(65_000 + i) % 65536:05d}", str(round(t * 10_000)), "0.70711", "0.0",
                       "0.70711", "0.0", *(f"{v:.6f}" for v in (*a, *w)), "0.4", "-0.2", "0.9"])
            for i, (t, a, w) in enumerate(zip(log.time_s, log.acc, log.gyr, strict=True))]
    return Foreign([write_lines(folder / "MT_03782EBF-000.txt", [*head, *rows], end="\r\n")])


def bosch(folder: Path, log: HandLog) -> Foreign:
    """Bosch's Desktop Development: names with brackets, time in ms, raw and in units."""
    head = ("Time[ms];Accel_X[g];Accel_Y[g];Accel_Z[g];Gyro_X[dps];Gyro_Y[dps];Gyro_Z[dps];"
            "Temperature[degC]")
    rows = [";".join([f"{t * 1000:.1f}", *(f"{v:.5f}" for v in (*(a / G), *(w / DEG))), "24.5"])
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "BMI270_Gen2_log.csv", [head, *rows])], 1 / G, 1 / DEG)


def open_log_artemis(folder: Path, log: HandLog) -> Foreign:
    """SparkFun's OpenLog Artemis: dates of two columns, mg, deg/s, a trailing comma."""
    head = "rtcDate,rtcTime,aX,aY,aZ,gX,gY,gZ,mX,mY,mZ,imu_degC,output_Hz,"
    rows = [f"{datetime.fromtimestamp(EPOCH_S + t, UTC):%m/%d/%Y,%H:%M:%S.%f}"[:-4] + ","
            + ",".join(f"{v:.2f}" for v in (*(a / G * 1e3), *(w / DEG))) + ",12.3,-4.5,6.7,27.1,"
            + "100.000,"
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "dataLog00012.TXT", [head, *rows])], 1e3 / G, 1 / DEG)


def invensense(folder: Path, log: HandLog) -> Foreign:
    """MotionLink: counts, a time in µs, names in capitals."""
    head = "TIMESTAMP_US,ACCEL_X,ACCEL_Y,ACCEL_Z,GYRO_X,GYRO_Y,GYRO_Z,TEMP"
    rows = [",".join(map(str, (round(t * 1e6), *row, 4120)))
            for t, row in zip(log.time_s, counts_of(log, 2048, 16.384), strict=True)]
    return Foreign([write_lines(folder / "icm42688.csv", [head, *rows])], 2048 / G, 16.384 / DEG)


def vectornav(folder: Path, log: HandLog) -> Foreign:
    """VectorNav's control center: startup time in ns, yaw, pitch, roll beside."""
    head = ("TimeStartup,Yaw,Pitch,Roll,UncompAccX,UncompAccY,UncompAccZ,UncompGyroX,UncompGyroY,"
            "UncompGyroZ,Pressure")
    rows = [",".join([str(round((12 + t) * 1e9)), "10.0", "-1.0", "0.5",
                      *(f"{v:.6f}" for v in (*a, *w)), "101.325"])
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "vn100.csv", [head, *rows])])


def adafruit(folder: Path, log: HandLog) -> Foreign:
    """Tuples as CircuitPython prints them."""
    rows = [f"({t:.3f}, {a[0]:.5f}, {a[1]:.5f}, {a[2]:.5f}, {w[0]:.6f}, {w[1]:.6f}, {w[2]:.6f})"
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "repl.txt", rows)])


def adafruit_sentences(folder: Path, log: HandLog) -> Foreign:
    """`Acceleration: X:..., Y: ..., Z: ... m/s^2`, a line for each sensor."""
    lines = []
    for a, w in zip(log.acc, log.gyr, strict=True):
        lines.append(f"Acceleration: X:{a[0]:.3f}, Y: {a[1]:.3f}, Z: {a[2]:.3f} m/s^2")
        lines.append(f"Gyro X:{w[0]:.4f}, Y: {w[1]:.4f}, Z: {w[2]:.4f} radians/s")
    return Foreign([write_lines(folder / "lsm6ds.txt", lines)], rate_hz=log.rate_hz)


def rostopic_echo(folder: Path, log: HandLog) -> Foreign:
    """`rostopic echo -p /imu`: every field, covariances too."""
    names = ["%time", "field.header.seq", "field.header.stamp", "field.header.frame_id",
             *(f"field.orientation.{a}" for a in "xyzw"),
             *(f"field.orientation_covariance{i}" for i in range(9)),
             *(f"field.angular_velocity.{a}" for a in "xyz"),
             *(f"field.angular_velocity_covariance{i}" for i in range(9)),
             *(f"field.linear_acceleration.{a}" for a in "xyz"),
             *(f"field.linear_acceleration_covariance{i}" for i in range(9))]
    nine = ["0.0"] * 9
    rows = []
    for i, (t, a, w) in enumerate(zip(log.time_s, log.acc, log.gyr, strict=True)):
        stamp = str(EPOCH_S * 10**9 + round(t * 1e9))
        rows.append(",".join([stamp, str(i), stamp, "imu_link", "0.0", "0.0", "0.0", "1.0", *nine,
                              *(f"{v:.8f}" for v in w), *nine, *(f"{v:.8f}" for v in a), *nine]))
    return Foreign([write_lines(folder / "imu.csv", [",".join(names), *rows])])


def excel_bom(folder: Path, log: HandLog) -> Foreign:
    """Excel's `CSV UTF-8`: a byte order mark, semicolons, decimal commas, CRLF, empty rows."""
    head = "Zeit [s];Beschl. X [m/s²];Beschl. Y [m/s²];Beschl. Z [m/s²];Drehrate X [°/s];" \
           "Drehrate Y [°/s];Drehrate Z [°/s]"
    rows = [";".join(cell.replace(".", ",") for cell in row) for row in si_rows(log, 1, 1 / DEG)]
    rows += [";;;;;;", ";;;;;;"]
    return Foreign([write_lines(folder / "Mappe1.csv", [head, *rows], "utf-8-sig", "\r\n")], 1.0,
                   1 / DEG)


def excel_sep(folder: Path, log: HandLog) -> Foreign:
    """`sep=;` in the first line."""
    head = "t_ms;ax_g;ay_g;az_g;gx_dps;gy_dps;gz_dps"
    rows = [";".join([str(round(float(row[0]) * 1000)), *row[1:]])
            for row in si_rows(log, 1 / G, 1 / DEG)]
    return Foreign([write_lines(folder / "export.csv", ["sep=;", head, *rows])], 1 / G, 1 / DEG)


def dates_with_ms(folder: Path, log: HandLog) -> Foreign:
    head = "Timestamp,Accel X (g),Accel Y (g),Accel Z (g),Gyro X (deg/s),Gyro Y (deg/s)," \
           "Gyro Z (deg/s)"
    rows = [",".join([f"{datetime.fromtimestamp(EPOCH_S + float(row[0]), UTC):%Y-%m-%d %H:%M:%S.%f}"
                      [:-3], *row[1:]]) for row in si_rows(log, 1 / G, 1 / DEG)]
    return Foreign([write_lines(folder / "wt901.csv", [head, *rows])], 1 / G, 1 / DEG)


def witmotion(folder: Path, log: HandLog) -> Foreign:
    """WitMotion: tabs, blanks in the names, the time of day, angles beside."""
    head = "StartTime: 2024-03-11 10:11:12.013"
    names = "address\tTime(s)\tChipTime\tax(g)\tay(g)\taz(g)\twx(deg/s)\twy(deg/s)\twz(deg/s)\t" \
            "AngleX(deg)\tAngleY(deg)\tAngleZ(deg)\tT(°)\thx\thy\thz"
    rows = ["\t".join(["0x50", f"{datetime.fromtimestamp(EPOCH_S + t, UTC):%H:%M:%S.%f}"[:-3],
                       "2024-3-11 10:11:12", *(f"{v:.4f}" for v in (*(a / G), *(w / DEG))),
                       "1.0", "2.0", "3.0", "31.2", "100", "200", "300"])
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "20240311.txt", [head, names, *rows])], 1 / G, 1 / DEG)


ODD: dict[str, Callable[[Path, HandLog], Foreign]] = {
    tool.__name__: tool for tool in (
        phyphox_german, phyphox_absolute, sensor_logger_uncalibrated, betaflight_header_block,
        serial_labels, serial_equals, tab_labels, arduino_noise, arduino_ide_stamps,
        xsens_header, bosch, open_log_artemis, invensense, vectornav, adafruit,
        adafruit_sentences, rostopic_echo, excel_bom, excel_sep, dates_with_ms, witmotion)
}
