"""Where captured streams of real devices are, for the tests that use them."""

from pathlib import Path

import pytest

from tests.paths import SHARED

SERIAL = SHARED / "real_serial"


def captured(*parts: str) -> Path:
    """The path of a captured stream; the test is skipped where it is absent."""
    path = SERIAL.joinpath(*parts)
    if not path.exists():
        pytest.skip("the captured serial streams are not here")
    return path
