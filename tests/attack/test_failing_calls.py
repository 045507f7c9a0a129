"""A small draw of ``tests.bench.failing_calls``: a fault of the machine at any call."""

from pathlib import Path

import pytest

from tests.attack.failing import COMMANDS, Fault, calls_of, complaints, draws

FIRST_SEED = 730_000  #: used by no bench
OF_OTHER_WRITES = [command for command in COMMANDS if not command.startswith("remove")]
"""All commands but the one that writes as ``add`` does."""


@pytest.mark.filterwarnings(  # a generator that is given up has nobody to tell
    "ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("fault", ["memory", "read"])
@pytest.mark.parametrize("command", OF_OTHER_WRITES)
def test_a_fault_at_any_call_is_said_and_leaves_all_or_nothing(
    prepared_alone: Path, tmp_path: Path, command: str, fault: Fault,
    capsys: pytest.CaptureFixture[str]
) -> None:
    calls, whole = calls_of(command, fault, prepared_alone, tmp_path / "whole")
    capsys.readouterr()
    (at,) = draws(calls, 1, FIRST_SEED)
    assert complaints(command, fault, at, prepared_alone, tmp_path / "failing", whole,
                      capsys.readouterr) == []
