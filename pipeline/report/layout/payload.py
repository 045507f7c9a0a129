"""What the page's script works on, as JSON inside the page.

Columns of numbers make up most of a page. They are rounded to seven digits, as many as a number of
32 bits has, and stand in the page as such numbers (little-endian, base64): half as long as text.
"""

import base64
import json
from collections.abc import Iterable
from typing import Any

import numpy as np

from pipeline.results.json_values import Json

DIGITS = 7  #: digits that a number of 32 bits has
SHORTEST = 8  #: numbers; a shorter list is no shorter when packed


def script_json(payload: Json) -> str:
    """JSON that can stand inside a script element: no text in it ends the element."""
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
