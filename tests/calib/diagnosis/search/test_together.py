"""Many computations at once: each gives its result, whenever it ends."""

import pytest

from calib.diagnosis.search import together
from calib.diagnosis.search.steps import Steps


def ends_at_once(value: int) -> Steps[int]:
    """A computation that asks for nothing."""
    yield from ()
    return value


def test_searches_that_ask_for_nothing_do_not_end_the_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With nothing to answer after the first that may be open, the rest was lost."""
    monkeypatch.setattr(together, "OPEN", 3)
    results = dict(together.in_turn(ends_at_once(2 * i) for i in range(8)))
    assert results == {i: 2 * i for i in range(8)}
