"""Every mistake in a configuration is named once, with its line and what to write instead."""

from collections.abc import Iterable
from pathlib import Path

import pytest
import yaml

from pipeline.config.messages import SHOWN_ALIKE
from pipeline.errors import ConfigError, MissingFiles, exit_code_of
from pipeline.text.names import nearest_name
from tests.pipeline.config.complete import GOOD, load, problems

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
    ("full_scale_deg_s: 150, bits: 16, encoding: offset-binary", "unit: dps", 5,
     "did you mean 'deg_s'"),
    ("full_scale_deg_s: 150", "unit: deg_s", 5, "only for logs in counts"),
    ("full_scale_deg_s: 150", "counts_per_deg_s: 131, full_scale_deg_s: 250", 5, "one of the two"),
    ("columns: [gyr_x, gyr_y, gyr_z], sample", "columns: {gyr_x: wx}, sample", 22,
     "gyr_y and gyr_z missing"),
    ("sample_rate_hz: 100", "sample_rate_hz: 100, time_unit: ms", 22, "only for logs with a col"),
    ("sample_rate_hz: 100", "time_unit: ds", 22, "found 'ds', expected 's', 'ms'"),
    ("clip.mp4", "clop.mp4", 8, "rate.slow.video: there is no file 'clop.mp4' .did you mean 'clip"),
    ("clip.mp4", "acc", 8, "'acc' is a folder"),
    ("16.667", "-1", 9, "found -1, expected a number greater than 0"),
    ("16.667", ".nan", 9, "found nan, expected a finite number"),
    ("constant, fps: 15", "constant", 10, "fps: is missing"),
    ("source: constant", "source: container", 10, "fps: only for `source: constant`"),
    ("once_per_rev", "once_per_turn", 11, "no vision term is named 'once_per_turn'"),
    ("[constant_rate, once_per_rev]", "[constant]", 11, "no vision term is named 'constant'"),
    ("[240, 180]", "[240]", 12, "centre_px: entry 2 is missing"),
    ("rate_rad_s: 3.4907", "rate_rad_s: 0", 13, "rate: stopped"),
    ("rate_rad_s: 3.4907", "rate_rpm: 33.333", 13, "rate_rad_s = 0.1047198 × rate_rpm, here "
     "`rate_rad_s: 3.490624`"),
    ("{rate_rad_s", "{video: clip.mp4, rate_rad_s", 13, "'video' is given as well"),
    ("sd_rad_s: 2e-4", "sd_rad_s: 0", 13, "found 0, expected a number greater than 0"),
    ("9.80267", "980", 14, "found 980, expected a number of at most 9.835"),
    ("latitude_deg: 40.85", "latitude: 40.85", 14, "lacks its unit; write latitude_deg"),
    ("acc/pose_*.csv", "acc/pos_*.csv", 16, "no file matches 'acc/pos_..csv'. The folder .*acc "
     "holds pose_1.csv, pose_2.csv, pose_10.csv"),
    ("acc/pose_*.csv", "occ/*.csv", 16, "There is no folder 'occ'"),
    ("misalignment, col", "misalignement, col", 17,
     "accelerometer.model: no effect is named 'misalignement' .did you mean 'misalignment'"),
    ("column:supply_v", "column", 17, "no effect is named 'column' .did you mean 'column:NAME'"),
    ("column:supply_v", "bias", 17, "'bias' is given twice"),
    ("column:supply_v", "column:temperature_c, temperature_bias_curve", 17,
     "'column:temperature_c' is part of 'temperature_bias_curve', which the model has too"),
    ("solver: paper", "solver: papr", 18, "'default' or 'paper' .did you mean 'paper'"),
    ("rate: slow}", "rate: slov}", 21, "runs.0..rate: no rate is named 'slov' .did you mean 'sl"),
    ("[gyr/b.csv, gyr/a.csv]", "[gyr/b.csv, gyr/b.csv]", 21, "b.csv is named twice"),
    ("[gyr/b.csv, gyr/a.csv]", "[gyr/b.csv, 3]", 21, "found 3, a file's name or pattern"),
    ("sample_rate_hz: 100", "find: still", 22, "only for `log`"),
    ("[time_s, acc_x, acc_y, acc_z]", "[acc_x, acc_y, acc_z]", 25, "time_s is missing"),
    ("[time_s, acc_x, acc_y, acc_z]", "[time_s, acc_x, acc_y]", 25, "acc_z missing beside"),
    ("        find: still\n", "", 23, "find: is missing"),
    ("[1, 2, 3]", "[1, 2, x]", 29, "found 'x', expected a number"),
    ("unit: m/s² per °C²", "unit: 1", 31, "found 1, expected text; put it in quotes, as in '1'"),
    ("  mine:", "  bias:", 31, "'bias' cannot name a user-defined effect"),
    ("installation: {log: gyr/a.csv}", "installation:", 32, "nothing stands after 'installation:'"),
    ("poses: 18}", "poses: 7.5}", 33, "expected a whole number"),
    ("poses: 18}", "poses: 18,5}", 33, "'5' stands alone after a comma; a number has a decimal"),
    ("poses: 18}", "poses: 27}", 33, "expected a number of at most 26"),
    ("device: xsens-mti", "device: xsens", 33, "no device is named 'xsens' .did you mean 'xsens-m"),
    ("device: xsens-mti", "device: lines", 33, "pattern: is missing"),
    ("poses: 18}", "pattern: '{acc_x}'}", 33, "only for `device: lines`"),
    ("xsens-mti, port: COM3", "lines, pattern: '{acc_x},{acc_y}'", 33, "acc_z missing"),
    ("covariates: [temperature_c, supply_v]", "covariates: [temperature_c, null]", 34,
     "an entry of the list is empty"),
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
TWOFOLD = {"unit: deg_s", "{video: clip.mp4, rate_rad_s", "  bias:"}


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


def test_of_many_mistakes_of_one_kind_the_first_are_listed_and_the_rest_is_counted(
    session: Path,
) -> None:
    files = ", ".join(f"none_{i}.csv" for i in range(1000))
    runs = "".join(f"    - {{poses: gone_{i}.csv, rate: slow}}\n" for i in range(15))
    effects = "".join(f"  e{i}: {{expression: time_s, per: axs, unit: '1'}}\n" for i in range(12))
    keys = "".join(f"colour_{i}: red\n" for i in range(13))
    text = (GOOD.replace("poses: acc/pose_*.csv", f"poses: [{files}]")
            .replace("  runs:\n", f"  runs:\n{runs}")
            .replace("effects:\n", f"effects:\n{effects}") + keys)
    paragraphs = problems(session, text)
    assert [sum(word in each for each in paragraphs) for word in (
        "none_", "gone_", "axs", "no key is named 'colour_")] == [SHOWN_ALIKE] * 4
    assert [each for each in paragraphs if "more" in each.split(": ")[2]] == [
        "config.yaml:16: accelerometer.poses: and 990 more of this kind.",
        "config.yaml:31: gyroscope.runs[10].poses: and 5 more of this kind.",
        "config.yaml:56: effects.e10.per: and 2 more of this kind.",
        "config.yaml:72: colour_10: and 3 more of this kind.",
    ]
    assert paragraphs.index("config.yaml:16: accelerometer.poses: and 990 more of this kind.") == (
        SHOWN_ALIKE), "the number stands after what is listed"
    assert len(paragraphs) == 4 * (SHOWN_ALIKE + 1)


def test_the_folder_is_looked_through_for_the_files_that_are_listed_only(
    session: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    looks = []

    def look(wrong: str, right: Iterable[str]) -> str:
        looks.append(wrong)
        return nearest_name(wrong, right)

    monkeypatch.setattr("pipeline.config.file_patterns.nearest_name", look)
    files = ", ".join(f"none_{i}.csv" for i in range(1000))
    problems(session, GOOD.replace("poses: acc/pose_*.csv", f"poses: [{files}]"))
    assert len(looks) == SHOWN_ALIKE


def test_a_duplicate_key_is_named_with_both_lines(session: Path) -> None:
    (found,) = problems(session, GOOD + "title: other\n")
    assert found.startswith("config.yaml:35: title: the key 'title' is given twice, first in "
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


def test_clips_must_pair_with_poses(session: Path) -> None:
    for i in range(3):
        (session / f"clip_{i}.mp4").touch()
    (found,) = problems(session, GOOD.replace("clip.mp4", "clip_*.mp4"))
    assert "'slow' has 3 clips for 2 poses" in found


def test_a_file_at_rest_and_on_the_plate_would_count_twice(session: Path) -> None:
    text = GOOD.replace("accelerometer:\n  poses: ", "accelerometer:\n  runs: [{poses: "
                        "'acc/pose_?.csv', rate: slow}]\n  poses: ", 1)
    (found,) = problems(session, text)
    assert "is in accelerometer.poses as well" in found
    assert "accelerometer.runs[0].poses: " in found
