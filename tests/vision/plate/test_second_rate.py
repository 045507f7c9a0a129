"""What turns about a plate's spindle at another rate is told from what errors of the view leave."""

import numpy as np
import pytest

from tests.vision.plate.test_rotation import TIME, WEIGHT, FloatArray, pattern, turned
from vision.plate.low_orders import ORDERS
from vision.plate.rotation import RotationSearch
from vision.plate.second_rate import left_by, turns_itself

PLATE = -3.5 * TIME  # rad


def seen(strips: FloatArray, plate_rad: FloatArray = PLATE) -> tuple[bool, float]:
    """Whether a second thing turns, and its rate, rad/s."""
    spectra = np.fft.rfft(strips, axis=2)[:, :, 1 : ORDERS + 1].transpose(2, 1, 0)
    left = left_by((spectra / strips.shape[2]).astype(np.complex64), plate_rad)
    rotation = RotationSearch(TIME).about(left, WEIGHT)
    lasts_s = float(np.ptp(TIME))
    return (turns_itself(rotation, lasts_s, plate_rad),
            float(rotation.angle_rad[-1]) / lasts_s)


def noise(rng: np.random.Generator, shape: tuple[int, ...]) -> FloatArray:
    return 0.2 * rng.standard_normal(shape)


@pytest.mark.parametrize("rate_rad_s", [-4.7, -2.6, 3.5, 0.9])
def test_a_faint_second_pattern_is_told_with_its_rate(rate_rad_s: float) -> None:
    """A third as strong as the plate, on rings of its own; the table stands."""
    rng = np.random.default_rng(3)
    label, record = pattern(rng), pattern(rng)
    label[3:], record[:3] = 0, 0
    strips = turned(record, PLATE) + turned(label, rate_rad_s * TIME) / 3 + 5 * pattern(rng)
    found, rate = seen(strips + noise(rng, strips.shape))
    assert found
    assert rate == pytest.approx(rate_rad_s, rel=0.02)


@pytest.mark.parametrize("seed", range(6))
def test_one_plate_has_no_second_rate(seed: int) -> None:
    """Seen with its axis off, which mixes neighbouring orders, and with angles that err."""
    rng = np.random.default_rng(seed)
    around = np.linspace(0, 2 * np.pi, 128, endpoint=False)
    skewed = 1 + 0.2 * np.cos(around - rng.uniform(0, 6))
    strips = turned(pattern(rng), PLATE) * skewed + pattern(rng)
    erring = PLATE + 0.02 * np.sin(2 * PLATE)
    assert not seen(strips + noise(rng, strips.shape), erring)[0]


def test_a_light_that_flickers_is_no_second_thing() -> None:
    rng = np.random.default_rng(4)
    strips = turned(pattern(rng), PLATE)
    strips += np.sin(7 * TIME)[:, None, None] * pattern(rng) + noise(rng, strips.shape)
    assert not seen(strips)[0]
