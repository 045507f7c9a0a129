"""data/docs/results.md, written from the declarations of results.json.

Run: python -m tests.pipeline.results.results_page
"""

from collections.abc import Iterator
from typing import Any

from calib.poses.imu_log import TRIADS
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.results.schema.file import results_file
from pipeline.results.schema.triad import TriadSection
from tests.paths import DATA

PAGE = DATA / "docs/results.md"
HEAD = """# results.json

`pipeline run` writes this file beside the report. All values are in SI units and radians unless the
key says otherwise. Arrays are in the order x, y, z. `null` stands for what was not determined. The
same input gives the same file, byte for byte.

`pipeline apply` and `pipeline export` check the whole file before they use it: every key below with
its type and range, that the parameters are those of the correction, and that a rotation is one. A
file that was edited by hand is refused with the first places that are wrong (exit code 3). Keys
that are not listed here are passed over.

[results.schema.json](results.schema.json) is the same as a JSON Schema (draft 2020-12) for other
programs. `format` changes when a key is removed or changes its meaning; new keys may come at any
time.

This page is written from the declarations in `pipeline/results/schema/`, and a test compares the
two. `NAME` stands for any name, `[]` for every item of an array.

| key | type | meaning |
|---|---|---|
"""
WORDS = {"number": "number", "integer": "whole number", "string": "text", "null": "null",
         "boolean": "true or false", "array": "array", "object": "mapping"}


def page() -> str:
    """The page's text."""
    schema = results_file().model_json_schema()
    rows = [f"| `{key}` | {kind} | {meaning} |" for key, kind, meaning in rows_of(schema, schema)
            if not listed_before(key)]
    return HEAD + "\n".join(rows) + "\n"


def listed_before(key: str) -> bool:
    """Whether a key of a further triad stands under the first two as well."""
    triad, _, rest = key.partition(".")
    return triad in TRIAD_KINDS and triad not in TRIADS and (
        rest.partition(".")[0].removesuffix("[]") in TriadSection.model_fields)


def rows_of(whole: Any, part: Any, before: str = "") -> Iterator[tuple[str, str, str]]:
    """Key, type and meaning of everything in a part of the schema."""
    for name, value in part["properties"].items():
        choices = [resolved(whole, each) for each in value.get("anyOf", [value])]
        kinds = [kind_of(each) for each in choices]
        yield before + name, " or ".join(dict.fromkeys(kinds)), value.get("description", "")
        for each in choices:
            inner, suffix = inside(whole, each)
            if "properties" in inner:
                yield from rows_of(whole, inner, f"{before}{name}{suffix}.")


def resolved(whole: Any, value: Any) -> Any:
    """What a reference refers to."""
    return whole["$defs"][value["$ref"].split("/")[-1]] if "$ref" in value else value


def inside(whole: Any, value: Any) -> tuple[Any, str]:
    """The mapping within arrays and mappings by name, and what the key has behind it."""
    if value.get("type") == "array" and "items" in value:
        inner, suffix = inside(whole, resolved(whole, value["items"]))
        return inner, f"[]{suffix}"
    if "additionalProperties" in value and isinstance(value["additionalProperties"], dict):
        inner, suffix = inside(whole, resolved(whole, value["additionalProperties"]))
        return inner, f".NAME{suffix}"
    return value, ""


def kind_of(value: Any) -> str:
    """A type in words."""
    if "enum" in value or "const" in value:
        return ", ".join(f"`{each}`" for each in value.get("enum", [value.get("const")]))
    if value.get("type") == "array" and value.get("minItems", 0) == value.get("maxItems"):
        return f"array of {value['minItems']}"
    return WORDS[value["type"]]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
