"""The configuration: every key is read."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from calib.effects.catalogue import BASE, find_effect
from calib.effects.effect import EFFECTS
from pipeline.config.load import load_config
from pipeline.config.schema import KnownRateSection, VideoRateSection
from pipeline.config.sensor import triad_spec
from pipeline.config.template import template_text
from pipeline.errors import ConfigError
from tests.paths import SHARED
from tests.pipeline.config.complete import GOOD, load


def test_every_key_of_the_contract_is_read(session: Path) -> None:
    config = load(session, GOOD)
    assert config.title == "MTi on a 16 rpm record player"
    slow, known = config.rate["slow"], config.rate["33"]
    assert isinstance(slow, VideoRateSection)
    assert slow.video == (session / "clip.mp4",)
    assert slow.timebase.relative_sd == pytest.approx(500e-6)
    assert slow.plate is not None
    assert slow.plate.radii_px == (150, 140.5)
    assert isinstance(known, KnownRateSection)
    assert (known.rate_rad_s, known.sd_rad_s) == (3.4907, 2e-4)
    assert config.site is not None
    assert config.site.gravity_m_s2 == 9.80267
    assert config.accelerometer is not None
    assert config.accelerometer.solver == "paper"
    assert config.gyroscope is not None
    assert [run.rate for run in config.gyroscope.runs] == ["slow", "33", "stopped"]
    assert config.gyroscope.model == ("bias", "scale", "misalignment")
    long_log = config.gyroscope.runs[2].poses
    assert (long_log.find, long_log.columns_of(1)) == (
        "still", ("time_s", "gyr_x", "gyr_y", "gyr_z"))
    assert config.effects["mine"].expression == "temperature_c ** 2"


def test_patterns_are_in_natural_order_and_lists_in_their_own(session: Path) -> None:
    config = load(session, GOOD)
    assert config.accelerometer
    assert config.gyroscope
    assert [path.name for path in config.accelerometer.poses.files] == [
        "pose_1.csv", "pose_2.csv", "pose_10.csv"]
    assert [path.name for path in config.gyroscope.runs[0].poses.files] == ["b.csv", "a.csv"]


def test_a_preset_means_the_same_as_its_data_sheet(session: Path) -> None:
    preset = load(session, "sensor: xsens-mti\nrate: {slow: {video: clip.mp4}}")
    assert preset.sensor == load(session, GOOD).sensor
    mpu = load(session, "sensor: mpu-6050\nrate: {slow: {video: clip.mp4}}").sensor
    assert mpu.accelerometer is not None
    assert 9.80665 / triad_spec(mpu.accelerometer).nominal_scale == pytest.approx(16384)


def test_data_sheets_become_si_units(session: Path) -> None:
    sensor = load(session, GOOD).sensor
    assert sensor.accelerometer
    assert sensor.gyroscope
    accelerometer, gyroscope = triad_spec(sensor.accelerometer), triad_spec(sensor.gyroscope)
    assert (accelerometer.full_scale, accelerometer.bits) == (50.0, 16)
    assert gyroscope.full_scale == pytest.approx(math.radians(150))


@pytest.mark.parametrize(("unit", "triad", "si"), [
    ("g", "accelerometer", 9.80665), ("m_s2", "accelerometer", 1.0),
    ("deg_s", "gyroscope", math.pi / 180), ("rad_s", "gyroscope", 1.0),
])
def test_logs_in_physical_units_need_no_data_sheet(
    session: Path, unit: str, triad: str, si: float
) -> None:
    config = load(session, f"sensor: {{{triad}: {{unit: {unit}}}}}\n"
                           "rate: {slow: {video: clip.mp4}}")
    spec = triad_spec(getattr(config.sensor, triad))
    assert spec.encoding == "si"
    assert spec.nominal_scale == pytest.approx(si)


def test_results_go_beside_the_file_unless_told_otherwise(session: Path) -> None:
    assert load(session, GOOD).output_folder == session / "config.run"
    assert load(session, GOOD + "output: results\n").output_folder == session / "results"


def test_a_config_cannot_be_changed_after_loading(session: Path) -> None:
    with pytest.raises(ValueError, match="frozen"):
        load(session, GOOD).title = "other"  # type: ignore[misc]


def test_every_effect_of_the_catalogue_can_be_named_in_a_model(session: Path) -> None:
    lines = {name for each in EFFECTS.values() for name in each.contains}
    listed = [name for name in EFFECTS if name not in {*BASE, *lines}]
    text = GOOD.replace("column:supply_v, mine]", ", ".join(listed) + "]")
    accelerometer = load(session, text).accelerometer
    assert accelerometer is not None
    assert accelerometer.model == (*BASE, *listed)


def test_an_effect_that_is_registered_can_be_named_in_a_model_at_once(
    session: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    new = replace(find_effect("quadratic"), name="magnetic_field")
    text = GOOD.replace("column:supply_v", new.name)
    with pytest.raises(ConfigError, match="no effect is named 'magnetic_field'"):
        load(session, text)
    monkeypatch.setitem(EFFECTS, new.name, new)
    accelerometer = load(session, text).accelerometer
    assert accelerometer is not None
    assert new.name in accelerometer.model


COLUMNS = "columns: [[time_s, acc_x, acc_y, acc_z], [time_s, gyr_x, gyr_y, gyr_z]]"


@pytest.mark.parametrize(("old", "section", "message"), [
    ("acc/pose_*.csv          # in natural order", f"{{files: acc/*.csv, {COLUMNS}}}",
     "accelerometer.poses.columns: 2 lists of names for the 3 files of `files`. Give one list"),
    ("{log: gyr/a.csv}", f"{{log: [gyr/a.csv, gyr/b.csv], drive_log: gyr/a.csv, {COLUMNS}}}",
     "installation.columns: 2 lists of names for the 1 file of `drive_log`. Give one list"),
])
def test_lists_of_column_names_are_one_or_one_per_file_of_a_key(
    session: Path, old: str, section: str, message: str
) -> None:
    with pytest.raises(ConfigError) as caught:
        load(session, GOOD.replace(old, section))
    assert message in str(caught.value)


def test_the_catalogue_holds_the_effects_of_the_contract() -> None:
    assert set(EFFECTS) >= {
        "bias", "scale", "misalignment", "frame_rotation", "quadratic", "cubic", "asymmetry",
        "cross_quadratic", "temperature_bias", "temperature_scale", "bias_drift", "scale_drift",
        "warm_up", "hysteresis", "vibration_rectification", "g_sensitivity",
        "g_squared_sensitivity", "lever_arm", "earth_rate", "reference_offset", "reference_scale",
        "reference_drift", "direction_dependent_rate",
    }


def test_files_still_to_be_recorded_may_be_missing(tmp_path: Path) -> None:
    path = tmp_path / "config.yaml"
    path.write_text(GOOD, encoding="utf-8")
    config = load_config(path, files_may_be_missing=True)
    assert config.accelerometer is not None
    assert config.accelerometer.poses.files == ()
    path.write_text(GOOD.replace("title:", "titel:"), encoding="utf-8")
    with pytest.raises(ConfigError, match="did you mean 'title'"):
        load_config(path, files_may_be_missing=True)


def test_the_template_is_a_valid_configuration_once_its_files_are_there(tmp_path: Path) -> None:
    for name in ("video/17rpm.mp4", "accelerometer/pose_1.csv", "gyroscope/17rpm/pose_1.csv"):
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).touch()
    assert load(tmp_path, template_text()).sensor.name == "InvenSense MPU-6050"


@pytest.mark.parametrize("bench", ["a", "b", "c"])
def test_bench_sessions_are_read(bench: str) -> None:
    path = SHARED / "bench" / bench / "config.yaml"
    if not path.exists():
        pytest.skip("the shared bench sessions are not here")
    config = load_config(path)
    assert config.accelerometer
    assert len(config.accelerometer.poses.files) == 18
