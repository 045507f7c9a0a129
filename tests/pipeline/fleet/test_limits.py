"""Pass and fail by a file of limits, with a guard band; and the board of effects."""

import tracemalloc
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pipeline.errors import ConfigError
from pipeline.fleet.board import MISSING, MODELLED, board_of
from pipeline.fleet.limits import limit_lines, read_limits, with_limits
from pipeline.fleet.table import FITS, MISFIT

TRUE_BIAS, SD = 300.0, 4.0


def table(bias: np.ndarray, **columns: object) -> pd.DataFrame:
    names = [f"s{i}" for i in range(len(bias))]
    still = {f"bias_counts_{axis}{end}": value for axis in "yz"
             for end, value in (("", 0.0), ("_sd", SD))}
    return pd.DataFrame({
        "session": names, "sensor": names, "triad": "gyroscope", "exit_code": 0,
        "verdict": "nothing_missing", "missing": "", "model": "bias + scale + misalignment",
        "bias_counts_x": bias, "bias_counts_x_sd": SD, **still, **columns})


def limits_in(folder: Path, text: str) -> Path:
    path = folder / "limits.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_of_sensors_at_a_limit_the_stated_share_passes_wrongly(tmp_path: Path) -> None:
    measured = TRUE_BIAS + np.random.default_rng(5).normal(0, SD, 4000)
    path = limits_in(tmp_path, "wrong: 0.05\ngyroscope:\n  bias_counts: {max: 300}\n")
    judged = with_limits(table(measured), read_limits(path))["limits"]
    assert (judged == "pass").mean() == pytest.approx(0.05, abs=0.012)
    assert judged.str.startswith("fail").mean() == pytest.approx(0.05, abs=0.012)


def test_what_is_beyond_a_limit_is_told_with_its_value_and_its_sd(tmp_path: Path) -> None:
    path = limits_in(tmp_path, "gyroscope:\n  bias_counts: {min: -300, max: 300}\n"
                               "  size_g_sensitivity: {max: 2e-4}\n")
    rows = table(np.array([10.0, -340.0, 297.0, 0.0]),
                 size_g_sensitivity=[np.nan, np.nan, 1e-4, -3e-4],
                 size_sd_g_sensitivity=[np.nan, np.nan, 1e-6, 1e-6])
    rows.loc[4] = {**rows.loc[0].to_dict(), "session": "s4", "exit_code": 3}
    judged = with_limits(rows, read_limits(path))
    assert list(judged["limits"]) == [
        "pass", "fail: bias_counts_x -340.0 ± 4.0 is below -300",
        "undecided: bias_counts_x 297.0 ± 4.0 is within its uncertainty of 300",
        "fail: size_g_sensitivity 0.0003000 ± 0.0000010 is above 0.0002", "fail: not calibrated"]
    assert next(limit_lines(judged)) == "limits: 1 pass, 1 undecided, 3 fail"


def test_a_session_without_a_triad_that_has_a_limit_fails(tmp_path: Path) -> None:
    """A gyroscope that import left out has no row that could fail."""
    path = limits_in(tmp_path, "accelerometer:\n  bias_counts: {max: 300}\n"
                               "gyroscope:\n  bias_counts: {max: 300}\n")
    rows = table(np.zeros(2), triad="accelerometer")
    rows.loc[2] = {**rows.loc[0].to_dict(), "triad": "gyroscope"}
    assert list(with_limits(rows, read_limits(path))["limits"]) == [
        "pass", "fail: the gyroscope is not calibrated", "pass"]


@pytest.mark.parametrize(("verdict", "group", "standing"), [
    ("nothing_missing", "", "pass"), ("noise", "extra_noise", "pass"),
    ("effect", "cubic quadratic", "pass"), ("effect", "quadratic asymmetry", "undecided"),
    ("ambiguous", "cubic asymmetry", "undecided"), ("unknown", "a shape", "undecided"),
    (MISFIT, None, "undecided"), (FITS, None, "pass"),
])
def test_an_effect_of_unknown_size_passes_where_the_verdict_excludes_it(
    tmp_path: Path, verdict: str, group: str | None, standing: str
) -> None:
    path = limits_in(tmp_path, "gyroscope:\n  size_asymmetry: {max: 2e-4}\n")
    rows = table(np.zeros(1)).assign(verdict=verdict)
    judged = with_limits(rows if group is None else rows.assign(group=group), read_limits(path))
    assert judged["limits"][0].startswith(standing)


@pytest.mark.parametrize(("text", "says"), [
    ("gyroscope:\n  size_cubik: {max: 3}\n", r"gyroscope.size_cubik: .*'cubic'"),
    ("gyroscop:\n  bias_counts: {max: 3}\n", r"limits.yaml:1: gyroscop: .*'gyroscope'"),
    ("gyroscope:\n  bias_count: {max: 3}\n", r"gyroscope.bias_count: .*'bias_counts"),
    ("gyroscope:\n  bias_counts: {most: 3}\n", r"limits.yaml:2: .*\{min: \.\.\., max"),
    ("gyroscope:\n  bias_counts: {max: many}\n", r"limits.yaml:2: .*a number is expected"),
    ("gyroscope:\n  bias_counts: {min: 4, max: 3}\n", "min 4 is not below max 3"),
    ("wrong: 2\n", "a share between 0 and 0.5"),
    ("{}\n", "states no limit"),
])
def test_a_wrong_limit_is_refused_with_its_place(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(ConfigError, match=f"(?s){says}"):
        with_limits(table(np.zeros(2)), read_limits(limits_in(tmp_path, text)))


def test_the_board_shows_each_effect_in_its_unit_the_worst_sensor_first() -> None:
    rows = table(np.zeros(3), size_g_sensitivity=[np.nan, 3.38e-4, 1e-5],
                 size_sd_g_sensitivity=[np.nan, 1e-6, 1e-6])
    rows["missing"] = ["", "g_sensitivity", ""]
    rows["model"] = ["bias", "bias", "bias + g_sensitivity"]
    board = board_of(rows, "gyroscope", 10)
    assert board.effects == (("g_sensitivity", "°/s per g"),)
    assert [row.session for row, _ in board.rows] == ["s1", "s0", "s2"]
    cells = {row.session: cells[0] for row, cells in board.rows}
    assert (cells["s1"].state, cells["s1"].text) == (MISSING, "0.18992 ± 0.00056")
    assert (cells["s2"].state, cells["s2"].level) == (MODELLED, 2)
    assert cells["s0"].text == ""


def test_the_board_of_a_large_lot_holds_the_rows_that_it_shows() -> None:
    n = 5_000
    rows = table(np.zeros(n), missing="g_sensitivity", size_g_sensitivity=np.linspace(1, 2, n),
                 size_sd_g_sensitivity=1e-3)
    tracemalloc.start()
    board = board_of(rows, "gyroscope", 10)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert [row.session for row, _ in board.rows] == [f"s{n - 1 - i}" for i in range(10)]
    assert peak / n < 150  # bytes a row: some numbers; a row of texts takes a thousand
