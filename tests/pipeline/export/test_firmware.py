"""C headers compiled and run, flight controllers' parameters read back: a log corrected by each."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline.export.apply import apply_results
from pipeline.export.firmware import temperature_courses
from pipeline.export.parts import Export, triad_named
from pipeline.export.write import EXPORTERS
from pipeline.results.read import Stored, StoredTriad, load_results
from tests.pipeline.conftest import RunSession
from tests.pipeline.export.compiled import GCC, program_of, through
from tests.pipeline.export.stored_results import a_log, with_effects

needs_gcc = pytest.mark.skipif(GCC is None, reason="no gcc here to compile the header with")

#: What x-io's FusionMath.h and FusionModel.h state, as far as the header is concerned.
FUSION = """
typedef union { float array[3]; struct { float x, y, z; } axis; } FusionVector;
typedef union { float array[9]; struct { float xx, xy, xz, yx, yy, yz, zx, zy, zz; } element; }
    FusionMatrix;
static FusionVector model(FusionVector u, FusionMatrix m, FusionVector k, FusionVector b)
{
    FusionVector v, r;
    for (int i = 0; i < 3; i++) v.array[i] = (u.array[i] - b.array[i]) * k.array[i];
    for (int i = 0; i < 3; i++) {
        r.array[i] = 0;
        for (int j = 0; j < 3; j++) r.array[i] += m.array[3 * i + j] * v.array[j];
    }
    return r;
}
"""
CALLS = {
    "arduino": ("imu_calibration.h", "", "calibrate_{0}(in, out);"),
    "fusion": ("fusion_calibration.h", FUSION,
               "FusionVector u = {{.axis = {{in[0], in[1], in[2]}}}}; FusionVector r = model(u, "
               "{0}Misalignment, {0}Sensitivity, {0}Offset);"
               "for (int i = 0; i < 3; i++) out[i] = r.array[i];"),
}  # fmt: skip
PER_SI = {
    ("fusion", "accelerometer"): 1 / 9.80665, ("fusion", "gyroscope"): math.degrees(1.0),
}  # fmt: skip


def compiled(folder: Path, form: str, made: Export, triad: str) -> Path:
    """A program that reads three numbers a line and prints them corrected by the header."""
    name, stub, call = CALLS[form]
    return program_of(folder, name, made.files[name], call.format(triad), stub=stub)


@needs_gcc
@pytest.mark.parametrize("form", ["arduino", "fusion"])
@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_a_header_compiles_and_corrects_a_log_and_its_own_worked_number(
    finished: RunSession, tmp_path: Path, form: str, triad: str
) -> None:
    stored, log = load_results(finished.folder), a_log()
    made = EXPORTERS[form](stored)
    program = compiled(tmp_path, form, made, triad)
    per_si = PER_SI.get((form, triad), 1.0)
    expected = apply_results(stored, log).triads[triad] * per_si
    # Counts less bias in single precision: half a hundredth of a count at 2^16.
    counts = getattr(log, triad)
    assert through(program, counts) == pytest.approx(expected, rel=1e-5, abs=1e-4)
    (text,) = made.files.values()
    worked = re.search(rf"{triad}: counts \((.*?)\) are \((.*?)\)", text)
    assert worked
    given, shown = ([float(v) for v in part.split(",")] for part in worked.groups())
    assert through(program, np.array([given]))[0] == pytest.approx(shown, rel=1e-5, abs=1e-5)


def test_a_title_cannot_end_the_header_s_comment(finished: RunSession, tmp_path: Path) -> None:
    stored = with_effects(finished, tmp_path, "gyroscope", {})
    contents = stored.contents.model_copy(update={"title": "a */ int x;\n#error"})
    odd = replace(stored, contents=contents)
    (text,) = EXPORTERS["arduino"](odd).files.values()
    first = text.splitlines()[0]
    assert first.count("*/") == 1
    assert first.endswith("*/")


# --- flight controllers ------------------------------------------------------------------------


def without_misalignment(each: StoredTriad, counts: np.ndarray, gains: np.ndarray) -> np.ndarray:
    return (counts - each.parameters.bias_counts) * each.correction.spec.nominal_scale * gains


def own(stored: Stored, triad: str) -> StoredTriad:
    found = triad_named(stored, triad)
    assert found is not None
    return found


def stated_share(made: Export, triad: str) -> float:
    """The relative error that the export says it leaves."""
    says = next(each for each in made.loses if f"of the {triad}: an error of up to" in each)
    found = re.search(r"up to ([\d.e-]+) %", says)
    assert found
    return float(found[1]) / 100


def test_px4_reads_back_up_to_what_it_says_it_loses(finished: RunSession) -> None:
    """(reading - offset) * scale in the axes of the sensor, the rotation into the body after it.

    Source: PX4/PX4-Autopilot, ``src/lib/sensor_calibration/Accelerometer.hpp`` and
    ``Gyroscope.hpp``, ``Correct``.
    """
    stored, log = load_results(finished.folder), a_log()
    made = EXPORTERS["px4"](stored)
    rows = [line.split("\t") for line in made.files["px4.params"].splitlines()
            if not line.startswith("#")]
    assert all(row[:2] == ["1", "1"] and row[4] == "9" for row in rows)
    value = {row[2]: float(row[3]) for row in rows}
    assert set(value) == {f"CAL_ACC0_{axis}{kind}" for axis in "XYZ" for kind in ("OFF", "SCALE")
                          } | {f"CAL_GYRO0_{axis}OFF" for axis in "XYZ"}
    scale = np.array([value[f"CAL_ACC0_{axis}SCALE"] for axis in "XYZ"])
    for triad, name, gains in (("accelerometer", "CAL_ACC0", scale),
                               ("gyroscope", "CAL_GYRO0", np.ones(3))):
        each, counts = own(stored, triad), getattr(log, triad)
        off = np.array([value[f"{name}_{axis}OFF"] for axis in "XYZ"])
        by_export = (each.correction.spec.nominal(counts) - off) * gains
        assert by_export == pytest.approx(without_misalignment(each, counts, gains), abs=1e-8)
        left = np.linalg.norm(by_export - apply_results(stored, log).triads[triad], axis=1)
        reading = np.linalg.norm(by_export, axis=1)
        assert 0 < (left / reading).max() < 1.05 * stated_share(made, triad)  # two digits stated


@pytest.mark.parametrize(("triad", "letter", "cal"), [
    ("accelerometer", "A", "CAL_ACC0"), ("gyroscope", "G", "CAL_GYRO0"),
])
def test_px4_has_a_curve_in_the_temperature_as_its_cubic(
    finished: RunSession, tmp_path: Path, triad: str, letter: str, cal: str
) -> None:
    """What PX4 subtracts: a cubic in T - TREF, T held within TMIN and TMAX, and the offset.

    Source: PX4/PX4-Autopilot, ``src/modules/temperature_compensation``,
    ``calc_thermal_offsets_3D``.
    """
    curve = np.array([0.02, 0.01, -0.03, -0.03, 0.02, 0.01, 0.01, -0.02, 0.02])
    stored = with_effects(finished, tmp_path, triad, {"temperature_bias_curve": list(curve)},
                          shapes={"temperature_bias_curve": 27.0})
    made = EXPORTERS["px4"](stored)
    assert not any("temperature_bias_curve" in note for note in made.loses)
    rows = [line.split("\t") for line in made.files["px4.params"].splitlines() if line[0] != "#"]
    value = {row[2]: float(row[3]) for row in rows}
    assert [f"TC_{letter}_ENABLE", "1", "6"] in [row[2:] for row in rows]
    low, high, centre = (value[f"TC_{letter}0_{key}"] for key in ("TMIN", "TMAX", "TREF"))
    warmth = np.linspace(low, high, 200)
    off = np.array([value[f"{cal}_{axis}OFF"] for axis in "XYZ"])
    thermal = sum(np.array([value[f"TC_{letter}0_X{k}_{axis}"] for axis in range(3)])
                  * (warmth[:, None] - centre) ** k for k in range(4))
    own_one = own(stored, triad)
    gain = own_one.units_per_count / own_one.correction.spec.nominal_scale
    zero = own_one.correction.spec.nominal(own_one.parameters.bias_counts)
    d = (warmth - 27.0)[:, None]
    first, second, third = curve.reshape(3, 3).T
    error = d * first + d**2 / 10 * second + d**3 / 100 * third
    assert thermal + off == pytest.approx(zero + error / gain, abs=1e-6)


def test_inav_reads_back_up_to_its_whole_counts(finished: RunSession) -> None:
    stored, log = load_results(finished.folder), a_log()
    made = EXPORTERS["inav"](stored)
    value = {name: float(number) for name, number in re.findall(
        r"^set (\w+) = ([-\d.]+)$", made.files["inav.txt"], re.MULTILINE)}
    gravity = stored.gravity_m_s2
    assert value["ins_gravity_cmss"] == pytest.approx(100 * gravity, abs=1e-3)
    gains = np.array([value[f"accgain_{axis}"] for axis in "xyz"]) / 4096
    each = own(stored, "accelerometer")
    assert gains == pytest.approx(each.units_per_count / each.correction.spec.nominal_scale,
                                  abs=0.5 / 4096 + 1e-9)
    ranges = {"accelerometer": ("acczero", 16 * 9.80665 / 32768, gains),
              "gyroscope": ("gyro_zero", math.radians(2000) / 32768, np.ones(3))}
    for triad, (name, per_count, gain) in ranges.items():
        counts = getattr(log, triad)
        zero = np.array([value[f"{name}_{axis}"] for axis in "xyz"])
        nominal = own(stored, triad).correction.spec.nominal(counts)
        by_export = (nominal / per_count - zero) * gain * per_count
        expected = without_misalignment(own(stored, triad), counts, gain)
        assert by_export == pytest.approx(expected, abs=0.51 * per_count * gain.max())


@pytest.mark.parametrize("form", ["fusion", "px4", "inav", "ardupilot"])
def test_an_effect_that_has_no_place_is_named(
    finished: RunSession, tmp_path: Path, form: str
) -> None:
    stored = with_effects(finished, tmp_path, "gyroscope", {"quadratic": [0.1, 0.2, 0.3]})
    assert any("quadratic of the gyroscope" in says for says in EXPORTERS[form](stored).loses)


@pytest.mark.parametrize("program", ["px4", "ardupilot"])
def test_whatever_is_a_cubic_in_the_temperature_is_held(
    finished: RunSession, tmp_path: Path, program: str
) -> None:
    """A square that was discovered and a column are cubics, a root and a gain are not."""
    own_ones = {name: {"expression": text, "python": None, "per": "axis", "unit": "?", "shapes": {}}
                for name, text in (("heat", "(temperature_c - 31)**2 / 4 + 2"),
                                   ("root", "sqrt(temperature_c)"),
                                   ("gain", "s * (temperature_c - 25)"))}
    sizes = {"heat": [0.02, -0.01, 0.03], "column:temperature_c": [0.01, 0.0, 0.02],
             "root": [1e-3] * 3, "gain": [1e-3] * 3}
    stored = with_effects(finished, tmp_path, "gyroscope", sizes, own=own_ones)
    made = EXPORTERS[program](stored)
    (note,) = (each for each in made.loses if "root" in each)
    assert "gain" in note
    assert "heat" not in note
    assert "temperature_c" not in note
    warmth = np.linspace(20.0, 40.0, 7)
    of_column, of_heat = sizes["column:temperature_c"], sizes["heat"]
    gain = own(stored, "gyroscope").units_per_count / own(
        stored, "gyroscope").correction.spec.nominal_scale
    for axis, course in enumerate(temperature_courses(own(stored, "gyroscope"))):
        error = of_heat[axis] * ((warmth - 31) ** 2 / 4 + 2) + of_column[axis] * warmth
        assert course(warmth) == pytest.approx(error / gain[axis])
