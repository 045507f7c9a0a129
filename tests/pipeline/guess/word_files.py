"""Readings among words: labels, sentences, talkers with checksums, reports, markup."""

from functools import reduce
from operator import xor

from tests.pipeline.guess.foreign import (
    AXES,
    DEG,
    EPOCH_S,
    G,
    Sample,
    Values,
    Writer,
    comma,
    rows,
    when,
)

PER_COUNT = {"acc": 16384 / G, "gyr": 131.072 / DEG}
IN_G = {"acc": 1 / G, "gyr": 1 / DEG}
IN_MG = {"acc": 1000 / G, "gyr": 1000 / DEG}
NAMES = AXES.split(",")
MAVLINK = ("xacc", "yacc", "zacc", "xgyro", "ygyro", "zgyro")


def labels(sample: Sample, between: str) -> str:
    """`ax:123 ay:..`"""
    return between.join(f"{name}:{v}" for name, v in zip(NAMES, sample.c, strict=True))


def stamped(sample: Sample) -> str:
    """The serial monitor's stamp."""
    return f"{when(sample.t, '%H:%M:%S.%f')} -> "


def talked(sample: Sample) -> str:
    """A sentence with a checksum."""
    body = f"PIMU,{sample.s}"
    return f"${body}*{reduce(xor, body.encode()):02X}"


def another_talker(lines: list[str]) -> None:
    lines.insert(500, "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47")


def mavlink(sample: Sample) -> str:
    return ", ".join(f"{name} : {v}" for name, v in zip(MAVLINK, sample.c, strict=True))


def vehicle(sample: Sample) -> str:
    """A message of the sensor, and now and then another."""
    stamp = f"2026-11-27 18:11:{sample.t:05.2f}"
    beat = f"\n{stamp}: HEARTBEAT {{type : 2, autopilot : 3, base_mode : 81}}"
    return (f"{stamp}: SCALED_IMU2 {{time_boot_ms : {1000 * sample.t:.0f}, {mavlink(sample)}}}"
            + (beat if sample.i % 5 == 0 else ""))


def named(values: Values, form: str) -> tuple[str, ...]:
    """Each value with the letter of its axis, which ``form`` has as 0 and 1."""
    return tuple(form.format(axis, v) for axis, v in zip("XYZ", values, strict=True))


def two_units(sample: Sample) -> str:
    """A message for each of two sensors, told by their number."""
    stamp = f"{1e6 * sample.t:.0f}"
    other = [[f"{float(f'{v:.6f}') + 0.4:.6f}" for v in each] for each in (sample.w, sample.a)]
    return (f"ATT, {stamp}, 1.5, 2.5, 180.2\nIMU, {stamp}, 0, {sample.w:, .6f}, {sample.a:, .6f}\n"
            f"IMU, {stamp}, 1, {', '.join(other[0])}, {', '.join(other[1])}")


LABELS: dict[str, Writer] = {
    # a sketch that prints names and no times
    "serial_labels": rows("putty.log", "", lambda s: labels(s, " "), **PER_COUNT, timed=False),
    "serial_equals": rows("serial_monitor.txt", "", lambda s: (
        f"t={1000 * s.t:.0f}, " + ", ".join(
            [*(f"a{x} = {v:.3f}" for x, v in zip("XYZ", s.a, strict=True)),
             *(f"g{x} = {v:.4f}" for x, v in zip("XYZ", s.w, strict=True))]))),
    # i2cdevlib's `a/g:` in front of tabs
    "tab_labels": rows("mpu.txt", "Initializing I2C devices...\nTesting device connections...\n"
                       "MPU6050 connection successful", lambda s: f"a/g:\t{s.c:\td}", **PER_COUNT,
                       timed=False),
    # `a/g: ` and blanks; x is not lost
    "tag_and_blank": rows("w12.txt", "", lambda s: f"a/g: {s.c: d}", **PER_COUNT, timed=False),
    "stamped_labels": rows("w10.txt", "", lambda s: stamped(s) + labels(s, " "), **PER_COUNT),
    "stamped_labels_commas": rows("w10c.txt", "", lambda s: stamped(s) + labels(s, ", "),
                                  **PER_COUNT),
    "stamped_tag": rows("w11.txt", "", lambda s: f"{stamped(s)}a/g:\t{s.c:\td}", **PER_COUNT),
    # i2cdevlib's DMP: as many words above the rows as they have numbers, and a word in front
    "dmp": rows("dmp.txt", "Initializing I2C devices...\nDMP ready! Waiting for first interrupt...",
                lambda s: f"areal\t{Values(s.c[:3]):\td}", 16384 / G, None, timed=False),
    # tuples as CircuitPython prints them
    "adafruit": rows("repl.txt", "", lambda s: f"({s.t:.3f}, {s.a:, .5f}, {s.w:, .6f})"),
    # a line for each sensor, a temperature last, and units apart from their numbers
    "sentences_and_temperature": rows("mpu9250.txt", "MPU9250 is online...", lambda s: (
        "X-acceleration: {:.2f} mg Y-acceleration: {:.2f} mg Z-acceleration: {:.2f} mg\n"
        "X-gyro rate: {:.3f} degrees/sec Y-gyro rate: {:.3f} degrees/sec "
        "Z-gyro rate: {:.3f} degrees/sec\n".format(*s.a, *s.w)
        + "X-mag field: 213.1 mG Y-mag field: -145.2 mG Z-mag field: 402.9 mG\n"
          "Temperature is 24.0 degrees C"), 1000 / G, 1 / DEG, timed=False),
    # a line for each sensor
    "adafruit_sentences": rows("lsm6ds.txt", "", lambda s: (
        "Acceleration: X:{:.3f}, Y: {:.3f}, Z: {:.3f} m/s^2\n".format(*s.a)
        + "Gyro X:{:.4f}, Y: {:.4f}, Z: {:.4f} radians/s".format(*s.w)), timed=False),
    # Adafruit's sketch of an ICM-20948: words between the lines, a unit behind three numbers
    "between_the_lines": rows(
        "putty.log", "Adafruit ICM20948 test!\nGyro range set to: 2000 degrees/s", lambda s: (
            "\t\tTemperature 24.03 deg C\n\n\t\tAccel X: {:.3f} \tY: {:.3f} \tZ: {:.3f} m/s^2 \n\n"
            "\t\tGyro X: {:.3f} \tY: {:.3f} \tZ: {:.3f} radians/s \n".format(*s.a, *s.w)),
        timed=False),
    # Adafruit's test of a BNO055: tabs between a name and its axes, and lines of the state
    "lines_of_a_console": rows("bno.log", "Orientation Sensor Test\n\n", lambda s: (
        "Accl:\t\tx= {:.3f} |\ty= {:.3f} |\tz= {:.3f}\nGyro:\t\tx= {:.3f} |\ty= {:.3f} |\tz= {:.3f}"
        "\n\ntemperature: 24\nCalibration: Sys=0 Gyro=3\n--".format(*s.a, *s.w)), gyr=1 / DEG,
        timed=False),
    # a sample in three lines, each with a name and three numbers: Razor AHRS
    "tagged_lines": rows("razor.txt", "", lambda s: "\n".join(
        f"#{name}={values:,d}".replace(",", ".00,") + ".00" for name, values in (
            ("A-R", Values(s.c[:3])), ("M-R", Values(v // 9 for v in s.c[:3])),
            ("G-R", Values(s.c[3:])))), 256 / G, 14.375 / DEG, timed=False),
    # a name with its unit before three numbers, and a clock that nothing names
    "groups_with_units": rows("st.log", "WHO_AM_I = 0x6C", lambda s: (
        f"[{1000 * s.t:8.0f}] Acc[mg]: {s.a: 5.0f} | Gyr[mdps]: {s.w: 7.0f} | T[degC]: 24.5"),
        **IN_MG),
    # a unit without a blank behind every number, of which none may be cut at its point
    "glued_units": rows("ucenter.txt", "", lambda s: " ".join([
        f"ESF-MEAS t={1000 * s.t:.0f}ms", *named(s.a, "acc{}={:.4f}m/s^2"),
        *named(s.w, "gyr{}={:.4f}deg/s")]), gyr=1 / DEG),
    # lines for the Arduino plotter in mg and m°/s, without units or times
    "plotter": rows("plotter.txt", "", lambda s: "\t".join(
        named(s.a, "Acc{}:{:.1f}") + named(s.w, "Gyro{}:{:.1f}")), **IN_MG),
    # a word, the time, and two groups of readings between bars
    "bars_between_groups": rows("bars.txt", "", lambda s: (
        f"IMU0 {s.t:.3f} | {s.a: .5f} | {s.w: .5f}")),
    # a line for each event of each sensor, as Android delivers them
    "android_lines": rows("events.csv", "timestamp_ns,sensor,x,y,z", lambda s: (
        f"{round((5000 + s.t) * 1e9)},ACC,{s.a:,.6f}\n"
        f"{round((5000 + s.t) * 1e9) + 1000},GYR,{s.w:,.6f}")),
    # Android's log: dates without a year before lines of two sensors
    "logcat": rows("logcat.txt", "--------- beginning of main", lambda s: "\n".join(
        f"11-27 18:{9 + int(s.t) // 60:02d}:{s.t % 60:06.3f}  8123  8190 D SensorDump: {name} "
        "x={:.6f} y={:.6f} z={:.6f} acc=3".format(*v) for name, v in (("ACC", s.a), ("GYR", s.w)))),
    # five rows of a gyroscope to one of an accelerometer
    "sensors_in_uneven_turns": rows("rs.csv", "Module,Stream,t (ms),X,Y,Z", lambda s: "\n".join(
        f"Motion,{name},{1000 * s.t:.3f},{v:,.6f}" for name, v in (("Accel", s.a), ("Gyro", s.w))
        if name == "Gyro" or s.i % 5 == 0)),
    # an ESP32's log with the colours of a terminal
    "idf_monitor": rows("idf.log", "ESP-ROM:esp32s3-20210327", lambda s: (
        f"\x1b[0;32mI ({round(s.t * 1000) + 312}) IMU: acc={s.a:,.4f} gyr={s.w:,.3f}\x1b[0m"),
        **IN_G),
    # a date with a decimal comma in front, and units behind the vectors
    "python_logging": rows("run.log", "INFO main: started", lambda s: (
        comma(f"2026-03-04 14:05:{s.t:06.3f}")
        + f" INFO imu: accel=({s.a:, .6f}) m/s^2 gyro=({s.w:, .6f}) rad/s")),
    # a number of the packet in hexadecimal, which no word and no form of line is
    "a_byte_in_each_line": rows("mt.log", "", lambda s: (
        f"[21:{58 + int(s.t // 60):02d}:{s.t % 60:09.6f}] DATA2 id=0x{s.i % 256:02x} "
        f"acc=({s.a: .5f}) gyr=({s.w: .6f}) ok")),
    # cells that hold the three axes, as pandas writes arrays
    "vectors": rows("df.csv", "time,accel,gyro",
                    lambda s: f'{s.t:.3f},"[{s.a:, .5f}]","[{s.w:, .6f}]"'),
    # sentences with a checksum, and a receiver's among them
    "nmea_among_others": rows("serial.nmea", "", talked, change=another_talker),
    # the same from an instrument in g, whose lines end as on a port
    "nmea": rows("capture.nmea", "", talked, **IN_G, end="\r\n"),
    # a table of InfluxDB that was not pivoted
    "one_value_a_row": rows("query.csv", ",result,table,_time,_value,_field", lambda s: "\n".join(
        f",,0,2026-03-04T14:05:{s.t:06.3f}Z,{cell},{name}"
        for name, cell in zip(NAMES, s.cells[1:], strict=True))),
    # ESPHome's log
    "a_value_a_line": rows("esphome.log", "", lambda s: "\n".join(
        f"\x1b[0;36m[14:05:{int(s.t) % 60:02d}][D][sensor:094]: 'MPU6050 {name} {axis}': Sending "
        f"state {v:.5f} with 3 decimals of accuracy\x1b[0m"
        for name, row in (("Accel", s.a), ("Gyro", s.w)) for axis, v in zip("XYZ", row, strict=True)
    )),
    # Tinkerforge: a value, its name and its unit in each row, with numbers in units and names
    "brick_logger": rows("bricks.csv", "TIME;NAME;VAR;RAW;UNIT", lambda s: "\n".join(
        f"2026-03-04T14:05:{s.t:06.3f}+01:00;IMU Brick 2.0;{name}-{axis};{v:.0f};{unit}"
        for name, unit, row in (("Acceleration", "cm/s²", s.a),
                                ("Angular Velocity", "1/16 °/s", s.w))
        for axis, v in zip("XYZ", row, strict=True)), 100.0, 16 / DEG),
    # FitCSVTool: a name, a number in quotes and a unit for each field, under `Field 1,Value 1`
    "names_in_the_rows": rows(
        "activity.csv", ",".join(["Type", "Local Number", "Message", *(
            f"{part} {i}" for i in range(1, 6) for part in ("Field", "Value", "Units"))]) + ","
        + '\nData,0,file_id,serial_number,"3941",' + 12 * ",", lambda s: "\n".join(
            f'Data,{number},{name}_data,timestamp,"{912345678 + int(s.t)}",s,'
            f'timestamp_ms,"{round(1000 * s.t) % 1000}",ms,' + ",".join(
                f'calibrated_{part}_{axis},"{v:.4f}",{unit}'
                for axis, v in zip("xyz", row, strict=True)) + ","
            for number, name, part, row, unit in ((3, "accelerometer", "accel", s.a, "mG"),
                                                  (4, "gyroscope", "gyro", s.w, "deg/s"))),
        1000 / G, 1 / DEG),
    # mavlogdump.py: a message in braces, milli-g and mrad/s by its definition, other fields
    "mavlink_dump": rows("flight.txt", "", lambda s: (
        f"{when(s.t, '%Y-%m-%d %H:%M:%S.%f')[:-1]}: RAW_IMU {{time_usec : {s.t * 1e6:.0f}, "
        f"{mavlink(s)}, xmag : 231, ymag : -17, zmag : 402, id : 0, temperature : 2512}}"),
        1000 / G, 1000.0),
    # with other messages between those of the sensor
    "messages_of_a_vehicle": rows("rest.mavlog.txt", "", vehicle, 1000 / G, 1000.0),
    # ArduPilot
    "two_units_of_a_message": rows(
        "00000012.log", "FMT, 163, 58, IMU, QBffffff, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ",
        two_units),
    # a number a line: `Serial.println` of one value after another
    "a_number_a_line": rows("monitor.txt", "", lambda s: "\n".join(s.cells), gyr=1 / DEG),
    # counts of seven channels, the temperature among them, between words and empty lines
    "counts_a_line": rows("port.log", "MPU6050 ready", lambda s: "\n".join(
        map(str, (*s.c[:3], -1700, *s.c[3:]))) + "\n", **PER_COUNT, timed=False),
}

MARKUP: dict[str, Writer] = {
    # InfluxDB: tags, fields, and nanoseconds at the end
    "line_protocol": rows("export.lp", "", lambda s: (
        "imu,host=pi,place=bench ax={:.5f},ay={:.5f},az={:.5f},gx={:.6f},gy={:.6f},gz={:.6f} "
        .format(*s.a, *s.w) + f"{round((EPOCH_S + s.t) * 1e9)}")),
    # a table of a notebook, with bars at both ends
    "markdown": rows("table.md", "# Run 3\n\n| t (s) | ax (g) | ay (g) | az (g) | gx (dps) | "
                     "gy (dps) | gz (dps) |\n|:---|---:|---:|---:|---:|---:|---:|",
                     lambda s: f"| {' | '.join(s.cells)} |", **IN_G),
    # a page saved from a dashboard, a row of the table a line
    "html": rows(
        "page.html", "<!DOCTYPE html>\n<html><head><title>IMU</title></head><body><table>\n<tr>"
        + "".join(f"<th>{name}</th>" for name in ("time", *NAMES)) + "</tr>", lambda s: (
            "<tr>" + "".join(f"<td>{cell}</td>" for cell in s.cells) + "</tr>"),
        change=lambda lines: lines.append("</table></body></html>")),
    "xml": rows("session.xml", "<recording>", lambda s: (
        '  <sample t="{}"><acc x="{}" y="{}" z="{}"/><gyr x="{}" y="{}" z="{}"/>'
        .format(*s.cells)), change=lambda lines: lines.append("</recording>")),
    # a list of mappings with vectors
    "yaml_lines": rows("samples.yaml", "", lambda s: (
        f"- {{t: {s.t:.3f}, acc: [{s.a:, .6f}], gyr: [{s.w:, .6f}]}}")),
    # `ros2 topic echo /imu`: documents of YAML
    "ros2_echo": rows("imu.yaml", "", lambda s: (
        f"header:\n  stamp:\n    sec: {EPOCH_S + int(s.t)}\n    nanosec: {round(s.t % 1 * 1e9)}\n"
        "  frame_id: imu_link\norientation:\n  x: 0.0\n  y: 0.0\n  z: 0.0\n  w: 1.0\n"
        + "".join(f"{name}:\n  x: {v[0]:.8f}\n  y: {v[1]:.8f}\n  z: {v[2]:.8f}\n"
                  f"{name}_covariance:\n" + 9 * "- 0.0\n" for name, v in (
                      ("angular_velocity", s.w), ("linear_acceleration", s.a))) + "---")),
    # statements of a data base: nothing names their numbers
    "sql_dump": rows("dump.sql", "PRAGMA foreign_keys=OFF;\nBEGIN TRANSACTION;", lambda s: (
        f"INSERT INTO imu VALUES({s.i + 1},{1714557600 + s.t:.3f},{s.a:,.6f},{s.w:,.6f});"),
        change=lambda lines: lines.append("COMMIT;")),
    # R's write.table: quoted row names, which the header has no name for
    "row_names": rows("r.txt", '"time" "acc_x" "acc_y" "acc_z" "gyr_x" "gyr_y" "gyr_z"',
                      lambda s: f'"{s.i + 1}" {" ".join(s.cells)}', gyr=1 / DEG),
    # `print()` of a dictionary, z first
    "micropython": rows("repl.txt", "MPY: soft reboot\nMPU6050 found at 0x68", lambda s: (
        "{{'GyZ': {5}, 'GyY': {4}, 'GyX': {3}, 'Temp': {6:.2f}, 'AcZ': {2}, 'AcY': {1}, "
        "'AcX': {0}}}".format(*s.c, 24.5 + s.i / 9000)), **PER_COUNT, timed=False),
    # a dictionary as Python prints it where NumPy 2 made its numbers
    "numbers_of_numpy": rows("print.txt", "", lambda s: "{" + ", ".join(
        f"'{name}': np.float64({value})"
        for name, value in zip(("t", *NAMES), s.cells, strict=True)) + "}"),
    # `console.log` of an object: it begins as JSON does, and its names have no quotes
    "objects_without_quotes": rows("console.txt", "", lambda s: (
        "{{\n  t: {},\n  acc: {{ x: {}, y: {}, z: {} }},\n  gyro: {{ x: {}, y: {}, z: {} }}\n}}"
        .format(*s.cells))),
}
