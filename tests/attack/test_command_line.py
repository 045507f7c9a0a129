"""What is typed: names, numbers, and files that are no files."""

import os
from pathlib import Path

import pytest

from tests.attack.case import Case, Spoil, check, write

LONG = "a" * 300


def pipe(name: str) -> Spoil:
    """A named pipe, which nobody writes to."""
    return lambda config: os.mkfifo(config.parent / name)


def link(name: str, to: str) -> Spoil:
    """A symbolic link in the session's folder."""
    return lambda config: (config.parent / name).symlink_to(to)


CASES = (
    # names
    Case("no command", "calibrate CONFIG", 2, "no command is named 'calibrate'"),
    Case("control characters in a command", "'ru\x1b[2Jn' CONFIG", 2, "no command is named"),
    Case("no file", "run HERE/nothing.yaml", 2, "cannot be read"),
    Case("a folder as configuration", "check HERE/accelerometer", 2, "is a folder without"),
    Case("a long name", f"run {LONG}.yaml", 3, "File name too long"),
    Case("a long --output", f"apply RUN LOG --output HERE/{LONG}", 3, "File name too long"),
    Case("a path of 8000 characters", f"run CONFIG --output HERE/{'b/' * 4000}", 2, "cannot be w"),
    Case("a file as folder", "run CONFIG --output LOG", 2, "LOG|is a file"),
    Case("a file inside a file", "apply RUN LOG --output LOG/x.csv", 2,
         "a folder on the way there is a file"),
    Case("a folder as --output of apply", "apply RUN LOG --output HERE", 2, "is a directory"),
    Case("a folder as log", "apply RUN HERE", 3, "."),
    Case("a link to itself", "run HERE/loop.yaml", 2, "cannot be read",
         link("loop.yaml", "loop.yaml")),
    Case("a link to nothing", "apply RUN HERE/gone.csv", 3, "cannot be read",
         link("gone.csv", "nowhere.csv")),
    Case("a pipe as log", "apply RUN HERE/pipe.csv", 3, "is a pipe or a device", pipe("pipe.csv")),
    Case("a pipe as configuration", "check HERE/pipe.yaml", 2, "pipe", pipe("pipe.yaml")),
    Case("a pipe as clip", "rate HERE/pipe.mp4", 3, "pipe|file", pipe("pipe.mp4")),
    Case("a device as log", "apply RUN /dev/zero", 3, "is a pipe or a device"),
    Case("a device as configuration", "check /dev/zero", 2, "pipe|device"),
    Case("a device as clip", "rate /dev/zero", 3, "pipe|device|file"),
    Case("the results as log", "apply RUN RUN/results.json", 3, "."),
    Case("the configuration as log", "apply RUN CONFIG", 3, "."),
    Case("a log as configuration", "check LOG", 2, "."),
    Case("a log as results", "apply LOG LOG", 3, "is not JSON"),
    Case("a log as clip", "rate LOG", 3, "no video stream"),
    # numbers
    *(Case(f"--{option} {value}", f"{command} --{option}={value}", 2, f"Invalid .* '--{option}'")
      for command, option, values in (
          ("rate LOG", "fps", ("nan", "inf", "1e300", "0", "-1")),
          ("rate LOG", "nominal-rpm", ("nan", "inf", "-5")),
          ("rate --camera 0", "seconds", ("nan", "1e300")),
          ("apply RUN LOG", "rate-hz", ("nan", "0", "1e300")),
          ("import LOG", "rate-hz", ("1e300",)),
          ("noise LOG", "rate-hz", ("1e300",)),
          ("record CONFIG", "camera", ("-1", "x")),
          ("record CONFIG", "baud", ("0", "1e9", "99999999999")),
      ) for value in values),
    # words
    Case("an unknown effect to plan", "plan CONFIG --effect foo", 2, "no effect is named 'foo'"),
    Case("an unknown format", "export RUN --to stl", 2, "no format is named 'stl'"),
    Case("add without a target", "add CONFIG", 2, "name effects to add"),
    Case("add to nothing", "add CONFIG odometer.bias", 2, "names nothing that an effect"),
    Case("add to a triad that is not calibrated", "add CONFIG magnetometer.bias", 2,
         "has no section 'magnetometer'.*calibrates accelerometer.*`pipeline init`"),
    Case("add an unknown effect", "add CONFIG gyroscope.gsens", 2, "no effect is named 'gsens'"),
    Case("add what is there", "add CONFIG gyroscope.bias", 2, "is in the model already"),
    Case("remove what is not there", "remove CONFIG gyroscope.cubic", 2, "is not in the model"),
    Case("columns of another number", "apply RUN LOG --columns time_s,acc_x,acc_y,acc_z", 3,
         "8 values found, 4 expected"),
    Case("empty --columns", "apply RUN LOG --columns ''", 3, "."),
    # output
    Case("apply onto its log", "apply RUN LOG --output LOG", 2, "is what this command reads"),
    Case("apply onto the configuration", "apply RUN LOG --output CONFIG --force", 2,
         "or a file of the session"),
    Case("apply onto another log", "apply RUN LOG --output HERE/accelerometer/pose_02.csv --force",
         2, "or a file of the session"),
    Case("apply onto its log by force", "apply RUN LOG --output LOG --force", 2, "would be repl"),
    Case("apply onto a file", "apply RUN LOG --output HERE/mine.csv", 2, "--force",
         write("mine.csv", "mine")),
    Case("export beside a file", "export RUN --to json --output HERE", 2, "--force",
         write("calibration.json", "mine")),
    Case("run beside a report", "run CONFIG --output HERE", 2, "was not written by",
         write("report.html", "mine")),
    Case("run beside results", "run CONFIG --output HERE", 2, "was not written by",
         write("results.json", "mine")),
    Case("init where a configuration is", "init HERE", 2, "."),
)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_what_is_typed(case: Case, copied: Path, capsys: pytest.CaptureFixture[str]) -> None:
    check(case, copied, capsys)
