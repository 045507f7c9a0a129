"""A session in a notebook: loaded, asked, shown and compared."""


import numpy as np
import pandas
import pytest

import calib
import pipeline
import vision
from calib.errors import CalibrationError, Undetermined, UnusableLog
from calib.notebook.display import partial_residuals
from tests.sessions import quick_session


@pytest.fixture(scope="module")
def loaded(tmp_path_factory: pytest.TempPathFactory) -> "pipeline.LoadedSession":
    config, _ = quick_session(tmp_path_factory.mktemp("notebook"))
    return pipeline.load(config.parent)


def test_names_complete_and_a_session_is_text(loaded: "pipeline.LoadedSession") -> None:
    assert dir(calib) == ["Calibration", "calibrate", "compare"]
    assert "load" in dir(pipeline)
    assert dir(vision) == ["measure_rate"]
    assert "accelerometer, 18 poses" in repr(loaded)
    shown = repr(loaded.accelerometer.diagnose())  # type: ignore[union-attr]
    assert shown.startswith("nothing_missing: ")
    assert len(shown) < 1000


def test_what_an_effect_explains_is_the_residual_where_it_is_there() -> None:
    rng = np.random.default_rng(5)
    axes = rng.standard_normal((40, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    volt = rng.uniform(3.0, 4.0, 40)
    table = {"acc_x": 9.81 * axes[:, 0] + 0.2 * volt, "acc_y": 9.81 * axes[:, 1],
             "acc_z": 9.81 * axes[:, 2], "volt": volt,
             **{f"sd_acc_{axis}": np.full(40, 0.002) for axis in "xyz"}}
    found = calib.calibrate(table, gravity=9.81)
    explained, residual = partial_residuals(
        found.assessed, found.add("column:volt").assessed.calibration.fit.model.effects[-1])
    assert np.corrcoef(explained, residual)[0, 1] > 0.999
    assert np.polyfit(explained, residual, 1)[0] == pytest.approx(1.0, abs=1e-6)
    assert found.plot("column:volt").axes[0].get_xlabel().startswith("what column:volt explains")


def test_effects_that_cannot_be_asked_for_say_why(loaded: "pipeline.LoadedSession") -> None:
    accelerometer = loaded.accelerometer
    assert accelerometer is not None
    with pytest.raises(CalibrationError, match="is an effect of the gyroscope"):
        accelerometer.add("g_sensitivity")
    with pytest.raises(Undetermined, match=r"no complete column foo\. Their columns are: "):
        accelerometer.add("column:foo")
    with pytest.raises(CalibrationError, match="is in the model already"):
        accelerometer.plot("bias")


def test_calibrations_are_compared_and_their_parameters_correlated(
    loaded: "pipeline.LoadedSession",
) -> None:
    one = loaded.gyroscope
    assert one is not None
    same = calib.compare(one, one)
    assert (same["difference"] == 0).all()
    assert same["unit"].iloc[0] == "rad"
    matrix = one.correlations()
    np.testing.assert_allclose(np.diag(matrix), 1.0)
    assert (np.abs(matrix.to_numpy()) <= 1 + 1e-9).all()


def test_what_is_added_to_a_session_keeps_its_data_sheet_and_options(
    loaded: "pipeline.LoadedSession",
) -> None:
    one = loaded.accelerometer
    assert one is not None
    assert "counts" in repr(one)
    table = one.to_pandas()
    assert table.loc["bias x", "unit"] == "counts"
    assert table.loc["scale x", "unit"] == "counts/(m/s²)"
    more = one.add("quadratic")
    assert more.options == one.options
    beside = calib.compare(one, more)
    assert (beside["in_sd"].dropna().abs() < 5).all()  # counts beside counts
    again = more.remove("quadratic").to_pandas()
    np.testing.assert_allclose(again["value"], table["value"], rtol=1e-6)


def test_a_log_of_the_session_is_corrected_from_its_counts(
    loaded: "pipeline.LoadedSession",
) -> None:
    one = loaded.accelerometer
    assert one is not None
    log = pandas.read_csv(loaded.outcome.config.source.path.parent / one.poses.label[0])
    force = one.correct(log)
    gravity = one.poses.reference.magnitude[0]
    assert np.linalg.norm(force.mean(axis=0)) == pytest.approx(gravity, abs=0.02)


def test_calibrations_of_different_data_sheets_are_not_compared(
    loaded: "pipeline.LoadedSession",
) -> None:
    rng = np.random.default_rng(1)
    axes = rng.standard_normal((24, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    in_si = calib.calibrate(9.81 * axes + rng.normal(0, 0.002, axes.shape), gravity=9.81)
    with pytest.raises(UnusableLog, match="a count of the one is no count of the other"):
        calib.compare(loaded.accelerometer, in_si)
    with pytest.raises(TypeError, match="two calibrations"):
        calib.compare(loaded.accelerometer, 3)  # type: ignore[arg-type]


def test_rates_are_said_in_a_line(loaded: "pipeline.LoadedSession") -> None:
    for rate in loaded.rates.values():
        assert "rpm)" in repr(rate)
        assert len(repr(rate)) < 60
