"""data/docs/results.schema.json, written from the declarations of results.json.

Run: python -m tests.pipeline.results.json_schema
"""

import json

from pipeline.results.schema import FORMAT
from pipeline.results.schema.file import results_file
from tests.paths import DATA

SCHEMA = DATA / "docs/results.schema.json"
DIALECT = "https://json-schema.org/draft/2020-12/schema"


def schema_text() -> str:
    """The schema, which names its dialect and the version of the format."""
    schema = {"$schema": DIALECT, **results_file().model_json_schema(), "title": "results.json",
              "description": f"results.json of `pipeline run`, format {FORMAT}."}
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    SCHEMA.write_text(schema_text(), encoding="utf-8")
