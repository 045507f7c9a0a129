"""Source code in C, Python and MATLAB against `apply`, for every effect that samples determine."""

import math
import runpy
import shutil
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from calib.effects.arithmetic import FUNCTIONS
from calib.effects.effect import EFFECTS
from calib.effects.expression import KNOWN_NAMES
from calib.fit.parameters import triad_parameters
from calib.poses.imu_log import ImuLog
from pipeline.errors import UnreadableInput
from pipeline.export.apply import apply_results
from pipeline.export.programs.routine import Routine, routine_of
from pipeline.export.write import EXPORTERS
from pipeline.results.read import Stored, load_results
from tests.pipeline.conftest import RunSession
from tests.pipeline.export.compiled import program_of, through
from tests.pipeline.export.stored_results import a_log, with_effects

TRIADS = ("accelerometer", "gyroscope")
#: Parameters whose errors are far above a float's rounding at the readings of the log.
SIZE = {"accelerometer": {
    "quadratic": 0.003, "cubic": 3e-5, "asymmetry": 0.02, "cross_quadratic": 0.002,
    "temperature_bias": 0.05, "temperature_scale": 0.001, "bias_drift": 50.0, "scale_drift": 2.0,
    "warm_up": 0.3, "frame_rotation": 0.02, "bias_step": 0.2,
    "temperature_bias_curve": 0.01, "temperature_scale_curve": 0.001,
}, "gyroscope": {
    "quadratic": 0.03, "cubic": 0.03, "asymmetry": 0.02, "cross_quadratic": 0.02,
    "temperature_bias": 0.01, "temperature_scale": 0.001, "bias_drift": 50.0, "scale_drift": 2.0,
    "bias_step": 0.05, "temperature_bias_curve": 0.003, "temperature_scale_curve": 0.001,
    "warm_up": 0.3, "frame_rotation": 0.02, "g_sensitivity": 0.003, "g_squared_sensitivity": 0.001,
}}
CASES = [(triad, name) for triad in TRIADS for name, effect in EFFECTS.items()
         if triad in effect.triads and effect.acts_on == "sensor"
         and effect.told_by in ("sample", "clock")]
Corrected = Callable[[Stored, Path, str, np.ndarray, Mapping[str, np.ndarray]], np.ndarray]


def routine(stored: Stored, triad: str) -> Routine:
    (own,) = (each for each in stored.triads if each.name == triad)
    return routine_of(own)


def columns_for(each: Routine, given: Mapping[str, np.ndarray]) -> np.ndarray:
    """The arguments of a program, a row for each sample."""
    parts = [given["counts"]] + ([given["force"]] if each.needs_force else [])
    return np.column_stack([*parts, *(given[one.column] for one in each.inputs)])


def in_c(stored: Stored, folder: Path, triad: str, given: Any) -> np.ndarray:
    each = routine(stored, triad)
    counts = 3 + 3 * each.needs_force
    arguments = ["in", *(["in + 3"] if each.needs_force else []),
                 *(f"in[{counts + i}]" for i in range(len(each.inputs)))]
    call = f"calibrate_{triad}({', '.join(arguments)}, out);"
    text = EXPORTERS["arduino"](stored).files["imu_calibration.h"]
    program = program_of(folder, "imu_calibration.h", text, call, counts + len(each.inputs))
    return through(program, columns_for(each, given))


def in_python(stored: Stored, folder: Path, triad: str, given: Any) -> np.ndarray:
    each = routine(stored, triad)
    path = folder / "imu_calibration.py"
    path.write_text(EXPORTERS["python"](stored).files[path.name], encoding="utf-8")
    correct = runpy.run_path(str(path))[f"calibrate_{triad}"]
    rows = []
    for i, counts in enumerate(given["counts"]):
        force = [given["force"][i].tolist()] if each.needs_force else []
        rows.append(correct(counts.tolist(), *force, *(given[one.column][i].item()
                                                       for one in each.inputs)))
    return np.array(rows)


def in_matlab(stored: Stored, folder: Path, triad: str, given: Any) -> np.ndarray:
    each = routine(stored, triad)
    for name, text in EXPORTERS["matlab"](stored).files.items():
        (folder / name).write_text(text, encoding="utf-8")
    np.savetxt(folder / "in.txt", columns_for(each, given), fmt="%.17g")
    counts = 3 + 3 * each.needs_force
    arguments = ["t(:, 1:3)", *(["t(:, 4:6)"] if each.needs_force else []),
                 *(f"t(:, {counts + i + 1})" for i in range(len(each.inputs)))]
    script = (f"t = load('in.txt'); s = calibrate_{triad}({', '.join(arguments)}); "
              "dlmwrite('out.txt', s, 'precision', '%.17g', 'delimiter', ' ');")
    subprocess.run(["octave-cli", "--no-init-file", "--eval", script], cwd=folder, check=True,
                   capture_output=True)
    return np.loadtxt(folder / "out.txt")


LANGUAGES = [
    pytest.param(in_c, 2e-5, id="c", marks=pytest.mark.skipif(
        shutil.which("gcc") is None, reason="there is no C compiler")),
    pytest.param(in_python, 1e-12, id="python"),
    pytest.param(in_matlab, 1e-12, id="matlab", marks=pytest.mark.skipif(
        shutil.which("octave-cli") is None, reason="there is no Octave")),
]


def a_drive(stored: Stored, triad: str, **more: np.ndarray) -> tuple[np.ndarray, dict[str, Any]]:
    """A log corrected by `apply`, and what a program takes for it."""
    warmth = np.linspace(15.0, 45.0, 500)
    log = a_log(temperature_c=warmth, **more)
    expected = apply_results(stored, log, session_clock=True).triads
    start = (stored.contents.session_start_s or 0.0)
    other = next(each for each in stored.triads if each.name != triad)
    nominal = other.correction.spec.nominal(getattr(log, other.name))
    return expected[triad], {
        "counts": getattr(log, triad), "force": expected["accelerometer"], "time_s":
        log.time_s - start, "temperature_c": warmth, "other_x": nominal[:, 0],
        "other_y": nominal[:, 1], "other_z": nominal[:, 2], **more}


def sizes(name: str, triad: str = "gyroscope") -> list[float]:
    """Unequal parameters of the effect."""
    count = len(EFFECTS[name].parameters)
    return [SIZE[triad][name] * (1 - 0.15 * i) * (-1) ** i for i in range(count)]


@pytest.mark.parametrize(("triad", "name"), CASES)
def test_every_effect_of_the_sensor_is_corrected_as_apply_does(
    finished: RunSession, tmp_path: Path, triad: str, name: str
) -> None:
    """In one language; the others write the same terms, which the next test compiles."""
    correct, tolerance = in_python, 1e-12
    stored = with_effects(finished, tmp_path, triad, {name: sizes(name, triad)})
    expected, given = a_drive(stored, triad)
    plain = apply_results(with_effects(finished, tmp_path, triad, {}), a_log()).triads[triad]
    assert np.abs(plain - expected).max() > 100 * tolerance  # the effect is there
    largest = np.abs(expected).max()
    assert correct(stored, tmp_path, triad, given) == pytest.approx(
        expected, abs=tolerance * largest)


@pytest.mark.parametrize(("correct", "tolerance"), LANGUAGES)
def test_all_at_once_with_columns_and_the_user_s_own(
    finished: RunSession, tmp_path: Path, correct: Corrected, tolerance: float
) -> None:
    own = {"pulling": {"expression": "tanh(s / 3) * exp(-time_s / tau) + sqrt(abs(fan_rpm)) ** 2 "
                       "/ 900 - sign(fx) * cos(other_y) * pi", "per": "axis", "unit": "1",
                       "shapes": {"tau": ["s", 1.0, 1000.0]}},
           "shared": {"expression": "log(2 + temperature_c) * f ** 2", "per": "matrix",
                      "unit": "1"}}
    effects = {"g_sensitivity": sizes("g_sensitivity"), "quadratic": sizes("quadratic"),
               "temperature_bias": sizes("temperature_bias"), "column:fan_rpm": [1e-4, 2e-4, -1e-4],
               "column:supply-2": [0.02, -0.03, 0.01], "column:fx": [-0.01, 0.02, 0.03],
               "frame_rotation": sizes("frame_rotation"),
               "pulling": [0.01, -0.02, 0.03], "shared": [1e-4 * i for i in range(9)]}
    stored = with_effects(finished, tmp_path, "gyroscope", effects, own, shapes={"pulling": 40.0})
    columns = {"fan_rpm": np.linspace(0, 900, 500), "supply-2": np.cos(np.arange(500)),
               "fx": np.sin(np.arange(500))}
    expected, given = a_drive(stored, "gyroscope", **columns)
    assert correct(stored, tmp_path, "gyroscope", given) == pytest.approx(
        expected, abs=5 * tolerance * np.abs(expected).max())


@settings(max_examples=25, deadline=None)
@given(name=st.one_of(st.sampled_from([*KNOWN_NAMES, *FUNCTIONS, "battery-V", "T(1)", "a/b", "u",
                                       "x + 1", "column:x", "lambda", "math", "1e9", "ß"]),
                      st.text(min_size=1, max_size=20)))
@example(name="column:x")
def test_a_column_of_any_name_is_exported_as_it_is_applied(
    finished: RunSession, tmp_path_factory: pytest.TempPathFactory, name: str
) -> None:
    folder = tmp_path_factory.mktemp("named")
    try:
        stored = with_effects(finished, folder, "gyroscope",
                              {f"column:{name}": [0.02, -0.03, 0.01]})
    except UnreadableInput:
        assume(False)
    values = np.cos(np.arange(5))
    log = a_log()
    log = ImuLog("drive.csv", log.time_s[:5], log.accelerometer[:5], log.gyroscope[:5],
                 {name: values})
    expected = apply_results(stored, log, session_clock=True).triads["gyroscope"]
    drive = {"counts": log.gyroscope, name: values}
    assert np.ptp(expected - stored.triads[1].correction.spec.nominal(log.gyroscope), axis=0).all()
    assert in_python(stored, folder, "gyroscope", drive) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("form", ["arduino", "python", "matlab"])
def test_what_whole_poses_alone_determine_is_named_with_its_reason(
    finished: RunSession, tmp_path: Path, form: str
) -> None:
    stored = with_effects(finished, tmp_path, "accelerometer", {"hysteresis": [0.1, 0.2, 0.3]})
    (note,) = (each for each in EXPORTERS[form](stored).loses if "hysteresis" in each)
    assert "no sample of a log tells hysteresis" in note
    assert "pipeline apply" not in note


def test_the_arguments_and_the_clock_are_said(finished: RunSession, tmp_path: Path) -> None:
    stored = with_effects(finished, tmp_path, "gyroscope",
                          {"warm_up": [0.1] * 3, "g_sensitivity": [1e-4] * 9})
    loses = " ".join(EXPORTERS["arduino"](stored).loses)
    assert "warm_up of the gyroscope holds on the clock of the calibration session" in loses
    assert "calibrate_gyroscope also takes force" in loses
    assert "cannot store" not in loses


def unsigned(stored: Stored) -> Stored:
    """The same parameters for a converter whose negative counts are logged as large ones."""
    triads = []
    for each in stored.triads:
        spec = replace(each.correction.spec, encoding="unsigned-twos-complement")
        model, theta = each.correction.model, each.correction.theta
        nine = triad_parameters(model, theta, np.zeros((len(theta),) * 2), spec)
        triads.append(replace(
            each, correction=replace(each.correction, spec=spec), parameters=nine))
    return replace(stored, triads=tuple(triads))


@pytest.mark.parametrize(("correct", "tolerance"), LANGUAGES)
def test_counts_logged_without_a_sign_are_those_of_the_converter(
    finished: RunSession, tmp_path: Path, correct: Corrected, tolerance: float
) -> None:
    stored = unsigned(load_results(finished.folder))
    expected, given = a_drive(stored, "gyroscope")
    assert (given["counts"] >= 32768).any()
    assert correct(stored, tmp_path, "gyroscope", given) == pytest.approx(
        expected, abs=tolerance * np.abs(expected).max())


def test_the_worked_number_holds_with_its_conditions(finished: RunSession, tmp_path: Path) -> None:
    stored = with_effects(finished, tmp_path, "gyroscope", {
        "temperature_bias": [0.01, 0.02, 0.03], "g_sensitivity": sizes("g_sensitivity")})
    text = EXPORTERS["python"](stored).files["imu_calibration.py"]
    (line,) = (each for each in text.splitlines() if "(rad/s)" not in each and "example" in each
               and "temperature_c" in each)
    counts, si, force = ([float(v) for v in part.split(")")[0].split(",")]
                         for part in line.split("(")[1:])
    given = {"counts": np.array([counts]), "force": np.array([force]),
             "temperature_c": np.array([30.0])}
    assert in_python(stored, tmp_path, "gyroscope", given)[0] == pytest.approx(si, rel=1e-6)
    assert math.isfinite(sum(si))
