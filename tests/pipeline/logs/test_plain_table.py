"""Plain numbers read all at once are the numbers that the general parser reads."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.logs.plain_table import BLOCK_ROWS, read_plain


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_every_number_is_the_nearest_float_as_c_reads_it(data: st.DataObject) -> None:
    decimals = data.draw(st.lists(st.integers(0, 6), min_size=1, max_size=4))
    count = data.draw(st.integers(1, 6))
    cell = st.integers(-(10**9) + 1, 10**9 - 1)
    lines = [
        ",".join(f"{data.draw(cell) / 10**d:.{d}f}" for d in decimals) for _ in range(count)
    ]
    found = read_plain([*lines, ""], ",", len(decimals))
    assert found is not None
    assert np.array_equal(found, np.loadtxt(lines, delimiter=",", ndmin=2))


def test_blocks_join_without_a_seam() -> None:
    rows = np.arange(2 * BLOCK_ROWS + 5)
    lines = [f"{i / 100:.2f};{-i}" for i in rows]
    found = read_plain(lines, ";", 2)
    assert found is not None
    assert np.array_equal(found, np.column_stack([rows / 100, -rows]))


@pytest.mark.parametrize(
    "second",
    ["1.5,", "1.5,x", "1.5,nan", "1.5,+3", "1.5,1e3", "1.5, 3", "1.5,3 # end", "1.5", "1.5,3,4",
     "1.55,3", "15,3", "1.5,-", "1.5,1_0", ".5,3", "1.5,12345678901234567", "1.5,٣", "", "1.5,3.0",
     "-.5,3", "1-5,3", "1.5,--3", "1..5,3"],
)
def test_what_is_not_plain_is_left_to_the_general_parser(second: str) -> None:
    assert read_plain(["1.0,2", "2.5,3"], ",", 2) is not None
    assert read_plain(["1.0,2", second, "2.5,3"], ",", 2) is None


def test_blanks_between_columns_are_not_plain() -> None:
    assert read_plain(["1 2"], None, 2) is None
