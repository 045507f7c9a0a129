"""Lines of any length are sorted by their manner in a time that grows with their length only."""

import time

import pytest

from pipeline.logs.labels import unlabelled_lines

LONG = 5000


@pytest.mark.parametrize("line", [
    "ab cd ", "1.25 -3.5 ", "1 2 | ", "1", " ", "a ", "a: ", "12:", "1,", "A", ".", "(", "1.25e",
])
def test_twice_the_length_takes_about_twice_the_time(line: str) -> None:
    """Where a pattern is tried at every start with every length, it takes four or eight times."""
    took = []
    for length in (LONG, 2 * LONG):
        lines = [(line * length)[:length] + end for end in ("", "|", " x", ")")]
        begun = time.process_time()
        assert len(unlabelled_lines(lines)) == len(lines)
        took.append(time.process_time() - begun)
    assert took[1] < 3.3 * took[0] + 0.05
