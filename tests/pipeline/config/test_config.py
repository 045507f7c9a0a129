"""The configuration: every key is read, every mistake is named with its line."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from calib.effects.catalogue import BASE, find_effect
from calib.effects.effect import EFFECTS
from pipeline.config.load import Config, load_config
from pipeline.config.schema import KnownRateSection, VideoRateSection
from pipeline.config.sensor import triad_spec
from pipeline.config.template import template_text
from pipeline.errors import ConfigError, MissingFiles, exit_code_of
from tests.paths import SHARED

GOOD = """\
title: MTi on a 16 rpm record player
sensor:
  name: Xsens MTi
  accelerometer: {full_scale_m_s2: 50, bits: 16, encoding: offset-binary}
  gyroscope: {full_scale_deg_s: 150, bits: 16, encoding: offset-binary}
rate:
  slow:
    video: clip.mp4
    nominal_rpm: 16.667
    timebase: {source: constant, fps: 15}
    model: [constant_rate, once_per_rev]
    plate: {centre_px: [240, 180], radii_px: [150, 140.5]}
  33: {rate_rad_s: 3.4907, sd_rad_s: 2e-4}
site: {latitude_deg: 40.85, height_m: 20, gravity_m_s2: 9.80267, sd_m_s2: 5e-5}
accelerometer:
  poses: acc/pose_*.csv          # in natural order
  model: [bias, scale, misalignment, column:supply_v, mine]
  solver: paper
gyroscope:
  runs:
    - {poses: [gyr/b.csv, gyr/a.csv], rate: slow}
    - {poses: {files: 'gyr/?.csv', columns: [gyr_x, gyr_y, gyr_z], sample_rate_hz: 100}, rate: 33}
    - poses:
        log: [gyr/a.csv, gyr/b.csv]
        columns: [[time_s, acc_x, acc_y, acc_z], [time_s, gyr_x, gyr_y, gyr_z]]
        find: still
      rate: stopped
certificate:
  accelerometer: {bias_counts: [1, 2, 3], scale_counts_per_unit: [4, 5, 6]}
effects:
  mine: {expression: temperature_c ** 2, per: axis, unit: m/s² per °C²}
installation: {log: gyr/a.csv}
record: {device: xsens-mti, port: COM3, poses: 18}
"""


@pytest.fixture
def session(tmp_path: Path) -> Path:
    """A folder with the files that ``GOOD`` names."""
    for name in ("clip.mp4", "acc/pose_1.csv", "acc/pose_2.csv", "acc/pose_10.csv",
                 "gyr/a.csv", "gyr/b.csv"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.touch()
    return tmp_path


def load(folder: Path, text: str) -> Config:
    path = folder / "config.yaml"
    path.write_text(text, encoding="utf-8")
    return load_config(path)


def problems(folder: Path, text: str) -> list[str]:
    """The paragraphs without the folder's name."""
    with pytest.raises(ConfigError) as caught:
        load(folder, text)
    return [says.removeprefix(f"{folder}/") for says in caught.value.problems]


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
    listed = [name for name in EFFECTS if name not in BASE]
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


MISTAKES = [
    # where the text is changed, into what, line, and what the message must say
    ("title:", "titel:", 1, "titel: no key is named 'titel' here .did you mean 'title'"),
    ("bits: 16, encoding: offset-binary}\n  gyr", "encoding: offset-binary}\n  gyr", 4,
     "accelerometer.bits: is missing"),
    ("full_scale_m_s2: 50", "full_scale_g: 5, full_scale_m_s2: 50", 4, "give one of the two"),
    ("full_scale_m_s2: 50", "full_scale: 50", 4, "lacks its unit; write full_scale_m_s2 or full"),
    ("full_scale_deg_s: 150", "full_scale_rpm: 25", 5, "full_scale_deg_s = 6 × full_scale_rpm"),
    ("bits: 16, encoding: offset-binary}\nrate", "bits: yes, encoding: offset-binary}\nrate", 5,
     "found 'yes', expected a whole number"),
    ("bits: 16, encoding: offset-binary}\nrate", "bits: true, encoding: offset-binary}\nrate", 5,
     "found true, expected a whole number"),
    ("offset-binary}\nrate", "offset_binary}\nrate", 5,
     "'offset-binary', 'twos-complement' or 'unsigned-twos-complement'"),
    ("full_scale_deg_s: 150", "unit: deg_s", 5, "only for logs in counts"),
    ("clip.mp4", "clop.mp4", 8, "rate.slow.video: there is no file 'clop.mp4' .did you mean 'clip"),
    ("clip.mp4", "acc", 8, "'acc' is a folder"),
    ("16.667", "-1", 9, "found -1, expected a number greater than 0"),
    ("16.667", ".nan", 9, "found nan, expected a finite number"),
    ("constant, fps: 15", "constant", 10, "fps: is missing"),
    ("source: constant", "source: container", 10, "fps: only for `source: constant`"),
    ("once_per_rev", "once_per_turn", 11, "no vision term is named 'once_per_turn'"),
    ("[constant_rate, once_per_rev]", "[constant]", 11, "no vision term is named 'constant'"),
    ("[240, 180]", "[240]", 12, "centre_px: entry 2 is missing"),
    ("rate_rad_s: 3.4907", "rate_rpm: 33.333", 13, "rate_rad_s = 0.1047198 × rate_rpm, here "
     "`rate_rad_s: 3.490624`"),
    ("{rate_rad_s", "{video: clip.mp4, rate_rad_s", 13, "'video' is given as well"),
    ("sd_rad_s: 2e-4", "sd_rad_s: 0", 13, "found 0, expected a number greater than 0"),
    ("9.80267", "980", 14, "found 980, expected a number of at most 9.9"),
    ("latitude_deg: 40.85", "latitude: 40.85", 14, "lacks its unit; write latitude_deg"),
    ("acc/pose_*.csv", "acc/pos_*.csv", 16, "no file matches 'acc/pos_..csv'. The folder .*acc "
     "holds pose_1.csv, pose_2.csv, pose_10.csv"),
    ("acc/pose_*.csv", "occ/*.csv", 16, "There is no folder 'occ'"),
    ("misalignment, col", "misalignement, col", 17,
     "accelerometer.model: no effect is named 'misalignement' .did you mean 'misalignment'"),
    ("column:supply_v", "column", 17, "no effect is named 'column' .did you mean 'column:NAME'"),
    ("column:supply_v", "bias", 17, "'bias' is given twice"),
    ("solver: paper", "solver: papr", 18, "found 'papr', expected 'default' or 'paper'"),
    ("rate: slow}", "rate: slov}", 21, "runs.0..rate: no rate is named 'slov' .did you mean 'sl"),
    ("[gyr/b.csv, gyr/a.csv]", "[gyr/b.csv, gyr/b.csv]", 21, "b.csv is named twice"),
    ("[gyr/b.csv, gyr/a.csv]", "[gyr/b.csv, 3]", 21, "found 3, a file's name or pattern"),
    ("sample_rate_hz: 100", "find: still", 22, "only for `log`"),
    ("[time_s, acc_x, acc_y, acc_z]", "[acc_x, acc_y, acc_z]", 25, "time_s is missing"),
    ("[time_s, acc_x, acc_y, acc_z]", "[time_s, acc_x, acc_y]", 25, "acc_z missing beside"),
    ("        find: still\n", "", 23, "find: is missing"),
    ("[1, 2, 3]", "[1, 2, x]", 29, "found 'x', expected a number"),
    ("  mine:", "  bias:", 31, "'bias' cannot name a user-defined effect"),
    ("installation: {log: gyr/a.csv}", "installation:", 32, "nothing stands after 'installation:'"),
    ("poses: 18}", "poses: 7.5}", 33, "expected a whole number"),
    ("poses: 18}", "poses: 27}", 33, "expected a number of at most 26"),
    ("device: xsens-mti", "device: xsens", 33, "no device is named 'xsens' .did you mean 'xsens-m"),
    ("device: xsens-mti", "device: lines", 33, "pattern: is missing"),
    ("poses: 18}", "pattern: '{acc_x}'}", 33, "only for `device: lines`"),
    ("xsens-mti, port: COM3", "lines, pattern: '{acc_x},{acc_y}'", 33, "acc_z missing"),
]


@pytest.mark.parametrize(("old", "new", "line", "says"), MISTAKES)
def test_a_mistake_is_named_with_its_line(
    session: Path, old: str, new: str, line: int, says: str
) -> None:
    assert GOOD.count(old) == 1
    found = problems(session, GOOD.replace(old, new))
    with pytest.raises(AssertionError, match=says):
        raise AssertionError("\n".join(p for p in found if p.startswith(f"config.yaml:{line}: ")))


#: Changes that make two mistakes: both keys of a pair, or a name that is also missing elsewhere.
TWOFOLD = {"unit: deg_s", "{video: clip.mp4, rate_rad_s", "find: still", "  bias:"}


def test_a_mistake_is_told_once(session: Path) -> None:
    for old, new, _, _ in MISTAKES:
        found = problems(session, GOOD.replace(old, new))
        assert len(found) == (2 if new in TWOFOLD else 1), found
        assert all("\n" not in says for says in found)


def test_all_mistakes_of_a_file_are_listed_in_the_order_of_lines(session: Path) -> None:
    text = GOOD
    chosen = [MISTAKES[i] for i in (0, 3, 9, 17, 21, 25, 28, 31, 36)]
    for old, new, _, _ in chosen:
        text = text.replace(old, new)
    lines = [int(says.split(":")[1]) for says in problems(session, text)]
    assert lines == sorted(lines)
    assert {line for _, _, line, _ in chosen} == set(lines)


@pytest.mark.parametrize(("removed", "says"), [
    ("sensor", "sensor: is missing"), ("site", "site: is missing"),
])
def test_what_a_task_needs_is_asked_for(session: Path, removed: str, says: str) -> None:
    values = yaml.safe_load(GOOD)
    del values[removed]
    assert any(says in each for each in problems(session, yaml.safe_dump(values)))


def test_a_duplicate_key_is_named_with_both_lines(session: Path) -> None:
    (found,) = problems(session, GOOD + "title: other\n")
    assert found.startswith("config.yaml:34: title: the key 'title' is given twice, first in "
                            "line 1.")


@pytest.mark.parametrize(("changes", "code"), [
    ({"clip.mp4": "clop.mp4"}, 3), ({"clip.mp4": "clop.mp4", "acc/pose_*.csv": "no/*.csv"}, 3),
    ({"clip.mp4": "acc"}, 2), ({"[gyr/b.csv, gyr/a.csv]": "[gyr/b.csv, 3]"}, 2),
    ({"clip.mp4": "clop.mp4", "title:": "titel:"}, 2),
    ({"clip.mp4": "clop.mp4", "    find: still\n": "    find: still\n      rate: stopped\n"}, 2),
])
def test_exit_code_3_when_nothing_but_files_is_missing(
    session: Path, changes: dict[str, str], code: int
) -> None:
    text = GOOD
    for old, new in changes.items():
        text = text.replace(old, new)
    with pytest.raises(ConfigError) as caught:
        load(session, text)
    assert exit_code_of(caught.value) == code
    assert isinstance(caught.value, MissingFiles) == (code == 3)


def test_files_still_to_be_recorded_may_be_missing(tmp_path: Path) -> None:
    path = tmp_path / "config.yaml"
    path.write_text(GOOD, encoding="utf-8")
    config = load_config(path, files_may_be_missing=True)
    assert config.accelerometer is not None
    assert config.accelerometer.poses.files == ()
    path.write_text(GOOD.replace("title:", "titel:"), encoding="utf-8")
    with pytest.raises(ConfigError, match="did you mean 'title'"):
        load_config(path, files_may_be_missing=True)


def test_clips_must_pair_with_poses(session: Path) -> None:
    for i in range(3):
        (session / f"clip_{i}.mp4").touch()
    (found,) = problems(session, GOOD.replace("clip.mp4", "clip_*.mp4"))
    assert "'slow' has 3 clips for 2 poses" in found


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
