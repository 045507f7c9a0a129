"""Where captured streams of real devices are, for the tests that use them."""

from pathlib import Path
from typing import TypeVar

import pytest

from pipeline.devices.sample import Parser
from tests.paths import SHARED

P = TypeVar("P", bound=Parser)
SERIAL = SHARED / "real_serial"


def captured(*parts: str) -> Path:
    """The path of a captured stream; the test is skipped where it is absent."""
    path = SERIAL.joinpath(*parts)
    if not path.exists():
        pytest.skip("the captured serial streams are not here")
    return path


def begun(parser: P) -> P:
    """A parser of lines that has heard the end of the line before, so that none is cut."""
    parser.feed(b"\n")
    return parser
