"""Logs whose numbers stand among words, in vectors, in other alphabets, or at other rates."""

import json
from collections.abc import Callable
from functools import reduce
from operator import xor
from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import feather

from tests.pipeline.guess.foreign_files import DEG, Foreign, G
from tests.pipeline.guess.hand_log import HandLog
from tests.pipeline.guess.text_rows import EPOCH_S, counts_of, si_rows, write_lines


def idf_monitor(folder: Path, log: HandLog) -> Foreign:
    """An ESP32's log with the colours of a terminal."""
    rows = [f"\x1b[0;32mI ({round(t * 1000) + 312}) IMU: acc={x:.4f},{y:.4f},{z:.4f} "
            f"gyr={p:.3f},{q:.3f},{r:.3f}\x1b[0m" for t, (x, y, z), (p, q, r) in
            zip(log.time_s, log.acc / G, log.gyr / DEG, strict=True)]
    return Foreign([write_lines(folder / "idf.log", ["ESP-ROM:esp32s3-20210327", *rows])],
                   1 / G, 1 / DEG)


def python_logging(folder: Path, log: HandLog) -> Foreign:
    """A date with a decimal comma in front, and units behind the vectors."""
    rows = [f"2026-03-04 14:05:{t:06.3f}".replace(".", ",") + " INFO imu: accel=({}, {}, {}) m/s^2 "
            "gyro=({}, {}, {}) rad/s".format(*row)
            for t, (_, *row) in zip(log.time_s, si_rows(log), strict=True)]
    return Foreign([write_lines(folder / "run.log", ["INFO main: started", *rows])])


def a_byte_in_each_line(folder: Path, log: HandLog) -> Foreign:
    """A number of the packet in hexadecimal, which no word and no form of line is."""
    rows = [f"[21:{58 + int(t // 60):02d}:{t % 60:09.6f}] DATA2 id=0x{i % 256:02x} "
            f"acc=({acc[0]:.5f} {acc[1]:.5f} {acc[2]:.5f}) "
            f"gyr=({gyr[0]:.6f} {gyr[1]:.6f} {gyr[2]:.6f}) ok"
            for i, (t, acc, gyr) in enumerate(zip(log.time_s, log.acc, log.gyr, strict=True))]
    return Foreign([write_lines(folder / "mt.log", rows)])


def vectors(folder: Path, log: HandLog) -> Foreign:
    """Cells that hold the three axes, as pandas writes arrays."""
    rows = [f'{t:.3f},"[{a[0]:.5f}, {a[1]:.5f}, {a[2]:.5f}]","[{w[0]:.6f}, {w[1]:.6f}, {w[2]:.6f}]"'
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "df.csv", ["time,accel,gyro", *rows])])


def units_in_cells(folder: Path, log: HandLog) -> Foreign:
    rows = [", ".join([f"{t:.2f}s", *(f"{v:.4f}g" for v in a), *(f"{v:.3f}°/s" for v in w)])
            for t, a, w in zip(log.time_s, log.acc / G, log.gyr / DEG, strict=True)]
    head = "time, accX, accY, accZ, gyrX, gyrY, gyrZ"
    return Foreign([write_lines(folder / "display.txt", [head, *rows])], 1 / G, 1 / DEG)


def nmea_among_others(folder: Path, log: HandLog) -> Foreign:
    """Sentences with a checksum, and a receiver's among them."""
    bodies = [",".join(["PIMU", *row]) for row in si_rows(log)]
    rows = [f"${body}*{reduce(xor, body.encode()):02X}" for body in bodies]
    rows[500:500] = ["$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47"]
    return Foreign([write_lines(folder / "serial.nmea", rows)])


def witmotion_chinese(folder: Path, log: HandLog) -> Foreign:
    """Names in the code page of China, dates, and a name of the device that holds a number."""
    head = "时间 设备名称 加速度X(g) 加速度Y(g) 加速度Z(g) 角速度X(°/s) 角速度Y(°/s) 角速度Z(°/s)"
    rows = ["\t".join([f"2026-03-04 14:05:{t:06.3f}", "WT901(f1:22)",
                       *(f"{v:.4f}" for v in (*a / G, *w / DEG))])
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    path = write_lines(folder / "data.txt", [head.replace(" ", "\t"), *rows], "gb18030")
    return Foreign([path], 1 / G, 1 / DEG)


def browser(folder: Path, log: HandLog) -> Foreign:
    """Events of a web page: the acceleration without gravity first; alpha is about z (W3C)."""
    path = folder / "motion.json"
    path.write_text(json.dumps([
        {"timeStamp": round(t * 1000 + 5123.4, 1), "acceleration": {"x": 0.0, "y": 0.01, "z": 0.0},
         "accelerationIncludingGravity": dict(zip("xyz", map(str, a), strict=True)),
         "rotationRate": dict(zip(("beta", "gamma", "alpha"), w / DEG, strict=True))}
        for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]))
    return Foreign([path], 1.0, 1 / DEG)


def wrapped_json(folder: Path, log: HandLog) -> Foreign:
    """An object that holds the list of samples among other things."""
    samples = [{"t": t, "a": list(a), "g": list(w)}
               for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    path = folder / "export.json"
    path.write_text(json.dumps({"device": "phone", "tags": [1, 2], "samples": samples}))
    return Foreign([path])


def columns_of_json(folder: Path, log: HandLog) -> Foreign:
    names = ("time", "ax", "ay", "az", "gx", "gy", "gz")
    columns = np.column_stack([log.time_s, log.acc, log.gyr]).T.tolist()
    path = folder / "columns.json"
    path.write_text(json.dumps(dict(zip(names, columns, strict=True)), indent=1))
    return Foreign([path])


def japanese(folder: Path, log: HandLog) -> Foreign:
    head = "時刻[s],加速度X[G],加速度Y[G],加速度Z[G],角速度X,角速度Y,角速度Z"
    rows = [",".join(f"{v:.5f}" for v in (t, *a, *w))
            for t, a, w in zip(log.time_s, log.acc / G, log.gyr / DEG, strict=True)]
    return Foreign([write_lines(folder / "sensor.csv", [head, *rows], "shift_jis")], 1 / G, 1 / DEG)


def aerospace(folder: Path, log: HandLog) -> Foreign:
    rows = [",".join([f"{t:.3f}", *(f"{v:.6f}" for v in (*w, *a / G))])
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    head = "TIME [s],p [rad/s],q [rad/s],r [rad/s],nx [g],ny [g],nz [g]"
    return Foreign([write_lines(folder / "flight.csv", [head, *rows])], 1 / G, 1.0)


def slow_gyroscope(folder: Path, log: HandLog) -> Foreign:
    """Its cells are empty in three of four rows."""
    rows = [",".join([t, *cells[:3], *(cells[3:] if i % 4 == 1 else ("", "", ""))])
            for i, (t, *cells) in enumerate(si_rows(log))]
    return Foreign([write_lines(folder / "mixed.csv", ["t,ax,ay,az,gx,gy,gz", *rows])])


def ros2_csv(folder: Path, log: HandLog) -> Foreign:
    """`ros2 topic echo --csv`: no header, seconds beside nanoseconds, zeros of covariances."""
    nine = ["0.0"] * 9
    rows = [",".join([str(EPOCH_S + int(t)), str(round(t % 1 * 1e9)), "imu_link", "0.0", "0.0",
                      "0.0", "1.0", *nine, *map(str, w), *nine, *map(str, a), *nine])
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    return Foreign([write_lines(folder / "imu.csv", rows)])


def parts(folder: Path, log: HandLog) -> Foreign:
    """A card's files, of which the first alone has a header."""
    rows = [",".join(row) for row in si_rows(log)]
    cuts = [rows[:900], rows[900:1800], rows[1800:]]
    return Foreign([write_lines(folder / f"LOG{i}.CSV", ["t,ax,ay,az,gx,gy,gz"][i:] + part)
                    for i, part in enumerate(cuts)])


def bno055(folder: Path, log: HandLog) -> Foreign:
    counts = np.rint(np.hstack([log.acc * 100, log.gyr / DEG * 16])).astype(int)
    rows = [" ".join(map(str, (round(t * 1000), *row)))
            for t, row in zip(log.time_s, counts, strict=True)]
    return Foreign([write_lines(folder / "bno.txt", ["millis aX aY aZ gX gY gZ", *rows])],
                   100.0, 16 / DEG)


def whole_seconds(folder: Path, log: HandLog) -> Foreign:
    """A clock that shows the same second in fifty rows."""
    rows = [f"04/03/2026 14:05:{int(float(t)):02d},{','.join(cells)}" for t, *cells in si_rows(log)]
    return Foreign([write_lines(folder / "export.csv", ["Date/Time,Ax,Ay,Az,Gx,Gy,Gz", *rows])])


def numbered_axes(folder: Path, log: HandLog) -> Foreign:
    """A camera's telemetry: the name of the sensor stands over its first axis only."""
    files = []
    for name, values in (("Accelerometer [m/s2]", log.acc), ("Gyroscope [rad/s]", log.gyr)):
        rows = [",".join([f"{t * 1000 + 12.3:.3f}", f"2026-03-04T14:05:{t:06.3f}Z",
                          *(f"{v:.5f}" for v in row), "31.2"])
                for t, row in zip(log.time_s, values, strict=True)]
        files.append(write_lines(folder / f"GX01_{name.split()[0]}.csv",
                                 [f"cts,date,{name},1,2,temperature [°C]", *rows]))
    return Foreign(files)


def g_force(folder: Path, log: HandLog) -> Foreign:
    """Gx is the force in g along x, and Rx the rate about it."""
    rows = [",".join(f"{v:.5f}" for v in (t, *a, *w))
            for t, a, w in zip(log.time_s, log.acc / G, log.gyr / DEG, strict=True)]
    return Foreign([write_lines(folder / "recorder.csv", ["Time,Gx,Gy,Gz,Rx,Ry,Rz", *rows])],
                   1 / G, 1 / DEG)


def arrow(folder: Path, log: HandLog) -> Foreign:
    names = ("acc_x", "acc_y", "acc_z", "gyro_x", "gyro_y", "gyro_z")
    columns = zip(names, np.hstack([log.acc, log.gyr]).T, strict=True)
    stamps = np.datetime64("2026-03-04T14:05") + (log.time_s * 1e6).astype("timedelta64[us]")
    feather.write_feather(pa.table({"timestamp": stamps, **dict(columns)}), folder / "log.feather")
    return Foreign([folder / "log.feather"])


def xml(folder: Path, log: HandLog) -> Foreign:
    rows = [f'  <sample t="{t}"><acc x="{a}" y="{b}" z="{c}"/><gyr x="{p}" y="{q}" z="{r}"/>'
            for t, a, b, c, p, q, r in si_rows(log)]
    return Foreign([write_lines(folder / "session.xml", ["<recording>", *rows, "</recording>"])])


def two_chips(folder: Path, log: HandLog) -> Foreign:
    """A board whose gyroscope is mounted a quarter turn from its accelerometer."""
    rate = np.column_stack([-log.gyr[:, 1], log.gyr[:, 0], log.gyr[:, 2]])
    rows = [",".join(f"{v:.5f}" for v in (t * 1000, *a, *w))
            for t, a, w in zip(log.time_s, log.acc, rate, strict=True)]
    head = "ms,adxl_ax,adxl_ay,adxl_az,itg_gx,itg_gy,itg_gz"
    return Foreign([write_lines(folder / "gy85.csv", [head, *rows])])


def one_value_a_row(folder: Path, log: HandLog) -> Foreign:
    """A table of InfluxDB that was not pivoted."""
    rows = [f",,0,2026-03-04T14:05:{float(t):06.3f}Z,{value},{name}" for t, *cells in si_rows(log)
            for name, value in zip(("ax", "ay", "az", "gx", "gy", "gz"), cells, strict=True)]
    return Foreign([write_lines(folder / "query.csv", [",result,table,_time,_value,_field",
                                                       *rows])])


def two_boards(folder: Path, log: HandLog) -> Foreign:
    rows = [",".join([row[0], *row[1 + turn : 4], *row[1 : 1 + turn], *row[4:], node])
            for row in si_rows(log) for turn, node in enumerate(("A4:CF:12", "B0:B2:1C"))]
    return Foreign([write_lines(folder / "nodes.csv", ["t,ax,ay,az,gx,gy,gz,node", *rows])])


def thousands(folder: Path, log: HandLog) -> Foreign:
    rows = [";".join(f"{int(v):,}".replace(",", ".") for v in (round(t * 1000), *row))
            for t, row in zip(log.time_s, counts_of(log), strict=True)]
    return Foreign([write_lines(folder / "sheet.csv", ["Zeit_ms;ax;ay;az;gx;gy;gz", *rows])])


SENTENCES: dict[str, Callable[[Path, HandLog], Foreign]] = {
    tool.__name__: tool for tool in (
        idf_monitor, python_logging, wrapped_json, columns_of_json, japanese, vectors,
        units_in_cells, nmea_among_others, witmotion_chinese, browser, aerospace, slow_gyroscope,
        ros2_csv, parts, bno055, whole_seconds, numbered_axes, g_force, arrow, xml,
        two_chips, two_boards, one_value_a_row, a_byte_in_each_line)
}
SENTENCES_REFUSED = {
    "thousands": (thousands, "points separate the thousands"),
}
