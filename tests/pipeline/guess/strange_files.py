"""Logs on which a first try of the importer failed or went wrong, each for another reason."""

import zipfile
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from tests.pipeline.guess.foreign_files import DEG, Foreign, G
from tests.pipeline.guess.hand_log import HandLog
from tests.pipeline.guess.text_rows import EPOCH_S, counts_of, si_rows, write_lines


def _stamped(log: HandLog, rows: Sequence[str]) -> list[str]:
    return [f"{datetime.fromtimestamp(EPOCH_S + t, UTC):%H:%M:%S.%f}"[:-3] + f" -> {row}"
            for t, row in zip(log.time_s, rows, strict=True)]


def stamped_labels(folder: Path, log: HandLog) -> Foreign:
    """The serial monitor's stamps in front of a name for every number."""
    rows = ["ax:{} ay:{} az:{} gx:{} gy:{} gz:{}".format(*row) for row in counts_of(log)]
    return Foreign([write_lines(folder / "w10.txt", _stamped(log, rows))], 16384 / G, 131.072 / DEG)


def stamped_labels_commas(folder: Path, log: HandLog) -> Foreign:
    rows = ["ax:{}, ay:{}, az:{}, gx:{}, gy:{}, gz:{}".format(*row) for row in counts_of(log)]
    return Foreign([write_lines(folder / "w10c.txt", _stamped(log, rows))], 16384 / G,
                   131.072 / DEG)


def stamped_tag(folder: Path, log: HandLog) -> Foreign:
    """i2cdevlib's `a/g:` behind the stamp, and a tab."""
    rows = ["\t".join(["a/g:", *map(str, row)]) for row in counts_of(log)]
    return Foreign([write_lines(folder / "w11.txt", _stamped(log, rows))], 16384 / G, 131.072 / DEG)


def tag_and_blank(folder: Path, log: HandLog) -> Foreign:
    """`a/g: ` and blanks; x is not lost."""
    rows = [" ".join(["a/g:", *map(str, row)]) for row in counts_of(log)]
    return Foreign([write_lines(folder / "w12.txt", rows)], 16384 / G, 131.072 / DEG, log.rate_hz)


def _sensor_logger(path: Path, log: HandLog, tables: dict[str, np.ndarray]) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        for name, values in tables.items():
            rows = [f"{(EPOCH_S * 10**9) + round(t * 1e9)},{t:.7f},{z:.7g},{y:.7g},{x:.7g}"
                    for t, (x, y, z) in zip(log.time_s, values, strict=True)]
            archive.writestr(f"{name}.csv", "\n".join(["time,seconds_elapsed,z,y,x", *rows]))
    return path


def sensor_logger_android(folder: Path, log: HandLog) -> Foreign:
    """One recording twice, both in m/s²."""
    return Foreign([_sensor_logger(folder / "android.zip", log, {
        "TotalAcceleration": log.acc * 1.001, "AccelerometerUncalibrated": log.acc,
        "Gyroscope": log.gyr, "GyroscopeUncalibrated": log.gyr})])


def sensor_logger_ios(folder: Path, log: HandLog) -> Foreign:
    """One recording twice, the raw one in g."""
    return Foreign([_sensor_logger(folder / "ios.zip", log, {
        "AccelerometerUncalibrated": log.acc / G, "TotalAcceleration": log.acc,
        "Gyroscope": log.gyr})], 1 / G)


def clock_set_back(folder: Path, log: HandLog) -> Foreign:
    """One step of 0.9 s back in the middle."""
    half = len(log.time_s) // 2
    times = log.time_s - 0.9 * (np.arange(len(log.time_s)) >= half)
    rows = [",".join([f"{EPOCH_S + t:.4f}", *(f"{v:.6f}" for v in (*a, *w))])
            for t, a, w in zip(times, log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "nexus.csv", ["timestamp,ax,ay,az,gx,gy,gz", *rows])])


def matlab_mobile(folder: Path, log: HandLog) -> Foreign:
    """Dates with the month's name."""
    rows = [f"{datetime.fromtimestamp(EPOCH_S + t, UTC):%d-%b-%Y %H:%M:%S.%f}"[:-3]
            + "," + ",".join(f"{v:.5f}" for v in a)
            for t, a in zip(log.time_s, log.acc, strict=True)]
    return Foreign([write_lines(folder / "Acceleration.csv", ["Timestamp,X,Y,Z", *rows])],
                   per_rad_s=None)


def german_excel_mg(folder: Path, log: HandLog) -> Foreign:
    """Whole milli-g and a row number; a preamble, semicolons, decimal commas."""
    head = ("Nr.;Zeit [s];Beschl. X [mg];Beschl. Y [mg];Beschl. Z [mg];Drehrate X [°/s];"
            "Drehrate Y [°/s];Drehrate Z [°/s];Temperatur [°C]")
    rows = [";".join([str(i), f"{t:.2f}", *(f"{v:.0f}" for v in a / G * 1000),
                      *(f"{v:.3f}" for v in w / DEG), "25.3"]).replace(".", ",")
            for i, (t, a, w) in enumerate(zip(log.time_s, log.acc, log.gyr, strict=True), 1)]
    return Foreign([write_lines(folder / "Messung 1.csv", ["Messprotokoll", "Gerät: X1", "", head,
                                                          *rows], "utf-8-sig", "\r\n")],
                   1000 / G, 1 / DEG)


def microseconds_in_front(folder: Path, log: HandLog) -> Foreign:
    """`ustime`, and a quaternion beside the readings."""
    head = "ustime,qw,qx,qy,qz,ax,ay,az,gx,gy,gz"
    four = _attitudes(log)
    rows = [",".join([str(round(t * 1e6)), *(f"{v:.5f}" for v in (*q, *a, *w))])
            for t, q, a, w in zip(log.time_s, four, log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "teensy.csv", [head, *rows])])


def unnamed_quaternion(folder: Path, log: HandLog) -> Foreign:
    """Time, quaternion, accelerometer in g, gyroscope in °/s, without a header."""
    rows = [" ".join([f"{t:.3f}", *(f"{v:.5f}" for v in (*q, *(a / G), *(w / DEG)))])
            for t, q, a, w in zip(log.time_s, _attitudes(log), log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "fusion.txt", rows)], 1 / G, 1 / DEG)


def spanish(folder: Path, log: HandLog) -> Foreign:
    head = ("tiempo_ms;aceleracion_x_g;aceleracion_y_g;aceleracion_z_g;giro_x_dps;giro_y_dps;"
            "giro_z_dps")
    rows = [";".join([str(round(1000 * t)), *(f"{v:.5f}" for v in (*(a / G), *(w / DEG)))])
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "datos.csv", [head, *rows])], 1 / G, 1 / DEG)


def sensitivities_of_st(folder: Path, log: HandLog) -> Foreign:
    """LSM6DS at ±4 g and ±500 °/s: 0.122 mg and 17.5 m°/s per count."""
    rows = [",".join(map(str, (round(t * 1e6), *row)))
            for t, row in zip(log.time_s, counts_of(log, 1 / 0.122e-3, 1 / 0.0175), strict=True)]
    return Foreign([write_lines(folder / "lsm6ds.csv", ["micros,ax,ay,az,gx,gy,gz", *rows])],
                   1 / 0.122e-3 / G, 1 / 0.0175 / DEG)


def bars_between_groups(folder: Path, log: HandLog) -> Foreign:
    """A word, the time, and two groups of readings between bars."""
    rows = [f"IMU0 {t:.3f} | " + " | ".join(" ".join(f"{v:.5f}" for v in three)
                                            for three in (a, w))
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "bars.txt", rows)])


def messages_with_numbers(folder: Path, log: HandLog) -> Foreign:
    """What a board says when it starts, dates among it; no header."""
    rows = [",".join([str(round(1000 * t)), *(f"{v:.4f}" for v in (*a, *(w / DEG)))])
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "boot.csv", [
        "ets Jul 29 2019 12:21:46", "rst:0x1 (POWERON_RESET),boot:0x13",
        "configsip: 0, SPIWP:0xee", *rows])], 1.0, 1 / DEG)


def clocks_of_two_devices(folder: Path, log: HandLog) -> Foreign:
    """ST's application: a date with slashes, its own clock, and before readings the board's clock
    in ticks of 8 ms and the bytes as they came."""
    rows = [f"{datetime.fromtimestamp(EPOCH_S + t, UTC):%d/%b/%Y %H:%M:%S.%f}"[:-3]
            + f",{EPOCH_S * 1000 + round(t * 1e3)},board,{1200 + round(t * 125)},"
            + f"{int(abs(acc[0]) * 7e4):08X}," + ",".join(f"{v:.4f}" for v in (*acc, *gyr))
            for t, acc, gyr in zip(log.time_s, log.acc, log.gyr / DEG, strict=True)]
    head = ("Date,HostTimestamp,NodeName,NodeTimestamp,RawData,"
            "ax (m/s²),ay (m/s²),az (m/s²),gx (dps),gy (dps),gz (dps)")
    return Foreign([write_lines(folder / "board.csv", [head, *rows])], 1.0, 1 / DEG)


def _attitudes(log: HandLog) -> np.ndarray:
    """Unit quaternions (t, 4) that turn as the readings do."""
    four = np.column_stack([log.acc / G + 0.3, np.linalg.norm(log.acc, axis=1) / G])
    return four / np.linalg.norm(four, axis=1, keepdims=True)


STRANGE: dict[str, Callable[[Path, HandLog], Foreign]] = {
    tool.__name__: tool for tool in (
        stamped_labels, stamped_labels_commas, stamped_tag, tag_and_blank, sensor_logger_android,
        sensor_logger_ios, clock_set_back, matlab_mobile, german_excel_mg, microseconds_in_front,
        unnamed_quaternion, spanish, sensitivities_of_st, bars_between_groups,
        messages_with_numbers, clocks_of_two_devices)
}


def sensor_logger_default(folder: Path, log: HandLog) -> Foreign:
    """Gravity removed and in a table of its own."""
    gravity = G * log.acc / np.linalg.norm(log.acc, axis=1, keepdims=True)
    return Foreign([_sensor_logger(folder / "default.zip", log, {
        "Accelerometer": log.acc - gravity, "Gravity": gravity, "Gyroscope": log.gyr})])


def normalised(folder: Path, log: HandLog) -> Foreign:
    """Readings divided by their own length."""
    rows = [",".join([row[0], *(f"{v:.6f}" for v in a / np.linalg.norm(a))])
            for row, a in zip(si_rows(log), log.acc, strict=True)]
    return Foreign([write_lines(folder / "unit.csv", ["time_s,ax,ay,az", *rows])])


#: Files of which no calibration can come, and the sentence that says why.
REFUSED: dict[str, tuple[Callable[[Path, HandLog], Foreign], str]] = {
    "sensor_logger_default": (sensor_logger_default,
                              "gravity is removed from its readings .*Total Acceleration"),
    "normalised": (normalised, "all its readings have the length 1"),
}
