"""Transforms along the rings."""

import numpy as np
import pytest

from vision.plate.polar import ring_spectra, ring_strips, turns


@pytest.mark.parametrize("azimuths", [256, 1024])
def test_strips_and_their_spectra_are_inverse(azimuths: int) -> None:
    strips = np.random.default_rng(1000).normal(0, 30, (5, 4, azimuths)).astype(np.float32)
    spectra = ring_spectra(strips)
    assert spectra == pytest.approx(np.fft.rfft(strips), abs=2e-3)
    assert ring_strips(spectra, azimuths) == pytest.approx(strips, abs=1e-4)


def test_factors_that_turn_hold_after_many_turns() -> None:
    angle_rad = np.array([0.0, -0.3, 40.0, 700.0])
    exact = np.exp(1j * np.arange(513) * angle_rad[:, None])
    assert turns(angle_rad, 513)[:, 0] == pytest.approx(exact, abs=1e-6)
