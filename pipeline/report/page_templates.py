"""The templates of the page, compiled once: their bytecode is kept as Python keeps its modules'.

It stands in the ``__pycache__`` beside this module, or where ``PYTHONPYCACHEPREFIX`` says, and not
at all where Python writes no bytecode. A template that changed is compiled anew; where nothing can
be written, every run compiles.
"""

import sys
from functools import cache
from importlib.machinery import SourceFileLoader
from importlib.util import cache_from_source
from pathlib import Path
from pickle import UnpicklingError
from typing import Any

from jinja2 import BytecodeCache, Environment, PackageLoader, StrictUndefined
from jinja2.bccache import Bucket

from pipeline.report.glossary import with_terms

OPTIONS: dict[str, Any] = {
    "autoescape": True, "undefined": StrictUndefined, "trim_blocks": True, "lstrip_blocks": True,
}


class BytecodeBesideModules(BytecodeCache):
    """Compiled templates under the rules of Python's own bytecode."""

    def get_source_checksum(self, source: str) -> str:
        """Checksum of the template and of the options that it is compiled with."""
        return super().get_source_checksum(f"{OPTIONS}{source}")

    def load_bytecode(self, bucket: Bucket) -> None:
        """Fill ``bucket`` if its template was compiled before and has not changed."""
        try:
            bucket.bytecode_from_string(_path(bucket).read_bytes())
        except (OSError, EOFError, UnpicklingError):
            bucket.reset()  # not there, or not whole

    def dump_bytecode(self, bucket: Bucket) -> None:
        """Keep what was compiled, whole or not at all; a folder that refuses it is no error."""
        if not sys.dont_write_bytecode:
            path = str(_path(bucket))
            SourceFileLoader(__name__, path).set_data(path, bucket.bytecode_to_string())


def _path(bucket: Bucket) -> Path:
    return Path(cache_from_source(str(Path(__file__).with_name(f"template-{bucket.key}.py"))))


@cache
def page_templates() -> Environment:
    """The environment that the page and its parts are rendered in."""
    environment = Environment(
        loader=PackageLoader("pipeline.report", "templates"),
        bytecode_cache=BytecodeBesideModules(), **OPTIONS,
    )
    environment.filters["terms"] = with_terms
    return environment
