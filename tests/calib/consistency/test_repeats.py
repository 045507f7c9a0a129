"""Samples that occur twice are told from logs whose converter has few levels."""

import numpy as np
import pytest

from calib.consistency.repeats import find_copy
from calib.poses.imu_log import FloatArray, ImuLog

ROWS = 3000


def log(gyroscope: FloatArray, label: str = "log") -> ImuLog:
    rows = len(gyroscope)
    absent = np.full((rows, 3), np.nan)
    return ImuLog(label, np.arange(rows) / 100.0, absent, gyroscope)


def of_two_levels(seed: int) -> FloatArray:
    """A quiet gyroscope at a wide range: one axis between two levels, the others on one."""
    rng = np.random.default_rng(seed)
    counts = np.zeros((ROWS, 3))
    counts[:, 1] = rng.integers(2, size=ROWS)
    return counts


def noisy(seed: int, rows: int = ROWS) -> FloatArray:
    return np.round(20 * np.random.default_rng(seed).standard_normal((rows, 3)))


def coarse_and_slow(seed: int) -> FloatArray:
    """Noise correlated over ten rows, in steps of twice its size."""
    rng = np.random.default_rng(seed)
    white = rng.standard_normal((ROWS + 10, 3))
    slow = np.stack([np.convolve(column, np.ones(10) / np.sqrt(10), "valid")[:ROWS]
                     for column in white.T], axis=1)
    return np.round(slow / 2)


def whole_degrees_in_a_hand(seed: int, noise: float = 0.1) -> FloatArray:
    """Rests in which one axis is between two levels, and moves through hundreds of them."""
    rng = np.random.default_rng(seed)
    moves = np.repeat(np.arange(ROWS // 250) % 2, 250)[:, None] * rng.integers(-90, 90, (ROWS, 3))
    return moves + np.round([0.3, 0.5, 0.1] + noise * rng.standard_normal((ROWS, 3)))


def test_the_rests_of_a_coarse_gyroscope_are_no_copies() -> None:
    """Its moves, in which no row returns, say nothing of its rests, in which few levels do."""
    for seed in range(10):
        logs = [log(whole_degrees_in_a_hand(seed)), log(whole_degrees_in_a_hand(seed + 50))]
        assert find_copy(logs, "gyroscope") is None


def test_a_long_copy_in_a_coarse_log_is_found() -> None:
    one, other = whole_degrees_in_a_hand(1, 0.3), whole_degrees_in_a_hand(2, 0.3)
    other[1000:1240] = one[500:740]
    copy = find_copy([log(one), log(other)], "gyroscope")
    assert copy is not None
    assert 500 <= copy.first_start < 740
    assert copy.second_start == pytest.approx(copy.first_start + 500, abs=9)


def test_two_levels_that_take_turns_are_no_copy() -> None:
    """Without the rows that repeat the one before, A B A B has one bit a row by its levels."""
    for seed in range(10):
        assert find_copy([log(of_two_levels(seed)), log(of_two_levels(seed + 50))], "gyroscope"
                         ) is None


def test_a_coarse_converter_is_no_copy() -> None:
    for seed in range(10):
        logs = [log(coarse_and_slow(seed)), log(coarse_and_slow(seed + 50))]
        assert find_copy(logs, "gyroscope") is None


def test_a_copied_block_is_found_where_it_stands() -> None:
    one, other = noisy(1), noisy(2)
    other[500:700] = one[1000:1200]
    copy = find_copy([log(one), log(other)], "gyroscope")
    assert copy is not None
    assert (copy.first, copy.second, copy.first_start, copy.second_start, copy.count) == (
        0, 1, 1000, 500, 200)


def test_a_file_under_two_names_is_a_copy_of_the_whole() -> None:
    copy = find_copy([log(noisy(3)), log(noisy(4)), log(noisy(3))], "gyroscope")
    assert copy is not None
    assert (copy.first, copy.second, copy.count) == (0, 2, ROWS)


@pytest.mark.parametrize("count", [64, 300, ROWS])
def test_a_block_that_stands_in_two_logs_is_found_at_both_places(count: int) -> None:
    first, second = noisy(1), noisy(2)
    second[100 : 100 + count] = first[: len(second[100 : 100 + count])]
    copy = find_copy([log(first), log(second)], "gyroscope")
    assert copy is not None
    assert (copy.first, copy.second) == (0, 1)
    assert abs(copy.first_start - 0) <= 1
    assert abs(copy.second_start - 100) <= 1
    assert copy.count == pytest.approx(min(count, ROWS - 100), abs=2)


def test_a_block_too_short_to_count_is_no_copy() -> None:
    first, second = noisy(1), noisy(2)
    second[100:120] = first[:20]
    assert find_copy([log(first), log(second)], "gyroscope") is None


def test_no_logs_hold_no_copy() -> None:
    assert find_copy([], "gyroscope") is None
