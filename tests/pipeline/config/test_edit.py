"""Names put into a model and taken out of it, as a person edits a file."""

import re
from pathlib import Path

import pytest
import yaml

from pipeline.config.edit import add_item, extend_list, remove_item
from pipeline.config.yaml_text import parse_source

BASE = ("bias", "scale", "misalignment")
GYRO = ("gyroscope",)

FLOW = """\
# The gyro of the rover.
gyroscope:   # on the plate
  runs:
    - {poses: a_*.csv, rate: slow}
  model: [bias, scale, misalignment]  # nine parameters
  solver: default
"""
BLOCK = """\
gyroscope:
  model:
    - bias      # zero offset
    - scale
    - misalignment  # axes
  runs: [{poses: a_*.csv, rate: slow}]
"""
NONE = """\
# kept
gyroscope:
  # the runs
  runs: [{poses: a_*.csv, rate: slow}]
title: x
"""
FLOW_SECTION = "gyroscope: {runs: [{poses: a, rate: b}]}  # short\n"
LAYOUTS = {"flow": FLOW, "block": BLOCK, "none": NONE, "flow section": FLOW_SECTION}


def edited(text: str, name: str, remove: bool = False) -> str:
    source = parse_source(Path("config.yaml"), text)
    if remove:
        return remove_item(source, GYRO, name).text
    return add_item(source, GYRO, name, BASE).text


@pytest.mark.parametrize("layout", LAYOUTS)
def test_an_added_name_stands_last_and_all_else_means_the_same(layout: str) -> None:
    text = LAYOUTS[layout]
    after = yaml.safe_load(edited(text, "cubic"))
    expected = yaml.safe_load(text)
    expected["gyroscope"]["model"] = [*BASE, "cubic"]
    assert after == expected


@pytest.mark.parametrize("layout", LAYOUTS)
def test_comments_and_order_stay(layout: str) -> None:
    text = LAYOUTS[layout]
    after = edited(text, "cubic")
    assert re.findall("#.*", after) == re.findall("#.*", text)
    kept = [line for line in text.splitlines() if "model" not in line and "{runs" not in line]
    assert [line for line in after.splitlines() if line in kept] == kept


@pytest.mark.parametrize("layout", ["flow", "block"])
@pytest.mark.parametrize("name", ["cubic", "column:supply_v"])
def test_taking_out_what_was_put_in_gives_the_same_bytes(layout: str, name: str) -> None:
    text = LAYOUTS[layout]
    once = edited(text, name)
    twice = edited(once, "hysteresis")
    assert edited(edited(twice, "hysteresis", remove=True), name, remove=True) == text
    middle = edited(twice, name, remove=True)
    assert yaml.safe_load(middle)["gyroscope"]["model"] == [*BASE, "hysteresis"]


@pytest.mark.parametrize("layout", ["flow", "block"])
@pytest.mark.parametrize("name", BASE)
def test_any_name_can_be_taken_out(layout: str, name: str) -> None:
    after = yaml.safe_load(edited(LAYOUTS[layout], name, remove=True))
    assert after["gyroscope"]["model"] == [each for each in BASE if each != name]


def test_only_the_characters_of_the_name_change_in_a_flow_list() -> None:
    expected = FLOW.replace("misalignment]", "misalignment, cubic]")
    assert edited(FLOW, "cubic") == expected


def test_a_new_line_of_a_block_list_stands_under_the_others() -> None:
    expected = BLOCK.replace("- misalignment  # axes\n", "- misalignment  # axes\n    - cubic\n")
    assert edited(BLOCK, "cubic") == expected


def test_an_empty_list_is_filled_from_the_default() -> None:
    text = FLOW.replace("[bias, scale, misalignment]", "[]")
    assert yaml.safe_load(edited(text, "cubic"))["gyroscope"]["model"] == [*BASE, "cubic"]


@pytest.mark.parametrize("text", [
    "a:\n  poses: x_*.csv  # kept\n",
    "a:\n  poses: [x_*.csv]  # kept\n",
    "a:\n  poses:\n    - x_*.csv  # kept\n",
    "a: {poses: x_*.csv}  # kept\n",
])
def test_a_list_of_files_grows_in_its_own_layout(text: str) -> None:
    after = extend_list(parse_source(Path("c.yaml"), text), ("a", "poses"), ["new/y.csv", '"é z"'])
    assert after.values == {"a": {"poses": ["x_*.csv", "new/y.csv", "é z"]}}
    assert yaml.safe_load(after.text) == after.values
    assert "# kept" in after.text
