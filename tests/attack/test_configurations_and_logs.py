"""Configurations and logs that are wrong in ways that a file can be."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.attack.case import POSE, Case, Spoil, append, both, check, edit, lines, rows, write

SHEET = "full_scale_m_s2: 50, bits: 16, encoding: offset-binary"
MODEL = "model: [bias, scale, misalignment]\n\ngyroscope"
GYRO_MODEL = "rate: 17rpm}\n  model: [bias, scale, misalignment]"


def cells(change: Callable[[list[str], int], list[str]], name: str = POSE) -> Spoil:
    """Other cells in a log, by their row."""
    return lines(lambda all_: [all_[0], *(",".join(change(line.split(","), i))
                                          for i, line in enumerate(all_[1:]))], name)


def cell(value: str, name: str) -> Spoil:
    """Another cell in the fifth row of a log."""
    return cells(lambda c, i: [*c[:2], value, *c[3:]] if i == 4 else c, name)


def folder_only(name: str) -> Spoil:
    """A folder where a file is expected."""

    def spoil(config: Path) -> None:
        (config.parent / name).unlink()
        (config.parent / name).mkdir()

    return spoil


def many_missing(config: Path) -> None:
    """A list of 4,000 files of which none is there."""
    named = ", ".join(f"p{i}.csv" for i in range(4_000))
    edit("poses: accelerometer/pose_*.csv", f"poses: [{named}]")(config)


def without_accelerometer(name: str) -> Spoil:
    """A log with its gyroscope alone."""
    return lines(lambda all_: [",".join([line.split(",")[0], *line.split(",")[4:7]])
                               for line in all_], name)


def without_noise(config: Path) -> None:
    """Every pose gives the same reading in all its samples."""
    for path in (config.parent / "accelerometer").iterdir():
        head, first, *rest = path.read_text(encoding="utf-8").splitlines()
        same = first.split(",")[1:]
        changed = [",".join([line.split(",")[0], *same]) for line in (first, *rest)]
        path.write_text("\n".join([head, *changed]) + "\n", encoding="utf-8")


CONFIGURATIONS = (
    Case("empty file", "check CONFIG", 2, ".", write("config.yaml", "")),
    Case("only a comment", "check CONFIG", 2, ".", write("config.yaml", "# nothing\n")),
    Case("a list", "check CONFIG", 2, ".", write("config.yaml", "- a\n- b\n")),
    Case("a number", "check CONFIG", 2, ".", write("config.yaml", "7\n")),
    Case("two documents", "check CONFIG", 2, ".", append("---\ntitle: x")),
    Case("an anchor", "check CONFIG", 2, ".", edit("title: MTi", "title: &a MTi")),
    Case("a tag", "check CONFIG", 2, ".", edit("title: MTi", "title: !!python/object:x MTi")),
    Case("a merge key", "check CONFIG", 2, ".", append("<<: {a: 1}")),
    Case("a tab", "check CONFIG", 2, "tab", append("x:\n\ty: 1")),
    Case("no text", "check CONFIG", 2, "UTF-8", write("config.yaml", b"\xff\xfe\x00a")),
    Case("a zero byte", "check CONFIG", 2, ".", write("config.yaml", b"title: a\0b\n")),
    Case("half a surrogate", "check CONFIG", 2, "half a character",
         edit("title: MTi", 'title: "\\uD800" #')),
    Case("ten megabytes", "check CONFIG", 2, "larger than", write("config.yaml", "#" * 10_000_000)),
    Case("deep nesting", "check CONFIG", 2, ".", append("x: " + "[" * 200 + "]" * 200)),
    Case("the wrong encoding", "run CONFIG", 3, "offset-binary", edit(
        "encoding: offset-binary", "encoding: twos-complement")),
    Case("no poses", "check CONFIG", 2, "accelerometer.poses",
         edit("poses: accelerometer/pose_*.csv", "poses: []")),
    Case("no poses in files", "check CONFIG", 2, "accelerometer.poses",
         edit("poses: accelerometer/pose_*.csv", "poses: {files: []}")),
    Case("no runs", "check CONFIG", 2, "runs",
         edit("runs:\n    - {poses: gyroscope/17rpm/pose_*.csv, rate: 17rpm}", "runs: []")),
    Case("4,000 missing files", "check CONFIG", 3, "p0.csv", many_missing),
    Case("a folder as poses", "check CONFIG", 2, "is a folder",
         edit("poses: accelerometer/pose_*.csv", "poses: accelerometer")),
    Case("a folder among the poses", "run CONFIG", 2, "which is a folder, and a pose would be",
         folder_only(POSE)),
    Case("a zero byte in a pattern", "check CONFIG", 3, "there is no file",
         edit("poses: accelerometer/pose_*.csv", 'poses: "a\\0b"')),
    Case("a long pattern", "check CONFIG", 2, "cannot be the name",
         edit("poses: accelerometer/pose_*.csv", f"poses: {'a' * 5000}.csv")),
    Case("a pattern upwards", "check CONFIG", 3, "no file matches",
         edit("poses: accelerometer/pose_*.csv", "poses: ../../../nowhere/*.csv")),
    Case("a pattern of brackets", "check CONFIG", 3, ".",
         edit("poses: accelerometer/pose_*.csv", 'poses: "[[[*"')),
    *(Case(f"{old.split(':')[0]}: {value}", "check CONFIG", 2, "found|expected",
           edit(old, f"{old.split(': ')[0]}: {value}"))
      for old, values in (
          ("full_scale_m_s2: 50", ("0", "-1", ".nan", ".inf", "1e300", "1e-300", "x", "9" * 400)),
          ("bits: 16, encoding: offset-binary}\n  gyr", ("7}\n  gyr", "33}\n  gyr", "1e1}\n  gyr")),
          ("rate_rad_s: 1.74512535", ("1e300", ".nan", "[1]", "true")),
          ("sd_rad_s: 8.73e-05", ("0", "-1", "1e300", "1e-300")),
          ("gravity_m_s2: 9.80267", ("0", "9.0", "-9.8", "1e9", ".inf")),
          ("latitude_deg: 40.85", ("91", "-91", ".nan", "north")),
          ("poses: accelerometer/pose_*.csv",
           ("{files: accelerometer/*.csv, sample_rate_hz: 1e11}",)),
      ) for value in values),
    Case("a model without effects", "check CONFIG", 2, "model",
         edit(MODEL, "model: []\n\ngyroscope")),
    Case("an effect twice", "check CONFIG", 2, "given twice",
         edit(MODEL, "model: [bias, bias]\n\ngyroscope")),
    Case("an effect of the other triad", "run CONFIG", 2, "no effect of the accelerometer",
         edit(MODEL, "model: [bias, scale, misalignment, g_sensitivity]\n\ngyroscope")),
    Case("paper with other effects", "run CONFIG", 2, "paper",
         edit(MODEL, "model: [bias, scale, misalignment, cubic]\n  solver: paper\n\ngyroscope")),
    Case("paper with another loss", "run CONFIG", 2, "paper", edit(
        MODEL, "model: [bias, scale, misalignment]\n  solver: paper\n  loss: huber\n\ngyroscope")),
    Case("a model of reference_scale alone", "run CONFIG", 0, "report.html",
         edit(MODEL, "model: [reference_scale]\n\ngyroscope")),
    Case("a model of cubic alone", "run CONFIG", 5, "larger than the readings themselves",
         edit(MODEL, "model: [cubic]\n\ngyroscope")),
    Case("an effect that one speed does not show", "check CONFIG", 4, "cannot see 'g_sensitivity'",
         edit(GYRO_MODEL, f"{GYRO_MODEL[:-1]}, g_sensitivity]")),
    Case("more parameters than poses", "check CONFIG", 4, "18 equations for 19 parameters",
         edit(MODEL, "model: [bias, scale, misalignment, cubic, hysteresis, "
                     "temperature_bias]\n\ngyroscope")),
    Case("an effect of the accelerometer, which is not logged", "check CONFIG", 4,
         "the accelerometer was not logged", both(
             edit(GYRO_MODEL, f"{GYRO_MODEL[:-1]}, g_sensitivity]"),
             *(without_accelerometer(f"gyroscope/17rpm/pose_{i:02}.csv") for i in range(1, 19)))),
    *(Case(f"an expression: {text[:30]}", "check CONFIG", 2, "effects.x",
           append(f"effects: {{x: {{expression: '{text}', unit: m}}}}"))
      for text in ("", "(", "1 +", "__import__(1)", "time_s.__class__", "x if y else z", "a" * 600,
                   "[i for i in s]", "lambda: 1", "time_s ** 99", "9" * 400, "1e400",
                   "time_s ** time_s", "print(1)", "exp(1, 2)", "no_such_column")),
    Case("an effect's name", "check CONFIG", 2, "cannot name",
         append("effects: {'x y': {expression: time_s, unit: m}}")),
    Case("Python without permission", "run CONFIG", 2, "--allow-python", both(
        write("p.py", "def f(at):\n    return at.vector\n"),
        append("effects: {x: {python: 'p.py:f', unit: m}}"))),
    Case("Python that raises", "run CONFIG --allow-python", 4, "x", both(
        write("p.py", "def f(at):\n    return 1 / 0\n"),
        edit(GYRO_MODEL, GYRO_MODEL[:-1] + ", x]"),
        append("effects: {x: {python: 'p.py:f', unit: m, triad: gyroscope}}"))),
    Case("Python that is no Python", "check CONFIG", 2, "p.py", both(
        write("p.py", "def f(:\n"), append("effects: {x: {python: 'p.py:f', unit: m}}"))),
    Case("output in a file", "run CONFIG", 2, ".", append("output: config.yaml/x")),
    Case("output of another folder's file", "run CONFIG", 2, ".",
         append("output: accelerometer/pose_01.csv")),
    Case("output with a zero byte", "run CONFIG", 2, "output", append('output: "a\\0b"')),
    Case("a long output", "run CONFIG", 2, "output|255", append(f"output: {'o' * 3000}")),
)

LOGS = (
    Case("poses without noise", "run CONFIG", 4, "froze", without_noise),
    Case("an empty pose", "run CONFIG", 3, "pose_07.csv: the file is empty", write(POSE, "")),
    Case("one row", "run CONFIG", 3, "pose_07.csv", lines(lambda all_: all_[:2])),
    Case("eleven rows", "run CONFIG", 4, "11 samples", lines(lambda all_: all_[:12])),
    Case("a row cut off", "run CONFIG", 0, "pose_07.csv: rows .* left out: 1 of 400", lines(
        lambda all_: [*all_[:-1], all_[-1][:9]])),
    Case("text in every ninth row", "run CONFIG", 3, "pose_07.csv:2: column acc_y.* 45 of", cells(
        lambda c, i: [*c[:2], "x", *c[3:]] if i % 9 == 0 else c)),
    *(Case(f"cells of {', '.join(three)}", "run CONFIG", 0,  # lost samples, told of each pose
           "".join(rf"(?=[^$]*pose_0{i}.csv: rows .*left out: 1 of)" for i in (1, 2, 3)),
           both(*(cell(value, f"accelerometer/pose_0{i}.csv") for i, value in enumerate(three, 1))))
      for three in (("nan", "x", "1_0"), ("0x10", "１２", ""), ("inf", "-inf", "1e400"))),
    Case("a cell of 1e300", "run CONFIG", 3, "pose_07.csv", cell("1e300", POSE)),
    Case("time backwards", "run CONFIG", 3, "pose_07.csv:1?[0-9]", cells(
        lambda c, i: ["0.0", *c[1:]] if i == 9 else c)),
    Case("time that stands", "run CONFIG", 3, "pose_07", rows(lambda c: ["1.0", *c[1:]])),
    Case("time of nan", "run CONFIG", 3, "pose_07", rows(lambda c: ["nan", *c[1:]])),
    Case("time of 1e300", "run CONFIG", 3, "pose_07", cells(
        lambda c, i: [f"{1e300 * (i + 1)}", *c[1:]])),
    Case("binary", "run CONFIG", 3, "pose_07", write(POSE, os.urandom(5000))),
    Case("a gzip that is cut off", "apply RUN HERE/x.csv.gz", 3, "x.csv.gz",
         write("x.csv.gz", "time_s,acc_x,acc_y,acc_z\n" * 10)),
    Case("zeros packed", "apply RUN HERE/x.gz", 3, "x.gz", write("x.gz", b"\0" * 10**7)),
    Case("blanks packed", "apply RUN HERE/x.gz", 3, "x.gz", write("x.gz", b" " * 10**7)),
    Case("one long line", "apply RUN HERE/x.csv", 3, "x.csv", write("x.csv", "1," * 20_000)),
    Case("a header of 10,000 columns", "apply RUN HERE/x.csv", 3, "x.csv", write(
        "x.csv", ",".join(f"c{i}" for i in range(10_000)) + "\n1\n")),
    Case("UTF-16", "apply RUN HERE/x.csv", 3, "x.csv",
         write("x.csv", "a,b\n1,2\n".encode("utf-16"))),
    Case("a column twice", "run CONFIG", 3, "twice", lines(
        lambda all_: [all_[0].replace("temperature_c", "acc_x"), *all_[1:]])),
    Case("a saturated pose", "run CONFIG", 4, "saturated", rows(lambda c: [c[0], "65535", *c[2:]])),
    Case("counts beyond the converter", "run CONFIG", 3, "pose_07.*70000", rows(
        lambda c: [c[0], "70000", *c[2:]])),
)
CASES = (*CONFIGURATIONS, *LOGS)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_configurations_and_logs(
    case: Case, copied: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    check(case, copied, capsys)
