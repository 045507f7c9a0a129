"""Twenty ways in which other people's tools write the same recording."""

import io
import json
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from scipy.io import savemat

from tests.pipeline.guess.hand_log import HandLog
from tests.pipeline.logs.flight_logs import ardupilot_log, px4_log

G = 9.80665
DEG = np.pi / 180


@dataclass(frozen=True)
class Foreign:
    """Files, and the units per SI unit in which they hold the accelerometer and the gyroscope."""

    files: list[Path]
    per_m_s2: float = 1.0
    per_rad_s: float | None = 1.0
    rate_hz: float | None = None


def _csv(folder: Path, name: str, head: str, columns: list[np.ndarray], delimiter: str = ",",
         fmt: str = "%.7g", comma: bool = False) -> Path:
    text = io.StringIO()
    np.savetxt(text, np.column_stack(columns), delimiter=delimiter, fmt=fmt)
    body = text.getvalue().replace(".", ",") if comma else text.getvalue()
    path = folder / name
    path.write_text((head + "\n" if head else "") + body, encoding="utf-8")
    return path


def phyphox(folder: Path, log: HandLog) -> Foreign:
    with zipfile.ZipFile(folder / "phone.zip", "w") as archive:
        for name, unit, values in (("Accelerometer", "m/s^2", log.acc), ("Gyroscope", "rad/s",
                                                                         log.gyr)):
            short = "Acceleration" if name == "Accelerometer" else name
            head = ",".join(['"Time (s)"', *(f'"{short} {axis} ({unit})"' for axis in "xyz")])
            text = io.StringIO()
            np.savetxt(text, np.column_stack([log.time_s, values]), delimiter=",", fmt="%.9E")
            archive.writestr(f"{name}.csv", head + "\n" + text.getvalue())
        archive.writestr("meta/device.csv", '"property","value"\n"deviceModel","Pixel"\n')
    return Foreign([folder / "phone.zip"])


def sensor_logger(folder: Path, log: HandLog) -> Foreign:
    """The axes stand in the order z, y, x; times are nanoseconds since 1970."""
    with zipfile.ZipFile(folder / "recording.zip", "w") as archive:
        for name, values in (("TotalAcceleration", log.acc), ("Gyroscope", log.gyr)):
            rows = [f"{1_700_000_000_000_000_000 + round(t * 1e9)},{t:.7f},{z:.7g},{y:.7g},{x:.7g}"
                    for t, (x, y, z) in zip(log.time_s, values, strict=True)]
            archive.writestr(f"{name}.csv", "\n".join(["time,seconds_elapsed,z,y,x", *rows]))
    return Foreign([folder / "recording.zip"])


def euroc(folder: Path, log: HandLog) -> Foreign:
    head = ("#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
            "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]")
    rows = [",".join([str(1_403_636_579_000_000_000 + round(t * 1e9)), *(f"{v:.8g}" for v in row)])
            for t, row in zip(log.time_s, np.hstack([log.gyr, log.acc]), strict=True)]
    (folder / "data.csv").write_text("\n".join([head, *rows]) + "\n")
    return Foreign([folder / "data.csv"])


def german_excel(folder: Path, log: HandLog) -> Foreign:
    head = "Zeit;AccX (g);AccY (g);AccZ (g);GyrX (°/s);GyrY (°/s);GyrZ (°/s)"
    clock = [datetime.fromtimestamp(1.7e9 + t, UTC).strftime("%d.%m.%Y %H:%M:%S,%f")[:-3]
             for t in log.time_s]
    rows = [";".join([when, *(f"{v:.6f}".replace(".", ",") for v in row)])
            for when, row in zip(clock, np.hstack([log.acc / G, log.gyr / DEG]), strict=True)]
    (folder / "messung.csv").write_bytes("\n".join([head.replace("Zeit", "time"), *rows]).encode(
        "cp1252"))
    return Foreign([folder / "messung.csv"], 1 / G, 1 / DEG)


def arduino(folder: Path, log: HandLog) -> Foreign:
    counts = np.rint(np.hstack([log.acc / G * 16384, log.gyr / DEG * 131.072]))
    return Foreign([_csv(folder, "serial.csv", "millis,ax,ay,az,gx,gy,gz",
                         [log.time_s * 1e3, counts], fmt="%d")], 16384 / G, 131.072 / DEG)


def unsigned(folder: Path, log: HandLog) -> Foreign:
    counts = np.rint(np.hstack([log.acc / G * 4096, log.gyr / DEG * 65.536])) % 65536
    return Foreign([_csv(folder, "dump.txt", "", [log.time_s * 1e3, counts], "\t", "%d")],
                   4096 / G, 65.536 / DEG)


def offset_binary(folder: Path, log: HandLog) -> Foreign:
    acc = np.rint(log.acc * 415 + 32768)
    gyr = np.rint(log.gyr * 4778 + 32768)
    return Foreign([_csv(folder, "imu_acc.mat", "", [log.time_s, acc], "   ", "%.7e"),
                    _csv(folder, "imu_gyro.mat", "", [log.time_s, gyr], "   ", "%.7e")], 415, None)


def milli_g(folder: Path, log: HandLog) -> Foreign:
    head = "timestamp_us;acc_x_mg;acc_y_mg;acc_z_mg;gyr_x_dps;gyr_y_dps;gyr_z_dps;temp"
    columns = [log.time_s * 1e6, log.acc / G * 1e3, log.gyr / DEG, np.full(len(log.time_s), 25.5)]
    return Foreign([_csv(folder, "log.csv", head, columns, ";", "%.9g", comma=True)], 1e3 / G,
                   1 / DEG)


def no_header_no_time(folder: Path, log: HandLog) -> Foreign:
    return Foreign([_csv(folder, "imu.log", "", [log.acc, log.gyr], " ", "%.5f")],
                   rate_hz=log.rate_hz)


def gyroscope_first(folder: Path, log: HandLog) -> Foreign:
    return Foreign([_csv(folder, "imu.txt", "t wx wy wz tx ty tz",
                         [log.time_s, log.gyr, log.acc], " ")])


def blackbox(folder: Path, log: HandLog) -> Foreign:
    """blackbox_decode's names have a blank in front, and flags are text."""
    head = ("loopIteration, time (us), axisP[0], axisP[1], axisP[2], gyroADC[0], gyroADC[1], "
            "gyroADC[2], accSmooth[0], accSmooth[1], accSmooth[2], flightModeFlags (flags)")
    counts = np.rint(log.acc / G * 2048).astype(int)
    rows = [f"{i}, {round(t * 1e6)}, 1, 2, 3, " + ", ".join(f"{v:.3f}" for v in gyr / DEG) + ", "
            + ", ".join(map(str, acc)) + ", ANGLE_MODE"
            for i, (t, acc, gyr) in enumerate(zip(log.time_s, counts, log.gyr, strict=True))]
    (folder / "LOG00001.01.csv").write_text("\n".join([head, *rows]) + "\n")
    return Foreign([folder / "LOG00001.01.csv"], 2048 / G, 1 / DEG)


def mt_manager(folder: Path, log: HandLog) -> Foreign:
    head = (f"// Start Time: Unknown\n// Update Rate: {log.rate_hz}Hz\n"
            "PacketCounter\tAcc_X\tAcc_Y\tAcc_Z\tGyr_X\tGyr_Y\tGyr_Z\tMag_X\tRoll")
    counter = (65_500 + np.arange(len(log.time_s))) % 65536
    columns = [counter, log.acc, log.gyr, np.full((len(log.time_s), 2), 0.5)]
    return Foreign([_csv(folder, "MT_0001.txt", head, columns, "\t", "%.8g")])


def sensor_log_ios(folder: Path, log: HandLog) -> Foreign:
    head = ("loggingTime(txt),accelerometerAccelerationX(G),accelerometerAccelerationY(G),"
            "accelerometerAccelerationZ(G),motionUserAccelerationX(G),motionUserAccelerationY(G),"
            "motionUserAccelerationZ(G),gyroRotationX(rad/s),gyroRotationY(rad/s),"
            "gyroRotationZ(rad/s),gyroTimestamp_sinceReboot(s)")
    rows = [",".join([datetime.fromtimestamp(1.7e9 + t, UTC).isoformat(timespec="milliseconds"),
                      *(f"{v:.7g}" for v in -acc / G), "0.01", "0.02", "0.01",
                      *(f"{v:.7g}" for v in gyr), f"{5000 + t:.4f}"])
            for t, acc, gyr in zip(log.time_s, log.acc, log.gyr, strict=True)]
    (folder / "phone.csv").write_text("\n".join([head, *rows]))
    return Foreign([folder / "phone.csv"], 1 / G)


def ros_topic_csv(folder: Path, log: HandLog) -> Foreign:
    head = "%time," + ",".join(f"field.{q}.{a}" for q in ("angular_velocity", "linear_acceleration")
                               for a in "xyz")
    rows = [",".join([str(1_700_000_000_000_000_000 + round(t * 1e9)), *(f"{v:.8g}" for v in row)])
            for t, row in zip(log.time_s, np.hstack([log.gyr, log.acc]), strict=True)]
    (folder / "imu_topic.csv").write_text("\n".join([head, *rows]))
    return Foreign([folder / "imu_topic.csv"])


def parquet(folder: Path, log: HandLog) -> Foreign:
    names = [f"{q}_{a}" for q in ("accel", "gyro") for a in "xyz"]
    stamps = pa.array(((1.7e9 + log.time_s) * 1e9).astype("datetime64[ns]"))
    pq.write_table(pa.table({"timestamp": stamps, **dict(zip(
        names, np.hstack([log.acc / G, log.gyr / DEG]).T, strict=True))}), folder / "d.parquet")
    return Foreign([folder / "d.parquet"], 1 / G, 1 / DEG)


def matlab(folder: Path, log: HandLog) -> Foreign:
    savemat(folder / "cal.mat", {"data": np.column_stack([log.time_s, log.acc, log.gyr])})
    return Foreign([folder / "cal.mat"])


def json_lines(folder: Path, log: HandLog) -> Foreign:
    (folder / "imu.jsonl").write_text("".join(json.dumps(
        {"ts": round(t * 1e3), "accel": list(acc), "gyro": {"x": w[0], "y": w[1], "z": w[2]}})
        + "\n" for t, acc, w in zip(log.time_s, log.acc, log.gyr, strict=True)))
    return Foreign([folder / "imu.jsonl"])


def px4(folder: Path, log: HandLog) -> Foreign:
    return Foreign([px4_log(folder / "flight.ulg", log.time_s, log.acc, log.gyr)])


def ardupilot(folder: Path, log: HandLog) -> Foreign:
    return Foreign([ardupilot_log(folder / "flight.bin", log.time_s, log.acc, log.gyr)])


def one_file_per_pose(folder: Path, log: HandLog) -> Foreign:
    """No times at all, in g, one file per rest."""
    files = []
    for rest in range(int(log.rest.max()) + 1):
        at = log.rest == rest
        files.append(_csv(folder, f"pose{rest}.txt", "x,y,z", [log.acc[at] / G]))
    return Foreign(files, 1 / G, None)


def means(folder: Path, log: HandLog) -> Foreign:
    rests = range(int(log.rest.max()) + 1)
    acc = np.array([log.acc[log.rest == rest].mean(axis=0) for rest in rests])
    sd = np.array([log.acc[log.rest == rest].std(axis=0, ddof=1) for rest in rests])
    count = np.array([(log.rest == rest).sum() for rest in rests])
    head = "ax,ay,az,ax_std,ay_std,az_std,samples"
    return Foreign([_csv(folder, "means.csv", head, [acc, sd, count])], 1.0, None)


TOOLS: dict[str, Callable[[Path, HandLog], Foreign]] = {
    tool.__name__: tool for tool in (
        phyphox, sensor_logger, euroc, german_excel, arduino, unsigned, offset_binary, milli_g,
        no_header_no_time, gyroscope_first, blackbox, mt_manager, sensor_log_ios, ros_topic_csv,
        parquet, matlab, json_lines, px4, ardupilot, one_file_per_pose, means)
}
