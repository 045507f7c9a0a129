import numpy as np
import pytest

from vision.numbers import median, quantile


@pytest.mark.parametrize("share", [0.0, 0.02, 0.5, 0.9, 1.0])
@pytest.mark.parametrize("axis", [None, 0, 1])
@pytest.mark.parametrize("shape", [(1, 1), (4, 7), (5, 6)])
def test_a_quantile_is_numpys(
    share: float, axis: int | None, shape: tuple[int, int]
) -> None:
    values = np.random.default_rng(0).normal(size=shape)
    expected = np.quantile(values, share, axis=axis)
    assert quantile(values, share, axis) == pytest.approx(expected, rel=1e-12)


def test_a_median_is_nan_where_a_value_is() -> None:
    values = np.array([[1.0, np.nan, 3.0], [1.0, 2.0, 6.0]])
    np.testing.assert_array_equal(median(values, axis=1), [np.nan, 2.0])


def test_nothing_has_no_median() -> None:
    assert np.isnan(median([]))
