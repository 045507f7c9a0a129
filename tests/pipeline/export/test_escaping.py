"""Names out of files are data in every export: read back, they change nothing."""

import csv
import json
import re
import shutil
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from calib.poses.imu_log import ImuLog
from pipeline.export.apply import applied_csv, apply_results
from pipeline.export.write import EXPORTERS
from pipeline.results.read import Stored, load_results
from pipeline.text.plain import HIDDEN
from tests.pipeline.conftest import RunSession
from tests.pipeline.export.stored_results import a_log

HOSTILE = (
    "x\nset motor_pwm_protocol = 1\nsave", "x\r\n1\t1\tCAL_ACC0_XOFF\t99\t9", "*/ int x; /*",
    "a */",
    "/*/ #error", "*\\\n/ #error", "??/\n#error", "x\nimu0: {rostopic: /owned}", "a: &b [*b]",
    "\x1b]0;owned\x07\x1b[2J", "‮gnp.exe", "a\u2028set a = 1", "a\x85save", "=1+1|cmd", "'; DROP",
    '"quoted", and, commas', "%n%s", "-1+1", "@SUM(A1)", "\ttab", "m/s²\x00", "---\n- x", "# x",
    "{{7*7}}", "<script>alert(1)</script>", "日本語 ±°", "\\", "${HOME}`id`", "x" * 3000,
)
SIGNS = "*/\\?\n\r#=:{}[]&!|>'\"%@`,-+ \t\x1b\x85\u2028setav1"
TEXTS = st.one_of(st.sampled_from(HOSTILE), st.text(max_size=40),
                  st.text(alphabet=SIGNS, max_size=25))


def renamed(stored: Stored, name: str, title: str) -> Stored:
    """The results of a sensor and session with these names."""
    contents = stored.contents.model_copy(update={"sensor": name, "title": title})
    return replace(stored, contents=contents)


def without_names(text: str, comment: str) -> list[str]:
    """The lines that are no comments."""
    return [line for line in text.split("\n") if not line.startswith(comment)]


def text_of(stored: Stored, form: str) -> str:
    return next(iter(EXPORTERS[form](stored).files.values()))


@cache
def plain(folder: Path) -> Stored:
    """The results as they are, read once."""
    return load_results(folder)


@cache
def read_plainly(folder: Path, form: str) -> Any:
    """What YAML makes of them."""
    return yaml.safe_load(text_of(plain(folder), form))


@settings(max_examples=15, deadline=None)
@given(name=TEXTS, title=TEXTS)
def test_lines_of_parameters_and_commands_are_those_without_names(
    finished: RunSession, name: str, title: str
) -> None:
    stored = plain(finished.folder)
    hostile = renamed(stored, name, title)
    for form in ("px4", "inav"):
        text = text_of(hostile, form)
        assert text.isascii()
        assert set(HIDDEN.findall(text)) <= {"\n", "\t"}
        assert without_names(text, "#") == without_names(text_of(stored, form), "#")


@settings(max_examples=15, deadline=None)
@given(name=TEXTS, title=TEXTS)
def test_yaml_reads_back_as_without_names(finished: RunSession, name: str, title: str) -> None:
    hostile = renamed(plain(finished.folder), name, title)
    for form in ("kalibr", "ros"):
        text = text_of(hostile, form)
        assert yaml.safe_load(text) == read_plainly(finished.folder, form)
        assert not HIDDEN.search(text.replace("\n", ""))


def test_small_numbers_are_numbers_in_yaml(finished: RunSession) -> None:
    read = yaml.safe_load(text_of(load_results(finished.folder), "ros"))
    assert all(isinstance(value, float) for value in [*read["SM"], *read["bias"]])


@settings(max_examples=15, deadline=None)
@given(name=TEXTS, title=TEXTS)
def test_json_keeps_every_name(finished: RunSession, name: str, title: str) -> None:
    hostile = renamed(load_results(finished.folder), name, title)
    assert json.loads(text_of(hostile, "json"))["title"] == title


@settings(max_examples=15, deadline=None)
@given(name=TEXTS, title=TEXTS)
def test_a_c_comment_ends_where_ours_ends(finished: RunSession, name: str, title: str) -> None:
    """Comments taken out as a compiler does: after trigraphs and spliced lines."""
    stored = load_results(finished.folder)
    for form in ("arduino", "fusion"):
        code = [re.sub(r"/\*.*?\*/", "", text_of(each, form).replace("??/", "\\")
                       .replace("\\\n", ""), flags=re.DOTALL)
                for each in (stored, renamed(stored, name, title))]
        assert code[0] == code[1]


@pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no C compiler")
def test_the_header_compiles_without_a_warning_whatever_the_names(
    finished: RunSession, tmp_path: Path
) -> None:
    stored = load_results(finished.folder)
    for i, name in enumerate(HOSTILE):
        (tmp_path / f"{i}.h").write_text(text_of(renamed(stored, name, name), "arduino"))
    names = ("calibrate_accelerometer", "calibrate_gyroscope", "ACC_B", "ACC_K",
             "ACC_T", "GYR_B", "GYR_K", "GYR_T")
    lines = []
    for i in range(len(HOSTILE)):  # each header anew, its names numbered
        lines += [f"#define {name} {name}{i}" for name in names]
        lines += ["#undef IMU_CALIBRATION_H", f'#include "{i}.h"']
        lines += [f"#undef {name}" for name in names]
    (tmp_path / "all.c").write_text("\n".join(lines) + "\n")
    done = subprocess.run(["gcc", "-std=c99", "-Wall", "-Wextra", "-Wno-unused", "-Werror",
                           "-trigraphs", "-fsyntax-only", "all.c"], cwd=tmp_path, check=False,
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@settings(max_examples=15, deadline=None)
@given(name=st.one_of(st.sampled_from(HOSTILE), st.text(min_size=1, max_size=20)))
def test_a_column_of_any_name_stays_one_column_and_no_formula(
    finished: RunSession, name: str
) -> None:
    log = a_log()
    log = ImuLog(log.label, log.time_s, log.accelerometer, log.gyroscope,
                 {name: np.arange(500.0)})
    text = applied_csv(apply_results(load_results(finished.folder), log)).decode()
    rows = list(csv.reader(text.splitlines()))
    assert {len(row) for row in rows} == {len(rows[0])}
    assert not rows[0][-1].startswith(("=", "+", "-", "@", "\t", "\r"))
