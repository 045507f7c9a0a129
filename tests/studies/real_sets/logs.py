"""Measured sessions of other people: what the program is given, and the same logs read by hand.

The reader, the search for stops and the sds here share no code with the program; they are plain on
purpose. A stop is a stretch whose half-second windows scatter less than ``still``, a figure chosen
for each log by eye from its quietest stretches.
"""

import gzip
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from calib.poses.imu_log import FloatArray
from tests.paths import SHARED

REAL = SHARED / "real"
WINDOW_S, CUT_S, SHORTEST_S = 0.5, 0.2, 0.6
BLOCKS = 6


@dataclass(frozen=True)
class Log:
    """One log, and the lines of configuration that describe it.

    ``still`` is in the unit of the accelerometer (or of the gyroscope, where that is alone); with
    ``block`` set, every so many rows are a pose by themselves, as their author recorded them.
    ``nominal`` (offset, unit per count) of each triad makes counts SI before anything else.
    """

    name: str
    files: tuple[str, ...]
    columns: tuple[tuple[str, ...], ...]
    sensor: str
    gravity: float
    still: float
    rate_hz: float | None = None
    block: int | None = None
    nominal: tuple[tuple[float, float], tuple[float, float]] = ((0.0, 1.0), (0.0, 1.0))
    gyroscope: bool = True

    def configuration(self) -> str:
        """The YAML file that the program is given."""
        paths = ", ".join(str(REAL / file) for file in self.files)
        names = ", ".join(f"[{', '.join(each)}]" for each in self.columns)
        rate = "" if self.rate_hz is None else f", sample_rate_hz: {self.rate_hz:g}"
        poses = f"{{log: [{paths}], columns: [{names}]{rate}, find: still}}"
        text = f"sensor: {self.sensor}\nsite: {{gravity_m_s2: {self.gravity}}}\n"
        text += f"accelerometer:\n  poses: {poses}\n"
        if self.gyroscope:
            text += f"gyroscope:\n  model: [bias]\n  runs: [{{rate: stopped, poses: {poses}}}]\n"
        return text

    def table(self) -> dict[str, FloatArray]:
        """Every column by its name, and ``time_s``."""
        columns: dict[str, FloatArray] = {}
        for file, names in zip(self.files, self.columns, strict=True):
            rows = numbers_in(REAL / file, len(names))
            columns |= dict(zip(names, rows.T, strict=True))
        n = len(columns["acc_x"])
        if "time_s" not in columns:
            assert self.rate_hz is not None
            columns["time_s"] = np.arange(n) / self.rate_hz
        columns["time_s"] = columns["time_s"] - columns["time_s"][0]
        return columns


def numbers_in(path: Path, width: int) -> FloatArray:
    """Rows of ``path`` that begin with ``width`` numbers, in the order of time."""
    text = gzip.decompress(path.read_bytes()).decode()
    rows = []
    for line in text.splitlines():
        cells = line.replace(",", " ").split()[:width]
        try:
            rows.append([float(cell) for cell in cells])
        except ValueError:  # a header
            continue
    return np.array([row for row in rows if len(row) == width])


@dataclass(frozen=True, eq=False)
class Stops:
    """What a log shows where it stops: n stops, SI; the sds are of block means of each."""

    time_s: FloatArray
    seconds: FloatArray
    force: FloatArray
    force_sd: FloatArray
    rate: FloatArray
    rate_sd: FloatArray
    temperature: FloatArray

    def __len__(self) -> int:
        return len(self.time_s)


def stops_of(log: Log) -> Stops:
    """The stops of a log, by this module's own search."""
    columns = log.table()
    (offset, gain), (zero, slope) = log.nominal
    force = np.column_stack([columns[f"acc_{axis}"] for axis in "xyz"])
    force = (force - offset) * gain
    rate = np.column_stack([columns.get(f"gyr_{a}", np.full(len(force), np.nan)) for a in "xyz"])
    rate = (rate - zero) * slope
    t = columns["time_s"]
    spans = _blocks(len(t), log.block) if log.block else _still(t, force, log.still)
    temperature = columns.get("temperature_c", np.full(len(t), np.nan))
    return Stops(
        np.array([t[a:b].mean() for a, b in spans]),
        np.array([t[b - 1] - t[a] for a, b in spans]),
        np.array([force[a:b].mean(axis=0) for a, b in spans]),
        np.array([_sd_of_mean(force[a:b]) for a, b in spans]),
        np.array([rate[a:b].mean(axis=0) for a, b in spans]),
        np.array([_sd_of_mean(rate[a:b]) for a, b in spans]),
        np.array([temperature[a:b].mean() for a, b in spans]),
    )


def _blocks(n: int, size: int) -> list[tuple[int, int]]:
    cut = size // 20
    return [(i + cut, i + size - cut) for i in range(0, n - size + 1, size)]


def _still(t: FloatArray, values: FloatArray, still: float) -> list[tuple[int, int]]:
    step = float(np.median(np.diff(t)))
    width = max(6, round(WINDOW_S / step))
    windows = np.lib.stride_tricks.sliding_window_view(values, width, axis=0)
    scatter = np.sqrt(windows.var(axis=2).sum(axis=1))
    calm = np.zeros(len(t), bool)
    for i in np.flatnonzero(scatter < still):
        calm[i : i + width] = True
    edges = np.flatnonzero(np.diff(np.r_[0, calm.astype(int), 0]))
    cut, least = round(CUT_S / step), max(2 * BLOCKS, round(SHORTEST_S / step))
    spans = [(a + cut, b - cut) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return [(a, b) for a, b in spans if b - a >= least and not _turns(values[a:b], still)]


def _turns(values: FloatArray, still: float) -> bool:
    """Whether a stretch that is calm in every window turns as a whole."""
    half = len(values) // 2
    return bool(np.linalg.norm(values[:half].mean(axis=0) - values[half:].mean(axis=0)) > still)


def _sd_of_mean(values: FloatArray) -> FloatArray:
    length = len(values) // BLOCKS
    means = values[: BLOCKS * length].reshape(BLOCKS, length, 3).mean(axis=1)
    return np.asarray(means.std(axis=0, ddof=1) / np.sqrt(BLOCKS))


IMU = ("acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z")
SNU = (("time_s", *IMU, "mag_x", "mag_y", "mag_z", "q_x", "q_y", "q_z", "q_w"),)
SUNDEVIL = (("time_s", *IMU, "mag_x", "mag_y", "mag_z", "zero", "pressure_kpa", "temperature_c"),)
IN_SI = "{accelerometer: {unit: m_s2}, gyroscope: {unit: rad_s}}"
IN_DEG = "{accelerometer: {unit: m_s2}, gyroscope: {unit: deg_s}}"
XSENS = ("{accelerometer: {full_scale_m_s2: 79, bits: 16, encoding: offset-binary}, "
         "gyroscope: {full_scale_deg_s: 394, bits: 16, encoding: offset-binary}}")

LOGS = {log.name: log for log in (
    Log("xsens", ("imu_tk_xsens/xsens_acc.mat.gz", "imu_tk_xsens/xsens_gyro.mat.gz"),
        (("time_s", *IMU[:3]), ("time_s", *IMU[3:])), XSENS, 9.81744, 0.06,
        nominal=((32768.0, 1 / 415), (32768.0, 1 / 4770))),
    *(Log(f"snu good{k}", (f"snu/imu_good{k}.txt.gz",), SNU, IN_SI, 9.79871, 0.1)
      for k in (1, 2, 3)),
    *(Log(f"sundevil {name}", (f"sundevil/{file}.txt.gz",), SUNDEVIL, IN_DEG, 9.7949, still,
          nominal=((0.0, 1.0), (0.0, np.pi / 180)))
      for name, file, still in (
          ("long", "IMU_Rev2_Data_Long", 0.16), ("short", "IMU_Rev2_Data_Short", 0.16),
          ("table", "imu_cal_data_with_table", 0.11), ("units", "imu_data_units", 0.11))),
    Log("freeimucal", ("freeimucal/Officeacc.txt.gz",), (IMU[:3],), "{accelerometer: {unit: m_s2}}",
        9.80665, 0.16, rate_hz=69, gyroscope=False),
    Log("ck", ("ck/acc_log.csv.gz",), (IMU[:3],), "{accelerometer: {unit: g}}", 9.80665, 0.0,
        rate_hz=100, block=100, nominal=((0.0, 9.80665), (0.0, 1.0)), gyroscope=False),
)}  # fmt: skip
