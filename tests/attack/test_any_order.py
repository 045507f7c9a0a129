"""A small draw of commands in any order; ``tests.bench.failing_calls --any-order`` draws more."""

from pathlib import Path

from hypothesis import Phase

from tests.attack.any_order import run_in_any_order


def test_commands_in_any_order_leave_files_that_agree(prepared_alone: Path) -> None:
    run_in_any_order(prepared_alone, 4, 8, derandomize=True, phases=[Phase.generate])
