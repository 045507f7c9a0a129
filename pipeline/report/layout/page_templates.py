"""The templates of the pages; what they compile to is kept where Python keeps that of its modules.

It stands in the ``__pycache__`` of this module, or where ``PYTHONPYCACHEPREFIX`` says. Where that
folder is not there or cannot be written, every run compiles, which takes 85 ms.
"""

import os
import sys
from functools import cache
from importlib.util import cache_from_source
from pathlib import Path
from pickle import UnpicklingError

from jinja2 import Environment, FileSystemBytecodeCache, PackageLoader, StrictUndefined
from jinja2.bccache import Bucket

from pipeline.report.layout.glossary import with_terms


class KeptTemplates(FileSystemBytecodeCache):
    """Compiled templates; a file that is not whole is made anew."""

    def load_bytecode(self, bucket: Bucket) -> None:
        """Fill ``bucket`` if its template was compiled before and has not changed."""
        try:
            super().load_bytecode(bucket)
        except (EOFError, UnpicklingError):
            bucket.reset()


@cache
def page_templates() -> Environment:
    """The environment that the pages and their parts are rendered in."""
    folder = Path(cache_from_source(__file__)).parent
    keeps = not sys.dont_write_bytecode and os.access(folder, os.W_OK)
    environment = Environment(
        loader=PackageLoader("pipeline.report", "templates"), autoescape=True,
        undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
        bytecode_cache=KeptTemplates(str(folder), "%s.template") if keeps else None)
    environment.filters["terms"] = with_terms
    return environment
