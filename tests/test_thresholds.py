"""The page of thresholds lists every number that decides, as the code has it."""

import dataclasses
import pkgutil
import re
from collections.abc import Iterator
from importlib import import_module

import pytest

from calib.diagnosis.constants import CONSTANTS
from calib.noise.stillness import STILLNESS
from tests.paths import DATA
from tests.thresholds import ORIGIN, thresholds, written
from vision import rate

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


@pytest.mark.parametrize(("title", "record"), [
    ("Diagnosis", CONSTANTS),
    ("Stillness of a log for `pipeline noise`", STILLNESS),
])
def test_a_record_of_thresholds_stands_on_the_page_with_its_values(
    title: str, record: object
) -> None:
    text = section(title)
    listed = {cells[0].strip("`"): cells[1] for cells in rows(text)}
    for field in dataclasses.fields(record):  # type: ignore[arg-type]
        assert listed[field.name] == written(getattr(record, field.name))


def test_values_of_the_rate_are_those_of_its_records() -> None:
    modules = [import_module(info.name)
               for info in pkgutil.iter_modules(rate.__path__, f"{rate.__name__}.")]
    records = {type(each).__name__: each for module in modules for each in vars(module).values()
               if type(each).__name__.endswith("Thresholds")}
    listed = [cells for cells in LISTED.values() if re.match(r"`\w+Thresholds\.", cells[0])]
    assert len(listed) > 30
    for cells in listed:
        record, field = cells[0].strip("`").split(".")
        if record in records:
            expected = getattr(records[record], field)
            assert float(cells[1]) == pytest.approx(expected, rel=5e-3), cells[0]


@pytest.mark.parametrize("title", re.findall(r"^### `(vision\.[\w.]+)`$", PAGE, re.M))
def test_values_of_the_vision_stage_are_those_of_its_records(title: str) -> None:
    module = import_module(title)
    fields = {field.name: getattr(each, field.name) for each in vars(module).values()
              if type(each).__name__.endswith("Thresholds") and dataclasses.is_dataclass(each)
              and not isinstance(each, type) for field in dataclasses.fields(each)}
    fields |= {name: value for name, value in vars(module).items() if name.isupper()}
    text = PAGE.partition(f"### `{title}`\n")[2].partition("\n#")[0]
    for name, value, *_ in rows(text):
        if name not in ("threshold",):
            assert float(value) == pytest.approx(fields[name], rel=1e-3), name
