"""Results edited by hand, limits of a calibration, names that would act in an export."""

import json
from pathlib import Path

import pytest

from tests.attack.case import Case, Spoil, both, check, edit, lines, result, rows, write

NAME = ("sensor",)
GYRO = ("gyroscope",)
EDITED = "is not what `pipeline run` writes"


def cut(name: str, share: float) -> Spoil:
    """A file that ends too early."""

    def spoil(config: Path) -> None:
        path = config.parent / name
        data = path.read_bytes()
        path.write_bytes(data[: int(len(data) * share)])

    return spoil


def history(line: object) -> Spoil:
    """Another line of history."""
    return write("config.run/history.jsonl", f"{json.dumps(line)}\n")


STEP = {"model": ["bias"], "residual_rms": 1.0, "loo_rms": 1.0, "chi2": 1.0, "dof": 1,
        "verdict": "noise"}
RUN = {"when": "2024-01-01T12:00:00", "config_sha256": "0", "accelerometer": STEP,
       "gyroscope": None}


def of(column: int, text: str) -> Spoil:
    """The same cell in every row of the log."""
    return rows(lambda cells: [*cells[:column], text, *cells[column + 1 :]])


def scaled(factor: float, offset: float = 0.0) -> Spoil:
    """Accelerometer readings times a factor."""
    return rows(lambda cells: [cells[0], *(f"{float(x) * factor + offset:.0f}" for x in cells[1:4]),
                               *cells[4:]])


EDITS = (
    *(Case(f"edited: {'.'.join(map(str, where))} = {str(value)[:20]}", "export RUN --to json",
           3, EDITED, result(*where, value=value)) for where, value in (
        (("accelerometer",), []), (("gyroscope",), "x"), (("title",), 7), (("sensor",), None),
        (("rate",), []), (("rate", "17rpm"), {}), (("installation",), {"rotation": []}),
        ((*GYRO, "model"), []), ((*GYRO, "model"), ["bias", "bias"]), ((*GYRO, "poses"), []),
        ((*GYRO, "parameters"), None), ((*GYRO, "parameters", "bias_counts"), [1, 2]),
        ((*GYRO, "parameters", "bias_counts"), [1, 2, "3"]),
        ((*GYRO, "parameters", "scale_counts_per_unit"), [0, 1, 1]),
        ((*GYRO, "parameters", "scale_counts_per_unit", 0), 1e400),
        ((*GYRO, "parameters", "misalignment_rad", 0), float("nan")),
        ((*GYRO, "sd", "bias_counts", 0), -1.0), ((*GYRO, "correction"), {}),
        ((*GYRO, "correction", "theta"), []), ((*GYRO, "correction", "theta", 0), 10**400),
        ((*GYRO, "correction", "model"), ["magic"]), ((*GYRO, "correction", "shapes"), {"x": "y"}),
        ((*GYRO, "correction", "sheet", "bits"), 99), ((*GYRO, "correction", "sheet", "bits"), 0),
        ((*GYRO, "correction", "sheet", "full_scale"), 0),
        ((*GYRO, "correction", "sheet", "full_scale"), 1.0),
        ((*GYRO, "correction", "sheet", "encoding"), "gray"),
        ((*GYRO, "correction", "own_effects"), {"x": {"expression": "__import__('os')"}}),
        ((*GYRO, "effects"), {"cubic": {"values": [1], "sd": [1], "unit": "x"}}),
        ((*GYRO, "prediction"), 5), ((*GYRO, "frame_to_accelerometer_rad"), [1]),
        (("accelerometer", "gravity"), None), (("accelerometer", "gravity", "value_m_s2"), 0),
        (("accelerometer", "poses", 0, "columns"), []),
        (("accelerometer", "poses", 0, "reading"), [1, 2]),
    )),
    Case("results of another format", "export RUN --to json", 3, "format 2 found",
         result("format", value=2)),
    Case("results cut off", "export RUN --to json", 3, "is not JSON",
         cut("config.run/results.json", 0.7)),
    Case("results of text", "apply RUN LOG", 3, "is not JSON",
         write("config.run/results.json", "x")),
    Case("results nested deeply", "apply RUN LOG", 3, "is not JSON",
         write("config.run/results.json", "[" * 50_000)),
    Case("results that are no text", "apply RUN LOG", 3, "is not JSON",
         write("config.run/results.json", b"\xff\xfe\x00")),
    *(Case(f"history edited: {key} = {value}", "history CONFIG", 3, "is not a line that",
           history({**RUN, key: value})) for key, value in (
        ("when", "yesterday"), ("when", 5), ("config_sha256", None), ("accelerometer", []),
        ("accelerometer", {**STEP, "dof": 0}), ("accelerometer", {**STEP, "chi2": "much"}),
        ("accelerometer", {**STEP, "model": []}), ("accelerometer", {**STEP, "loo_rms": None}),
    )),
    Case("history of text", "history CONFIG", 3, "is not a line that",
         write("config.run/history.jsonl", "x\n")),
    Case("history that is no text", "history CONFIG", 3, "cannot be read",
         write("config.run/history.jsonl", b"\xff\xff")),
)

LIMITS = (
    Case("the sensor's own log", "apply RUN LOG", 0, "saturated"),
    Case("a log already calibrated", "apply RUN LOG", 3, "is valid for 16 bit offset-binary counts",
         rows(lambda c: [c[0], *(f"{(float(x) - 32768) / 550:.6f}" for x in c[1:4]), *c[4:]])),
    Case("counts halved", "apply RUN LOG", 3, "add --anyway", scaled(0.5, 16384)),
    Case("counts doubled about the middle", "apply RUN LOG", 3, "of another", scaled(2, -32768)),
    Case("counts of the other encoding", "apply RUN LOG", 3, "is valid for 16 bit offset-binary",
         scaled(1, -32768)),
    Case("counts of 1e9", "apply RUN LOG", 3, "is valid for 16 bit", of(1, "1000000000")),
    Case("numbers of 1e300", "apply RUN LOG", 3, "is valid for 16 bit", of(1, "1e300")),
    Case("another range, and wanted", "apply RUN LOG --anyway", 0, "axes",
         scaled(0.5, 16384)),
    Case("gravity 5 % off", "apply RUN LOG", 0, "% off gravity", scaled(1.05, -1640)),
    Case("a saturated axis", "apply RUN LOG --anyway", 0, "400 of 400 samples are satura",
         of(1, "65535")),
    Case("saturated rows", "apply RUN LOG", 0, "3 of 400 samples are saturated, the first at",
         lines(lambda all_: [*all_[:4], *(",".join([line.split(",")[0], "65535",
                                                     *line.split(",")[2:]]) for line in all_[4:7]),
                             *all_[7:]])),
    Case("80 degrees", "apply RUN LOG", 0, "temperature_c runs from 80 to 80", of(7, "80")),
    Case("an axis that is stuck", "apply RUN LOG", 0, "gyroscope x is stuck", of(4, "32000")),
    Case("readings with decimals", "apply RUN LOG", 0, "readings with decimals",
         rows(lambda c: [*c[:4], *(f"{float(x) + 0.5}" for x in c[4:7]), c[7]])),
    Case("no gyroscope in the log", "apply RUN LOG", 0, "has no gyroscope",
         lines(lambda all_: [",".join(line.split(",")[:4]) for line in all_])),
    Case("no accelerometer in the log", "apply RUN LOG", 0, "has no accelerometer",
         lines(lambda all_: [",".join([line.split(",")[0], *line.split(",")[4:7]])
                             for line in all_])),
    Case("a column called like the output's", "apply RUN LOG", 0, "of the log is not copied",
         lines(lambda all_: [all_[0].replace("temperature_c", "saturated"), *all_[1:]])),
    *(Case(f"unfit: {command}", f"{command}", 4, "add --anyway",
           result("gyroscope", "prediction", value=None))
      for command in ("apply RUN LOG", "export RUN --to px4", "export RUN --to kalibr")),
    Case("unfit by its error", "export RUN --to px4", 4, "errs by up to",
         result("gyroscope", "prediction", "sd_worst", value=1.0)),
    Case("unfit by a scale factor", "export RUN --to px4", 4, "determine the gyroscope's scale y",
         result("gyroscope", "sd", "scale_counts_per_unit", 1, value=1e5)),
    Case("unfit, and wanted", "export RUN --to px4 --anyway", 0, "warning: the gain",
         result("gyroscope", "prediction", value=None)),
)

HOSTILE = "x\nset motor_pwm_protocol = 1\nsave\x1b[2J */ #error ‮ = <script>alert(1)</script>"
NAMES = (
    *(Case(f"a hostile name in {form}", f"export RUN --to {form}", 0, "RUN|calib|imu|px4|inav",
           both(result("sensor", value=HOSTILE), result("title", value=HOSTILE)))
      for form in ("json", "csv", "imu_tk", "kalibr", "ros", "arduino", "fusion", "px4", "inav")),
    Case("escape sequences in a key", "check CONFIG", 2, r"\\x1b",
         edit("title:", '"a\\e[2J\\a": 1\ntitle:')),
    Case("a text turned around in a key", "check CONFIG", 2, r"\\u202e",
         edit("title:", '"a\\u202eb": 1\ntitle:')),
    Case("escape sequences in a rate's name", "check CONFIG", 0, "at rate 17",
         both(edit("  17rpm:", '  "17\\e[2J":'), edit("rate: 17rpm}", 'rate: "17\\e[2J"}'))),
    Case("a header cell with escape sequences", "check CONFIG", 0, ".",
         lines(lambda all_: [all_[0].replace("temperature_c", "t\x1b[2J"), *all_[1:]])),
    Case("a cell with escape sequences", "apply RUN LOG", 3, r"\\x1b", of(2, "\x1b[2Jx\x07")),
    Case("a formula in a header", "apply RUN LOG", 0, "'=1",
         lines(lambda all_: [all_[0].replace("temperature_c", "=1+A0"), *all_[1:]])),
)
CASES = (*EDITS, *LIMITS, *NAMES)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_results_and_exports(case: Case, copied: Path, capsys: pytest.CaptureFixture[str]) -> None:
    check(case, copied, capsys)
