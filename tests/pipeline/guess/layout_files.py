"""Recordings in libraries' formats, in several files, or in blocks of a file for each pose."""

import zipfile
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from pyarrow import feather

from tests.pipeline.guess.foreign import (
    AXES,
    DEG,
    EPOCH_S,
    Foreign,
    G,
    Values,
    Writer,
    comma,
    counts_of,
    means_of,
    per_triad,
    pose_rows,
    rows,
    samples,
    when,
    write_lines,
)
from tests.pipeline.guess.hand_log import HandLog
from tests.pipeline.logs.flight_logs import ardupilot_log, px4_log


def zip_of_poses(folder: Path, log: HandLog) -> Foreign:
    """A file for each rest in an archive, in a folder."""
    every = samples(log, 1 / G, 1 / DEG)
    with zipfile.ZipFile(folder / "session.zip", "w") as archive:
        for k in range(int(log.rest.max()) + 1):
            archive.writestr(f"session/pose_{k + 1:02d}.csv", "\n".join([
                "time,accX,accY,accZ,gyroX,gyroY,gyroZ",
                *(s.s for s, rest in zip(every, log.rest, strict=True) if rest == k), ""]))
    return Foreign([folder / "session.zip"], 1 / G, 1 / DEG)


def parquet(folder: Path, log: HandLog) -> Foreign:
    names = [f"{q}_{a}" for q in ("accel", "gyro") for a in "xyz"]
    stamps = pa.array(((1.7e9 + log.time_s) * 1e9).astype("datetime64[ns]"))
    pq.write_table(pa.table({"timestamp": stamps, **dict(zip(
        names, np.hstack([log.acc / G, log.gyr / DEG]).T, strict=True))}), folder / "d.parquet")
    return Foreign([folder / "d.parquet"], 1 / G, 1 / DEG)


def arrow(folder: Path, log: HandLog) -> Foreign:
    names = [f"{q}_{a}" for q in ("acc", "gyro") for a in "xyz"]
    columns = zip(names, np.hstack([log.acc, log.gyr]).T, strict=True)
    stamps = np.datetime64("2026-03-04T14:05") + (log.time_s * 1e6).astype("timedelta64[us]")
    feather.write_feather(pa.table({"timestamp": stamps, **dict(columns)}), folder / "log.feather")
    return Foreign([folder / "log.feather"])


def px4(folder: Path, log: HandLog) -> Foreign:
    return Foreign([px4_log(folder / "flight.ulg", log.time_s, log.acc, log.gyr)])


def ardupilot(folder: Path, log: HandLog) -> Foreign:
    return Foreign([ardupilot_log(folder / "flight.bin", log.time_s, log.acc, log.gyr)])


def means(folder: Path, log: HandLog) -> Foreign:
    rests = [log.acc[log.rest == k] for k in range(int(log.rest.max()) + 1)]
    return Foreign([write_lines(folder / "means.csv", ["ax,ay,az,ax_std,ay_std,az_std,samples", *(
        f"{Values((*each.mean(axis=0), *each.std(axis=0, ddof=1), len(each))):,.7g}"
        for each in rests)])], 1.0, None)


def means_with_sds(folder: Path, log: HandLog) -> Foreign:
    """A student's table: a mean and its sd in each cell, with decimal commas."""
    lines = [";".join([str(k + 1), *(f"{a.mean():.4f} ± {a.std() / 5:.4f}"
                                     for a in log.acc[log.rest == k].T)]) for k in range(18)]
    return Foreign([write_lines(folder / "Mittelwerte.csv", [
        "Lage;ax (m/s²);ay (m/s²);az (m/s²)", *map(comma, lines)], "cp1252")], 1.0, None)


def labels_from_the_first_line(folder: Path, log: HandLog) -> Foreign:
    """Means of poses, none of which may be lost."""
    return Foreign([write_lines(folder / "faces.txt", [
        "X: {:.4f} Y: {:.4f} Z: {:.4f}".format(*each) for each in means_of(log)])], 1.0, None)


def headed_blocks(folder: Path, log: HandLog) -> Foreign:
    """`Pose 3` and the header again above each block; times begin again in each.

    Nothing in rests shows the range of a gyroscope.
    """
    out = []
    for k in range(int(log.rest.max()) + 1):
        at = np.flatnonzero(log.rest == k)
        out += [f"Pose {k + 1}", "t_ms\tax\tay\taz\tgx\tgy\tgz",
                *("\t".join(map(str, (round(1000 * (t - log.time_s[at[0]])), *row)))
                  for t, row in zip(log.time_s[at], counts_of(log)[at], strict=True)), ""]
    return Foreign([write_lines(folder / "all_poses.txt", out)], 16384 / G, None)


def blocks(folder: Path, log: HandLog) -> Foreign:
    """The rests alone, each a block of gnuplot whose clock begins at 0."""
    lines = ["# poses of a board"]
    for pose in range(log.rest.max() + 1):
        at = np.flatnonzero(log.rest == pose)
        table = np.column_stack([log.time_s[at] - log.time_s[at[0]], log.acc[at], log.gyr[at]])
        lines += ["", "", f"# pose {pose}", *(f"{Values(row): .5f}" for row in table)]
    return Foreign([write_lines(folder / "poses.dat", lines)])


def poses_beside_each_other(folder: Path, log: HandLog) -> Foreign:
    """A block of columns for each pose in one sheet, with a title above and an empty column."""
    poses = [[f"{t:.2f},{Values(row):,.4f}" for t, row in zip(
        log.time_s, log.acc[log.rest == k], strict=False)] for k in range(18)]
    return Foreign([write_lines(folder / "sheet.csv", [
        ",,,,".join(f"Pose {k + 1}," for k in range(18)), ",,".join(["t [s],ax,ay,az"] * 18),
        *map(",,".join, zip(*poses, strict=True))])], 1.0, None)


def rows_of_other_widths(folder: Path, log: HandLog) -> Foreign:
    """A short file for each pose, in which a few rows are those of other sensors."""
    files = []
    every = samples(log, 1.0, 1 / DEG)
    for k in range(18):
        lines = ["sensor,TSND", "kind,time[ms],X,Y,Z,gyro X,gyro Y,gyro Z"]
        for j, s in enumerate(every[i] for i in np.flatnonzero(log.rest == k)):
            lines.append(f"ags,{1000 * s.t:.0f},{s.a:,.6f},{s.w:,.6f}")
            if j % 10 == 0:
                lines += [f"geo,{1000 * s.t + 1:.0f},-105,{254 + j},-395", "pres,7,101312,23"]
        files.append(write_lines(folder / f"p{k:02d}.csv", lines))
    return Foreign(files, 1.0, 1 / DEG)


def a_field_after_another(folder: Path, log: HandLog) -> Foreign:
    """A query of InfluxDB as its page saves it: all values of one name, then of the next."""
    values = np.hstack([log.acc, log.gyr])
    return Foreign([write_lines(folder / "influx.csv", [
        "#datatype,string,long,dateTime:RFC3339,double,string", ",result,table,_time,_value,_field",
        *(f",,{j},2026-11-27T17:{int(t // 60):02d}:{t % 60:06.3f}Z,{v:.6f},{name}"
          for j, name in enumerate(AXES.split(",")) for t, v in zip(log.time_s, values[:, j],
                                                              strict=True)), ""])])


def topics_of_a_broker(folder: Path, log: HandLog) -> Foreign:
    """Two topics at two rates."""
    return rows("mqtt.log", "", lambda s: "\n".join(
        f'bench/{name} {{"ts":{1000 * s.t:.0f},"x":{v[0]:.6f},"y":{v[1]:.6f},"z":{v[2]:.6f}}}'
        for name, v in (("acc", s.a), ("gyr", s.w))[: 2 - s.i % 2]), 1 / G, 1 / DEG)(folder, log)


def parts(folder: Path, log: HandLog) -> Foreign:
    """A card's files, of which the first alone has a header."""
    lines = [each.s for each in samples(log)]
    return Foreign([write_lines(folder / f"LOG{i}.CSV", [f"t,{AXES}"][i:] + part)
                    for i, part in enumerate((lines[:900], lines[900:1800], lines[1800:]))])


FILES: dict[str, Writer] = {
    **{each.__name__: each for each in (
        zip_of_poses, parquet, arrow, px4, ardupilot, means, means_with_sds,
        labels_from_the_first_line, headed_blocks, blocks, poses_beside_each_other,
        rows_of_other_widths, a_field_after_another, topics_of_a_broker, parts)},
    # no times at all, in g
    "one_file_per_pose": pose_rows("pose{}.txt", "x,y,z", lambda s: f"{s.a:,.7g}", 1 / G, None),
    # an MTi's raw counts, of gains that no list of ranges has
    "gains_of_their_own": per_triad({"mti_acc.txt": "", "mti_gyro.txt": ""}, "", lambda t, v: (
        f"{t:.5f} {Values(round(x) + 32768 for x in v): d}"), 415, 4780),
    # a folder for each sensor, with files and columns of the same names
    "sensors_in_folders": per_triad({"acc/data.csv": "", "gyro/data.csv": ""}, "timestamp,x,y,z",
                                    lambda t, v: f"{t:.3f},{v:,.6f}"),
    # a camera's telemetry: the name of the sensor stands over its first axis only
    "numbered_axes": per_triad(
        {"GX01_Accelerometer.csv": "Accelerometer [m/s2]", "GX01_Gyroscope.csv":
            "Gyroscope [rad/s]"}, "cts,date,{},1,2,temperature [°C]", lambda t, v: (
            f"{t * 1000 + 12.3:.3f},2026-03-04T14:05:{t:06.3f}Z,{v:,.5f},31.2")),
    # MbientLab: a file for each sensor, three clocks
    "metawear": per_triad(
        {"MetaWear_2024_Accelerometer.csv": "g", "MetaWear_2024_Gyroscope.csv": "deg/s"},
        "epoc (ms),timestamp (+0100),elapsed (s),x-axis ({}),y-axis ({}),z-axis ({})",
        lambda t, v: f"{round((EPOCH_S + t) * 1000)},{when(t, '%Y-%m-%dT%H:%M:%S.%f')},{t:.3f},"
                     f"{v:,.4f}", 1 / G, 1 / DEG),
    # Consensys: `sep=`, names, calibrated flags and units, each in a line; tabs
    "shimmer": rows("shimmer.csv", '"sep=\t"\nShimmer_5E_Timestamp_Unix_CAL\t' + "".join(
        f"Shimmer_5E_{name}_{axis}_CAL\t" for name in ("Accel_LN", "Gyro") for axis in "XYZ")
        + "\nms\t" + "m/(s^2)\t" * 3 + "deg/s\t" * 3, lambda s: (
            f"{(EPOCH_S + s.t) * 1000:.3f}\t{s.a:\t.6f}\t{s.w:\t.6f}\t"), gyr=1 / DEG),
}
