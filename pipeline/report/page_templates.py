"""The templates of the pages, the terms that they explain, and the data of their scripts.

Every term is a link to its entry at the end of the page; the page's script shows the entry beside
the term for mouse, keyboard and touch.

It stands in the ``__pycache__`` of this module, or where ``PYTHONPYCACHEPREFIX`` says. Where that
folder is not there or cannot be written, every run compiles, which takes 85 ms.

Columns of numbers make up most of a page. They are rounded to seven digits, as many as a number of
32 bits has, and stand in the page as such numbers (little-endian, base64): half as long as text.
"""

import base64
import json
import os
import re
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from html import escape
from importlib.util import cache_from_source
from pathlib import Path
from pickle import UnpicklingError
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemBytecodeCache, PackageLoader, StrictUndefined
from jinja2.bccache import Bucket

from calib.diagnosis.verdict.explanation import SIGNS
from pipeline.results.json_values import Json


@dataclass(frozen=True)
class Term:
    """One entry: its key in links, its name, the words that link to it, and its meaning."""

    key: str
    name: str
    pattern: str
    meaning: str


TERMS = (
    Term("chi2-dof", "chi²/dof", r"chi²/dof",
         "chi² divided by the degrees of freedom. It is about 1 if the noise of the poses explains "
         "the residuals, and larger if the model misses something."),
    Term("chi2", "chi²", r"chi²(?!/dof)",
         "The sum of the squared residuals, each divided by its sd."),
    Term("dof", "degrees of freedom (dof)", r"degrees of freedom",
         "The number of equations minus the number of fitted parameters."),
    Term("p", "p", r"\bp(?= =| below)",
         "The probability that noise alone gives a chi² of this size or larger, if the model is "
         "right."),
    Term("loo", "leave-one-out error", r"leave-one-out",
         "The error of predictions: each pose is predicted from a fit to all other poses. If an "
         "effect reduces the residual but not this error, the model fits the noise."),
    Term("rms", "RMS", r"\bRMS\b", "Root mean square: the square root of the mean square."),
    Term("sd", "sd", r"\bsds?\b", "Standard deviation. The true value is within one sd of the "
         "stated value in 68 % of cases, and within two sds in 95 %."),
    Term("unit", "mm/s² and °/s", r"mm/s²|°/s",
         "Errors of the accelerometer are in mm/s² everywhere on this page, those of the gyroscope "
         "in °/s. Data sheets quote mg: 1 mg is 9.81 mm/s². The results file is in SI units."),
    Term("ppm", "ppm", r"\bppm\b", "Parts per million: 1000 ppm are 0.1 %."),
    Term("specific-force", "specific force", r"specific force",
         "What an accelerometer measures: acceleration minus gravity. At rest it points upwards "
         "and has the magnitude of gravity."),
    Term("misfit", "misfit", r"misfit", "The part of the residuals that noise does not explain."),
    Term("birge", "Birge ratio", r"Birge ratio",
         "The square root of chi²/dof. If the model does not explain the residuals, the stated sds "
         "are multiplied by this ratio."),
    Term("proof-mass", "proof mass", r"proof mass",
         "The small mass inside an inertial sensor whose motion the sensor measures."),
)
_CODE = re.compile(r"`([^`<]+)`")
_ANY = re.compile("|".join(f"(?P<t{i}>{term.pattern})" for i, term in enumerate(TERMS)))


def with_terms(text: str) -> str:
    """``text`` as HTML, escaped, with a link to the glossary at the first place of every term.

    Text between backticks is set as code.

    >>> with_terms("1 < 2 ppm")
    '1 &lt; 2 <a class="term" href="#term-ppm">ppm</a>'
    """
    linked: set[str] = set()

    def link(match: re.Match[str]) -> str:
        term = next(t for i, t in enumerate(TERMS) if match[f"t{i}"] is not None)
        if term.key in linked:
            return match[0]
        linked.add(term.key)
        return f'<a class="term" href="#term-{term.key}">{match[0]}</a>'

    return _CODE.sub(r"<code>\1</code>", _ANY.sub(link, escape(text)))


class KeptTemplates(FileSystemBytecodeCache):
    """Compiled templates; an incomplete file is compiled again."""

    def load_bytecode(self, bucket: Bucket) -> None:
        """Fill ``bucket`` if its template was compiled before and has not changed."""
        try:
            super().load_bytecode(bucket)
        except (EOFError, UnpicklingError):
            bucket.reset()


@cache
def page_templates() -> Environment:
    """The environment in which the pages and their parts are rendered."""
    folder = Path(cache_from_source(__file__)).parent
    keeps = not sys.dont_write_bytecode and os.access(folder, os.W_OK)
    environment = Environment(
        loader=PackageLoader("pipeline.report", "templates"), autoescape=True,
        undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
        bytecode_cache=KeptTemplates(str(folder), "%s.template") if keeps else None)
    environment.filters["terms"] = with_terms
    environment.globals["signs"] = SIGNS
    return environment


DIGITS = 7  #: digits that a number of 32 bits has
SHORTEST = 8  #: numbers; a shorter list gains nothing from packing


def script_json(payload: Json) -> str:
    """JSON that can be part of a script element: no text in it ends the element."""
    text = json.dumps(_packed(payload), separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return text.replace("<", "\\u003c")


def rounded(values: Iterable[float], digits: int = DIGITS) -> list[float]:
    """Numbers to so many significant digits, by default those that a number of 32 bits has."""
    return [float(f"{value:.{digits}g}") for value in values]


def _packed(value: Any) -> Any:
    """``value`` with every column of rounded numbers as ``{"f32": base64}``."""
    if isinstance(value, dict):
        return {key: _packed(one) for key, one in value.items()}
    if not isinstance(value, list):
        return value
    if len(value) >= SHORTEST and all(
            type(one) is float and float(f"{one:.{DIGITS}g}") == one for one in value):
        return {"f32": base64.b64encode(np.array(value, "<f4").tobytes()).decode("ascii")}
    return [_packed(one) for one in value]
