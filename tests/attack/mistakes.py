"""Mistakes in the files of a session: what is done to it, the exit code and what must be said."""

import shutil
from pathlib import Path

import numpy as np

from tests.attack.spoilt import (
    ACC,
    GYR,
    Spoil,
    appended,
    axes,
    both,
    config_text,
    dead,
    frozen,
    logs,
    part,
    rocking,
    scaled,
    times,
    without,
)

SWAP = (1, 0, 2)
EVERY, REST, TURNING = "*/**/*.csv", "accelerometer/*.csv", "gyroscope/*/*.csv"
POSE_7, FAST = "accelerometer/pose_07.csv", "gyroscope/33rpm/*.csv"
RUN_17 = "- {poses: gyroscope/17rpm/pose_*.csv, rate: 17rpm}"
MODEL = "model: [bias, scale, misalignment]"


def two_names(config: Path) -> None:
    for path in sorted(config.parent.glob(REST)):
        shutil.copy(path, path.with_name(f"again_{path.name}"))
    config_text("accelerometer/pose_*.csv", "accelerometer/*.csv")(config)


def copied_block(config: Path) -> None:
    lines = (config.parent / POSE_7).read_text(encoding="utf-8").splitlines()
    other = config.parent / "accelerometer/pose_03.csv"
    rows = other.read_text(encoding="utf-8").splitlines()
    for i in range(101, 201):
        stamp, _, _ = rows[i].partition(",")
        rows[i] = f"{stamp},{lines[i].partition(',')[2]}"
    other.write_text("\n".join(rows) + "\n", encoding="utf-8")


def gap(config: Path) -> None:
    path = config.parent / "gyroscope/17rpm/pose_05.csv"
    lines = path.read_text(encoding="utf-8").splitlines()
    path.write_text("\n".join(lines[:300] + lines[500:]) + "\n", encoding="utf-8")


def stuck_temperature_cell(config: Path) -> None:
    path = config.parent / POSE_7
    lines = path.read_text(encoding="utf-8").splitlines()
    lines[40] = f"{lines[40].rpartition(',')[0]},nan"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    config_text(MODEL, f"{MODEL[:-1]}, temperature_bias]", 1)(config)


def kelvin(table: np.ndarray) -> np.ndarray:
    table[:, 7] += 273.15
    return table


def installed(keys: str) -> Spoil:
    return appended(f"\ninstallation: {{{keys}}}\n")


RATES_OF_RUNS_EXCHANGED = both(
    config_text("17rpm/pose_*.csv, rate: 17rpm", "17rpm/pose_*.csv, rate: X", 1),
    config_text("/33rpm/pose_*.csv, rate: 33rpm", "/33rpm/pose_*.csv, rate: 17rpm"),
    config_text("rate: X", "rate: 33rpm"),
)

#: session, what is done to it, command, exit code, what must be said (all of it)
CASES: dict[str, tuple[str, Spoil, str, int, str]] = {
    # the gyroscope's axes against the accelerometer's
    "the triads exchanged": ("paper", logs(EVERY, lambda t: t[:, [0, 4, 5, 6, 1, 2, 3, 7]]),
                             "run", 4, "accelerometer"),
    # gravity
    "gravity of another planet": (
        "paper", config_text("gravity_m_s2: 9.80267", "gravity_m_s2: 9.89"), "check", 2,
        "site.gravity_m_s2|9.835"),
    "gravity by habit": ("paper", config_text("gravity_m_s2: 9.80267", "gravity_m_s2: 9.81"),
                         "check", 2, "between 9.7985 and 9.8065|height_m"),
    # samples that count twice
    "the same files under new names": ("paper", two_names, "check", 4,
                                       "hold the same accelerometer samples"),
    "the same run twice": ("rich", config_text(RUN_17, f"{RUN_17}\n    {RUN_17}"), "check", 2,
                           "is in gyroscope.runs[0].poses as well"),
    "one file by two paths": (
        "paper", config_text("poses: accelerometer/pose_*.csv", "poses: [accelerometer/pose_*.csv, "
                             "accelerometer/../accelerometer/pose_01.csv]"), "check", 2,
        "is named twice"),
    "a copied block": ("paper", copied_block, "check", 4, "a block was copied"),
    # the clock
    "milliseconds": ("paper", logs(TURNING, times(1e3)), "check", 3,
                     "clock makes no sense|time_unit: ms"),
    "a counter": ("paper", logs(TURNING, times(50.0)), "run", 4, "samples in a turn|a counter"),
    "stamps stretched by two": ("paper", logs(TURNING, times(2.0)), "run", 4,
                                "gravity goes round once per turn|do not count seconds"),
    "a gap": ("paper", gap, "run", 4, "of samples are missing after sample"),
    # rates
    "rates exchanged, gyroscope alone": (
        "rich", both(RATES_OF_RUNS_EXCHANGED, without(ACC)), "run", 4,
        "the rates (or the clips, or the files)|are exchanged"),
    "a rate that nobody knows": ("paper", config_text("sd_rad_s: 8.73e-05", "sd_rad_s: 1.0"),
                                 "check", 2, "determines no scale"),
    # one pose
    "a pose that froze": ("paper", logs(POSE_7, frozen(0.0)), "check", 4, "pose_07.csv: froze"),
    "a pose turned to and fro": (
        "paper", logs(POSE_7, part(axes(ACC, SWAP), 0.25, 0.75)), "run", 4,
        "pose_07.csv: the sensor moved"),
    "a pose turned half way": ("paper", logs(POSE_7, part(axes(ACC, SWAP), 0.5, 1.0)), "run", 4,
                               "pose_07.csv: the sensor moved"),
    "a pose that rocks": ("paper", logs(POSE_7, rocking(8.0, 9500.0)), "run", 4,
                          "pose_07.csv: the sensor was shaken|short of gravity"),
    "a dead axis of the accelerometer": ("rich", logs(EVERY, dead(3)), "run", 4,
                                         "stopped: accelerometer z is dead|wiring"),
    "a dead axis of the gyroscope in one run": (
        "rich", logs(FAST, dead(6)), "run", 4, "33rpm: gyroscope z is dead"),
    "a thousand times too small": (
        "rich", logs(EVERY, scaled(ACC, 1e-3, 0)), "check", 4, "where 9.8027 m/s² is expected"),
    "a pose of zeros": ("rich", logs("gyroscope/17rpm/pose_03.csv", scaled(GYR, 0.0, 0)), "run", 4,
                        "pose_03.csv|the plate turns at 1.745"),
    "moved on the plate": (
        "paper", logs("gyroscope/17rpm/pose_02.csv", part(axes(GYR, SWAP), 0.3, 0.6)), "run", 4,
        "pose_02.csv: the sensor was moved on the turning plate"),
    # the mounting
    "installed on the turning plate": (
        "paper", installed("log: gyroscope/17rpm/pose_03.csv"), "run", 4, "was turning"),
    "the same log at both headings": (
        "paper", installed(f"log: {POSE_7}, reverse_log: {POSE_7}"), "check", 2,
        "is the file of `log`"),
    "kelvin in one run": ("rich", logs(FAST, kelvin), "check", 4, "temperature_c|in kelvin"),
    # found by check
    "a column that is not there": (
        "paper", config_text(MODEL, f"{MODEL[:-1]}, column:nope]", 1), "check", 2,
        "needs the column nope"),
    "an empty cell of a column": ("paper", stuck_temperature_cell, "check", 4,
                                  "has no number at sample 40"),
    "a gyroscope's effect": ("paper", config_text(MODEL, f"{MODEL[:-1]}, g_sensitivity]", 1),
                             "check", 2, "is no effect of the accelerometer"),
    "no poses": ("paper", config_text("poses: accelerometer/pose_*.csv", "poses: []"), "check", 2,
                 "the list is empty"),
    "a loss that the solver lacks": (
        "paper", config_text(MODEL, f"{MODEL}\n  solver: paper\n  loss: huber", 1), "check", 2,
        "plain least squares only"),
}
