"""The page of thresholds lists every number that decides, as the code has it."""

import dataclasses
import re
from collections.abc import Iterator
from importlib import import_module

import pytest

from calib.diagnosis.constants import CONSTANTS
from tests.paths import DATA
from tests.thresholds import ORIGIN, thresholds, written

PAGE = (DATA / "docs/thresholds.md").read_text(encoding="utf-8")


def rows(text: str) -> Iterator[list[str]]:
    """The cells of each row of each table."""
    for line in text.splitlines():
        if line.startswith("| ") and not line.startswith("|--"):
            yield [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]


def section(title: str) -> str:
    """What stands under a heading."""
    return PAGE.partition(f"\n## {title}\n")[2].partition("\n## ")[0]


LISTED = {cells[0]: cells for cells in rows(PAGE)}


def test_what_decides_in_calib_stands_on_the_page() -> None:
    """With its value and what the code says of it; a number that decides nothing says so there."""
    expected = [" | ".join(each.cells) for each in thresholds("calib")]
    assert len(expected) > 100
    listed = {" | ".join(cells[:3]) for cells in LISTED.values()}
    assert [row for row in expected if row not in listed] == []


def test_what_decides_in_calib_says_where_it_comes_from() -> None:
    assert [each.path for each in thresholds("calib") if not ORIGIN.search(each.description)] == []


def test_what_the_page_lists_is_in_the_code_and_has_its_value() -> None:
    """Rows that name a module and a constant of it, also those of the pipeline."""
    in_code = {each.cells[0]: each.cells[1] for package in ("calib", "pipeline")
               for each in thresholds(package)}
    listed = {name: cells[1] for name, cells in LISTED.items()
              if re.fullmatch(r"`(\w+\.)+[A-Z_0-9]+`", name)}
    assert listed == {name: in_code.get(name) for name in listed}


def test_the_constants_of_the_diagnosis_stand_on_the_page_with_their_values() -> None:
    listed = {cells[0].strip("`"): cells[1] for cells in rows(section("Diagnosis"))}
    for field in dataclasses.fields(CONSTANTS):
        assert listed[field.name] == written(getattr(CONSTANTS, field.name))


def test_values_of_the_rate_are_those_of_its_modules() -> None:
    """Rows that name a constant, and its module behind it."""
    listed = [(re.fullmatch(r"`(\w+)` of `(vision\.[\w.]+)`", cells[0]), cells[1])
              for cells in rows(section("Rate"))]
    named = [(row[2], row[1], value) for row, value in listed if row]
    assert len(named) > 40
    assert [each for each in named if written(getattr(import_module(each[0]), each[1])) != each[2]
            ] == []


@pytest.mark.parametrize("title", re.findall(r"^### `(vision\.[\w.]+)`$", PAGE, re.M))
def test_values_of_the_vision_stage_are_those_of_its_modules(title: str) -> None:
    module = import_module(title)
    text = PAGE.partition(f"### `{title}`\n")[2].partition("\n#")[0]
    for name, value, *_ in rows(text):
        if name not in ("threshold",):
            assert float(value) == pytest.approx(getattr(module, name), rel=1e-3), name
