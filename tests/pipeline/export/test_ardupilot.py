"""ArduPilot's parameters, read by its ground tools and put through the formula of its driver."""

import re
from pathlib import Path

import numpy as np
import pytest

from pipeline.export.apply import apply_results
from pipeline.export.parts import triad_named
from pipeline.export.write import EXPORTERS
from pipeline.results.read import Stored, load_results
from tests.pipeline.conftest import RunSession
from tests.pipeline.export.stored_results import a_log, with_effects

AXES = "XYZ"
SLOPES = [0.02, -0.03, 0.01]  #: SI per kelvin


def parameters(stored: Stored, folder: Path) -> dict[str, float]:
    """The file as pymavlink reads it."""
    path = folder / "ardupilot.param"
    path.write_text(EXPORTERS["ardupilot"](stored).files[path.name], encoding="utf-8")
    read = pytest.importorskip("pymavlink.mavparm").MAVParmDict()
    assert read.load(str(path), use_excludes=False)
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    assert len(read) == len(lines)
    return {name: float(value) for name, value in read.items()}


def vector(value: dict[str, float], name: str) -> np.ndarray:
    return np.array([value[f"{name}_{axis}"] for axis in AXES])


def by_ardupilot(
    value: dict[str, float], triad: str, v: np.ndarray, warmth: np.ndarray
) -> np.ndarray:
    """What AP_InertialSensor makes of the driver's SI readings v (n, 3) at these temperatures.

    In this order, in the axes of the sensor: temperature, offset, scale; the board's rotation comes
    after. The polynomial has no constant term, its first coefficient is that of the first order,
    and it is subtracted at the temperature of the sample and added at that of the calibration, both
    held within TMIN and TMAX. Sources: ArduPilot/ardupilot, ``AP_InertialSensor_tempcal.cpp``
    (``polynomial_eval``, ``correct_sensor``, TEMP_REFERENCE, SCALE_FACTOR) and
    ``AP_InertialSensor_Backend.cpp`` (``_rotate_and_correct_accel``, ``_rotate_and_correct_gyro``).
    """
    short, caltemp = {"accelerometer": ("ACC", "INS_ACC1_CALTEMP"),
                      "gyroscope": ("GYR", "INS_GYR1_CALTEMP")}[triad]
    if value["INS_TCAL1_ENABLE"] == 1:
        def polynomial(temperature: np.ndarray) -> np.ndarray:
            held = np.clip(temperature, value["INS_TCAL1_TMIN"], value["INS_TCAL1_TMAX"])
            d = (held - 35.0)[:, None]
            first, second, third = (vector(value, f"INS_TCAL1_{short}{k}") for k in (1, 2, 3))
            return 1e-6 * (first + (second + third * d) * d) * d

        v = v - polynomial(warmth) + polynomial(np.array([value[caltemp]]))
    if triad == "accelerometer":
        return (v - vector(value, "INS_ACCOFFS")) * vector(value, "INS_ACCSCAL")
    return v - vector(value, "INS_GYROFFS")


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
@pytest.mark.parametrize("warm", [False, True])
def test_readings_through_ardupilot_s_formula_are_corrected_up_to_what_is_said(
    finished: RunSession, tmp_path: Path, triad: str, warm: bool
) -> None:
    stored = with_effects(finished, tmp_path, triad, {"temperature_bias": SLOPES} if warm else {})
    value = parameters(stored, tmp_path)
    assert value["INS_TCAL1_ENABLE"] == float(warm)
    low, high = value.get("INS_TCAL1_TMIN", 20.0), value.get("INS_TCAL1_TMAX", 30.0)
    warmth = np.linspace(low, high, 500)
    log = a_log(temperature_c=warmth)
    own = triad_named(stored, triad)
    assert own is not None
    nominal = own.correction.spec.nominal(getattr(log, triad))
    corrected = by_ardupilot(value, triad, nominal, warmth)
    left = np.linalg.norm(corrected - apply_results(stored, log).triads[triad], axis=1)
    note = next(each for each in EXPORTERS["ardupilot"](stored).loses
                if f"of the {triad}: an error of up to" in each)
    share = re.search(r"up to ([\d.e-]+) %", note)
    assert share is not None
    # The temperature's part is exact but for the misalignment, which ArduPilot has no place for.
    slack = 0.05 * max(abs(s) for s in SLOPES) * np.ptp(warmth) if warm else 0.0
    limit = 1.06 * float(share[1]) / 100 * np.linalg.norm(corrected, axis=1) + slack
    assert (left <= limit).all()
    if warm:  # and it is there: without the coefficients the error is that of the temperature
        cold = by_ardupilot({**value, "INS_TCAL1_ENABLE": 0.0}, triad, nominal, warmth)
        gain = 1.0 if triad == "accelerometer" else (
            own.units_per_count / own.correction.spec.nominal_scale)[1]  # it scales no gyroscope
        assert np.ptp((cold - corrected)[:, 1]) == pytest.approx(
            abs(SLOPES[1]) / gain * np.ptp(warmth), rel=1e-4)


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_a_curve_in_the_temperature_is_its_polynomial(
    finished: RunSession, tmp_path: Path, triad: str
) -> None:
    curve = [0.02, 0.01, -0.03, -0.03, 0.02, 0.01, 0.01, -0.02, 0.02]
    stored = with_effects(finished, tmp_path, triad, {"temperature_bias_curve": curve},
                          shapes={"temperature_bias_curve": 27.0})
    value = parameters(stored, tmp_path)
    warmth = np.linspace(value["INS_TCAL1_TMIN"], value["INS_TCAL1_TMAX"], 500)
    own = triad_named(stored, triad)
    assert own is not None
    d = (warmth - 27.0)[:, None]
    of_axis = np.array(curve).reshape(3, 3).T
    error = d * of_axis[0] + d**2 / 10 * of_axis[1] + d**3 / 100 * of_axis[2]
    rest = np.zeros((500, 3))
    corrected = by_ardupilot(value, triad, rest, warmth) - by_ardupilot(
        {**value, "INS_TCAL1_ENABLE": 0.0}, triad, rest, warmth)
    gain = 1.0 if triad == "accelerometer" else (
        own.units_per_count / own.correction.spec.nominal_scale)  # it scales no gyroscope
    assert corrected - corrected[0] == pytest.approx(-(error - error[0]) / gain, abs=1e-6)


def test_the_temperature_calibration_is_not_named_as_lost(
    finished: RunSession, tmp_path: Path
) -> None:
    stored = with_effects(finished, tmp_path, "gyroscope",
                          {"temperature_bias": SLOPES, "quadratic": [1e-3] * 3})
    (note,) = (each for each in EXPORTERS["ardupilot"](stored).loses if "quadratic" in each)
    assert "temperature_bias" not in note
    assert re.search(r"In this session it is up to [\d.]+ °/s", note)


def test_large_offsets_and_the_start_s_own_calibration_are_warned_of(finished: RunSession) -> None:
    loses = " ".join(EXPORTERS["ardupilot"](load_results(finished.folder)).loses)
    assert "INS_GYR_CAL to 0" in loses
    assert "Logs of ArduPilot itself are corrected already" in loses


def test_no_name_of_ardupilot_s_is_longer_than_it_stores(finished: RunSession,
                                                         tmp_path: Path) -> None:
    value = parameters(load_results(finished.folder), tmp_path)
    assert max(map(len, value)) <= 16
