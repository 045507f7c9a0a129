"""The shipped JSON Schema is that of the program, and what the program writes fulfils it."""

import copy
import json

import jsonschema
import pytest

from pipeline.results.schema.file import results_file
from tests.pipeline.conftest import RunSession
from tests.pipeline.results.json_schema import SCHEMA, schema_text
from tests.sessions import results_in

VALIDATOR = jsonschema.Draft202012Validator


def test_the_shipped_schema_is_written_from_the_declarations() -> None:
    assert SCHEMA.read_text(encoding="utf-8") == schema_text(), (
        "python -m tests.pipeline.results.json_schema writes it anew")


def test_real_results_are_valid(finished: RunSession) -> None:
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    VALIDATOR.check_schema(schema)
    VALIDATOR(schema).validate(results_in(finished.folder))


@pytest.mark.parametrize(("place", "value"), [
    (("format",), 2), (("title",), 3), (("accelerometer", "chi2"), -1.0),
    (("accelerometer", "parameters", "bias_counts"), [1.0, 2.0]),
    (("rate", "17rpm", "direction"), "left"), (("gyroscope", "poses"), []),
])
def test_what_is_wrong_is_wrong_by_both(
    finished: RunSession, place: tuple[str, ...], value: object
) -> None:
    results = copy.deepcopy(results_in(finished.folder))
    part = results
    for key in place[:-1]:
        part = part[key]
    part[place[-1]] = value
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    assert not VALIDATOR(schema).is_valid(results)
    with pytest.raises(ValueError, match=place[-1]):
        results_file().parsed(results)
