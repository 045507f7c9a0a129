"""A calibration in a notebook is the command's: recovered truth, honest answers, no warnings."""

import numpy as np
import pandas
import pytest

import calib
from calib.errors import CalibrationError, Undetermined, UnusableLog
from calib.poses.imu_log import FloatArray
from pipeline.config.load import load_config
from pipeline.config.sensor import triad_spec
from tests.fitting import spec_of
from tests.sessions import pipeline, quick_session, results_in
from tests.world.bench import corner_directions, wedge_directions
from tests.world.designs import paper_design
from tests.world.imu import mpu6050
from tests.world.lot import LotPlan, draw_lot

G = 9.807
SD = 0.002
MATRIX = np.array([[1.01, 0.01, -0.02], [0.0, 0.99, 0.005], [0.0, 0.0, 1.02]])  # T K of eq. (1)
BIAS = np.array([0.1, -0.2, 0.3])


def readings(seed: int = 1, warmth: float = 0.0) -> pandas.DataFrame:
    """Pose means of 26 directions with white noise, sds stated, a bias that follows temperature."""
    rng = np.random.default_rng(seed)
    true = G * np.vstack([wedge_directions(), corner_directions()])
    temperature = rng.uniform(20, 40, len(true))
    means = true @ np.linalg.inv(MATRIX).T + BIAS + warmth * (temperature - 25)[:, None]
    table = pandas.DataFrame(means + rng.normal(0, SD, true.shape),
                             columns=["acc_x", "acc_y", "acc_z"])
    table["time_s"] = 20.0 * rng.permutation(len(true))
    table["temperature_c"] = temperature
    return table.assign(sd_acc_x=SD, sd_acc_y=SD, sd_acc_z=SD)


def test_five_lines_name_the_hidden_effect_and_the_error_falls() -> None:
    cal = calib.calibrate(readings(warmth=0.004), gravity=G)
    assert cal.diagnose().names == ("temperature_bias",)
    better = cal.add("temperature_bias")
    assert better.assessed.comparison.loo_rms < 0.2 * cal.assessed.comparison.loo_rms
    assert better.diagnose().verdict == "nothing_missing"
    frame = better.to_pandas()
    assert frame.loc["temperature_bias x", "value"] == pytest.approx(0.004, abs=5e-4)
    assert better.remove("temperature_bias").model == cal.model


def test_parameters_and_corrected_readings_are_those_of_the_truth() -> None:
    table = readings()
    cal = calib.calibrate(table, gravity=G)
    frame = cal.to_pandas()
    truth = [MATRIX[1, 2] / 1.02, MATRIX[0, 2] / 1.02, MATRIX[0, 1] / 0.99, *BIAS,
             *(1 / np.diag(MATRIX))]
    assert (np.abs(frame["value"] - truth) < 4 * frame["sd"]).all()
    assert np.linalg.norm(cal.correct(table), axis=1) == pytest.approx(G, abs=4 * SD)


def test_means_without_sds_get_no_false_verdict_and_no_warning() -> None:
    cal = calib.calibrate(readings()[["acc_x", "acc_y", "acc_z"]].to_numpy(), gravity=G)
    assert cal.diagnose().verdict == "refused"
    assert "the poses have no sds" in repr(cal)


def test_a_gyroscope_s_table_states_its_rates() -> None:
    rng = np.random.default_rng(3)
    rate = np.repeat([0.0, 1.75, -3.49], 18)
    true = np.tile(wedge_directions(), (3, 1)) * rate[:, None]
    means = true @ np.linalg.inv(MATRIX).T + 0.02 + rng.normal(0, 1e-4, true.shape)
    table = {"gyr_x": means[:, 0], "gyr_y": means[:, 1], "gyr_z": means[:, 2],
             **{f"sd_gyr_{axis}": np.full(54, 1e-4) for axis in "xyz"}, "rate_rad_s": rate}
    cal = calib.calibrate(table)
    assert cal.triad == "gyroscope"
    assert cal.to_pandas().loc["bias x", "value"] == pytest.approx(0.02, abs=2e-4)
    assert len(cal.poses_to_pandas()["run"].unique()) == 3


def test_samples_of_poses_give_the_command_s_own_figures(
    tmp_path_factory: pytest.TempPathFactory
) -> None:
    """The same engine: poses from a session's own logs, one frame of all samples."""
    config, truth = quick_session(tmp_path_factory.mktemp("samples"))
    assert pipeline("run", config) == 0
    stored = results_in(config.with_suffix(".run"))["accelerometer"]
    parts = [pandas.read_csv(path, skipinitialspace=True).assign(pose=path.stem)
             for path in sorted((config.parent / "accelerometer").glob("*.csv"))]
    table = pandas.concat(parts)
    section = load_config(config).sensor.accelerometer
    assert section is not None
    names = ["acc_x", "acc_y", "acc_z"]
    table[names] = triad_spec(section).nominal(table[names].to_numpy())
    cal = calib.calibrate(table[["pose", "time_s", "acc_x", "acc_y", "acc_z"]],
                          gravity=truth.design.site.gravity_m_s2)
    assert cal.assessed.comparison.residual_rms == pytest.approx(stored["residual_rms"], rel=0.02)


@pytest.mark.parametrize(("table", "words"), [
    ({"acc_x": [1.0], "acc_y": [1.0]}, "no column acc_z"),
    ({"acc_x": ["a"], "acc_y": [1.0], "acc_z": [1.0]}, "is not numeric .* state `by='acc_x'`"),
    ({"acc_x": [1.0, 2.0], "acc_y": [1.0], "acc_z": [1.0]}, "different lengths"),
    (np.zeros((4, 2)), r"\(n, 3\) expected"),
    ({"aX": [1.0], "aY": [1.0], "aZ": [1.0]}, r"rename\(columns=\{'aX': 'acc_x', 'aY': 'acc_y'"),
    ({"acc_x": [1.0, 0], "acc_y": [0.0, 1], "acc_z": [0.1, 0]}, "is g: multiply .* by 9.80665"),
    ({"acc_x": [9.8, np.nan], "acc_y": [0.0, 0], "acc_z": [0.1, 0]}, "has no number in row 2"),
    ({"acc_x": [], "acc_y": [], "acc_z": []}, "it has no rows"),
    (None, "NoneType found"), ("log.csv", "read by pandas.read_csv"),
    (pandas.DataFrame(np.ones((2, 4)), columns=["acc_x", "acc_y", "acc_z", "acc_x"]),
     "a name stands over two columns"),
])
def test_a_wrong_table_is_told_what_is_wrong(table: object, words: str) -> None:
    with pytest.raises(UnusableLog, match=words):
        calib.calibrate(table, gravity=G)


def test_a_wrong_reference_is_told_what_is_wrong() -> None:
    with pytest.raises(UnusableLog, match=r"gravity=981: 9.763 to 9.835"):
        calib.calibrate(readings(), gravity=981)
    with pytest.raises(UnusableLog, match="State `gravity=`"):
        calib.calibrate(readings())
    table = dict(zip(("gyr_x", "gyr_y", "gyr_z"), 3.49 * wedge_directions().T, strict=True))
    with pytest.raises(UnusableLog, match=r"reference is in °/s: multiply it by 0.0174533"):
        calib.calibrate(table, rate=200.0)


def test_means_without_any_noise_are_no_measurement() -> None:
    with pytest.raises(Undetermined, match="show no noise: are they computed"):
        calib.calibrate(G * 1.01 * wedge_directions() + 0.05, gravity=G)


def test_a_wrong_effect_is_answered_with_the_nearest() -> None:
    found = calib.calibrate(readings(), gravity=G)
    with pytest.raises(CalibrationError, match="did you mean 'quadratic'"):
        found.add("quadratik")
    with pytest.raises(CalibrationError, match="did you mean 'g_sensitivity'"):
        found.plot("gsens")
    with pytest.raises(CalibrationError, match="there are: bias, scale"):
        found.plot("zzz")
    with pytest.raises(CalibrationError, match=r"'skale' is not in the model .*mean 'scale'"):
        found.remove("bias", "skale")


def test_too_few_poses_are_refused() -> None:
    with pytest.raises(Undetermined, match="6 equations for 9 parameters"):
        calib.calibrate(readings().iloc[:6], gravity=G)


def test_what_a_notebook_shows_is_escaped_and_drawn() -> None:
    table = readings()
    table["<script>alert(1)</script>"] = np.arange(len(table)) * 0.1
    cal = calib.calibrate(table, gravity=G).add("column:<script>alert(1)</script>")
    assert "<script>" not in cal._repr_html_()
    (axes,) = cal.plot().axes
    drawn: FloatArray = np.asarray(axes.lines[0].get_ydata(), float)
    assert np.allclose(drawn, cal.poses_to_pandas()["residual"])


def test_the_package_loads_no_engine_before_it_is_asked() -> None:
    assert calib.calibrate is calib.__getattr__("calibrate")
    with pytest.raises(AttributeError):
        calib.fitting  # noqa: B018


def test_a_table_of_many_sensors_is_a_lot() -> None:
    """Each sensor as by itself, whatever the order of the rows; one without poses is refused."""
    lot = draw_lot(paper_design(mpu6050()), LotPlan(6), 2)
    spec = spec_of(lot.triad, lot.triad.full_scale)
    reading, sd = spec.nominal(lot.counts), lot.sd_counts * spec.nominal_scale
    sensor = np.repeat([f"s{i}" for i in range(6)], 18)
    table = {"sensor": sensor, "run": np.full(108, "stopped"), "station": np.full(108, "bench 2")}
    for i, axis in enumerate("xyz"):
        table[f"acc_{axis}"] = reading[:, :, i].ravel()
        table[f"sd_acc_{axis}"] = sd[:, :, i].ravel()
    kept = np.random.default_rng(1).permutation(np.delete(np.arange(108), np.arange(80, 90)))
    table = {name: values[kept] for name, values in table.items()}
    gravity = float(lot.magnitude[0, 0])
    many = calib.calibrate(table, by="sensor", gravity=gravity)
    assert len(many) == 6
    assert list(many.refusals) == ["s4"]
    frame = many.to_pandas()
    for name in ("s0", "s5"):
        mine = table["sensor"] == name
        part = {key: values[mine] for key, values in table.items() if key != "sensor"}
        one = calib.calibrate(part, gravity=gravity)
        single = one.assessed.calibration.parameters
        assert frame.loc[name, "scale_y"] == pytest.approx(single.scale_counts_per_unit[1])
        assert many[name].to_pandas().equals(one.to_pandas())
    assert "5 of 6 sensors calibrated" in repr(many)
    with pytest.raises(UnusableLog, match="no column unit, by which its sensors are told apart"):
        calib.calibrate(table, by="unit", gravity=gravity)


def test_a_run_that_is_called_stopped_has_no_rate() -> None:
    rng = np.random.default_rng(3)
    axes = np.tile(rng.normal(size=(18, 3)), (2, 1))
    rates = np.repeat([3.49, 0.0], 18)
    axes *= rates[:, None] / np.linalg.norm(axes, axis=1, keepdims=True)
    table = {f"gyr_{axis}": 1.01 * axes[:, i] + 0.02 + 1e-5 * rng.standard_normal(36)
             for i, axis in enumerate("xyz")} | {f"sd_gyr_{axis}": np.full(36, 1e-5)
                                                 for axis in "xyz"}
    called = table | {"run": np.where(rates > 0, "33rpm", "stopped")}
    one = calib.calibrate(called, rate=3.49).to_pandas()
    assert one.equals(calib.calibrate(table | {"rate_rad_s": rates}).to_pandas())
    with pytest.raises(UnusableLog, match="names 33rpm, 45rpm, and one rate is stated"):
        calib.calibrate(table | {"run": np.where(rates > 0, "33rpm", "45rpm")}, rate=3.49)


@pytest.mark.parametrize(("name", "value"), [
    ("gravity", np.nan), ("gravity", np.inf), ("gravity", "9.8"), ("gravity", [9.8]),
    ("gravity", True), ("gravity_sd", np.nan), ("gravity_sd", None), ("gravity_sd", -1.0),
    ("rate_sd", np.inf), ("model", []), ("model", "bias"), ("model", [3]), ("model", None),
])
def test_an_argument_of_a_wrong_kind_is_named(name: str, value: object) -> None:
    with pytest.raises(CalibrationError, match=f"{name}="):
        calib.calibrate(readings(), **{"gravity": G, name: value})  # type: ignore[call-overload]


@pytest.mark.parametrize(("changed", "words"), [
    ({"samples": -1.0}, "column samples has -1"), ({"samples": 0.0}, "column samples has 0"),
    ({"sd_acc_x": np.nan}, "column sd_acc_x has nan"),
    ({"time_s": pandas.Timestamp("2020-01-01")}, "column time_s is no list of real numbers"),
    ({"acc_x": 1j}, "column acc_x is no list of real numbers"),
    ({"acc_x": np.nan}, "has no number in row 1"),
])
def test_a_column_of_a_wrong_kind_is_named(changed: dict[str, object], words: str) -> None:
    with pytest.raises(UnusableLog, match=words):
        calib.calibrate(readings().assign(**changed), gravity=G)


def test_sds_of_some_axes_only_are_refused() -> None:
    with pytest.raises(UnusableLog, match="sd_acc_x, sd_acc_y without the other axes"):
        calib.calibrate(readings().drop(columns="sd_acc_z"), gravity=G)


def test_a_gain_of_two_is_warned_of_and_removing_everything_is_refused() -> None:
    table = readings()
    table[["acc_x", "acc_y", "acc_z"]] *= 2
    with pytest.warns(UserWarning, match=r"gain on . is 1\.9|gain on . is 2"):
        doubled = calib.calibrate(table, gravity=G)
    with pytest.raises(CalibrationError, match=r"model=\(\)"):
        doubled.remove("bias", "scale", "misalignment")
