"""results.json is declared once: the declaration, the page about it and the file agree."""

import copy
import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import UnreadableInput
from pipeline.export.certificate import certificate_content
from pipeline.export.write import EXPORTERS
from pipeline.results.read import load_results
from pipeline.results.schema.file import results_file
from tests.pipeline.conftest import RunSession
from tests.pipeline.results.results_page import PAGE, page
from tests.sessions import pipeline, results_in

#: What a hand may write for a value; a number that is only another number is a case of its own.
WRONG = st.one_of(
    st.none(), st.booleans(), st.text(max_size=5), st.integers(-(10**400), -(10**300)),
    st.sampled_from([float("nan"), float("inf"), -1e308, 1e400]), st.just([]), st.just({}),
    st.lists(st.integers(), max_size=4), st.just([[["deep"]]]),
)


def undeclared(there: Any, declared: Any, path: str = "") -> list[str]:
    """Keys that the file has and the declaration has not."""
    if isinstance(there, dict):
        lacking = [f"{path}.{key}" for key in there if key not in declared]
        return lacking + [each for key in there if key in declared
                          for each in undeclared(there[key], declared[key], f"{path}.{key}")]
    if isinstance(there, list):
        return [each for a, b in zip(there, declared, strict=True)
                for each in undeclared(a, b, f"{path}[]")]
    return []


def test_every_key_of_a_run_s_results_is_declared(finished: RunSession) -> None:
    there = results_in(finished.folder)
    declared = results_file().model_validate(there).model_dump(by_alias=True)
    assert undeclared(there, declared) == []


def test_the_page_is_that_of_the_declarations() -> None:
    """Write it anew with `python -m tests.pipeline.results.results_page`."""
    assert PAGE.read_text(encoding="utf-8") == page()


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Every place in a JSON value."""
    items = (value.items() if isinstance(value, dict)
             else enumerate(value[:2]) if isinstance(value, list) else ())
    return [path] * bool(path) + [each for key, child in items
                                  for each in places(child, (*path, key))]


@settings(max_examples=80, deadline=None)
@given(data=st.data())
def test_an_edited_file_is_refused_or_every_command_goes_through(
    finished: RunSession, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    edited = copy.deepcopy(results_in(finished.folder))
    for _ in range(data.draw(st.integers(1, 2))):
        where = data.draw(st.sampled_from(places(edited)))
        inside = edited
        for key in where[:-1]:
            inside = inside[key]
        if data.draw(st.booleans()):
            inside[where[-1]] = copy.deepcopy(data.draw(WRONG))
        else:
            del inside[where[-1]]
    folder = tmp_path_factory.mktemp("edited")
    (folder / "results.json").write_text(json.dumps(edited), encoding="utf-8")
    try:
        stored = load_results(folder)
    except UnreadableInput:
        return
    certificate_content(stored)  # drawn, with hostile names, in the certificate's own tests
    for form, exporter in EXPORTERS.items():
        if form != "certificate":
            exporter(stored)


def edited(finished: RunSession, folder: Path, *where: Any, value: Any) -> Path:
    """The results with one value replaced."""
    contents = results_in(finished.folder)
    inside = contents
    for key in where[:-1]:
        inside = inside[key]
    inside[where[-1]] = value
    (folder / "results.json").write_text(json.dumps(contents), encoding="utf-8")
    return folder


@pytest.mark.parametrize("key", ["misalignment_rad", "bias_counts", "scale_counts_per_unit"])
def test_a_parameter_edited_by_hand_contradicts_the_correction(
    finished: RunSession, tmp_path: Path, key: str, capsys: pytest.CaptureFixture[str]
) -> None:
    values = [*results_in(finished.folder)["gyroscope"]["parameters"][key]]
    values[1] *= 1.01
    folder = edited(finished, tmp_path, "gyroscope", "parameters", key, value=values)
    assert pipeline("export", folder, "--to", "json") == 3
    assert f"gyroscope.parameters.{key} is not that of correction.theta" in capsys.readouterr().err


@pytest.mark.parametrize(("text", "problem"), [
    ("", "is not JSON"), ("[" * 100_000, "is not JSON"), ("{}", "format None found"),
    ('{"format": 1}', "title: Field required"), ("\xff", "is not JSON"),
    ('{"format": true}', "title: Field required"), ("NaN", "format None found"),
])
def test_what_is_no_results_file_is_said(
    tmp_path: Path, text: str, problem: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "results.json").write_text(text, encoding="latin-1")
    assert pipeline("apply", tmp_path, "log.csv") == 3
    assert problem in capsys.readouterr().err
