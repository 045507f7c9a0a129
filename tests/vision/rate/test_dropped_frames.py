"""Pictures that a recorder lost without a word, and mismeasured ones that look like it."""

import numpy as np
import pytest

from tests.vision.phase_tracks import RPM, phase_track, steady
from vision.rate import unwrap as motion
from vision.rate.measure import measure_rate
from vision.rate.timebase import Timebase

CLOCK = Timebase(ppm=0.0)
NOISE = 4e-4


@pytest.mark.parametrize("shown", [(0.5,), (0.3, 0.7)])
def test_a_jump_that_an_encoder_spreads_over_some_pictures_is_counted(shown):
    """The pictures after the gap show the plate on its way."""
    time, angle = steady(33.3, fps=30)
    gone = np.arange(60, len(time) - 60, 90)
    keep = np.ones(len(time), bool)
    keep[gone] = False
    for later, part in enumerate(shown, start=1):
        angle[gone + later] -= (1 - part) * 33.3 * RPM / 30
    squeezed = time[: keep.sum()]
    rate = measure_rate(phase_track(squeezed, angle[keep], noise_rad=NOISE), timebase=CLOCK)
    assert rate.frames.dropped == len(gone)
    assert abs(rate.rate_rad_s / (33.3 * RPM) - 1) < 2e-5


def test_some_pictures_far_ahead_do_not_make_an_even_plate_unsteady():
    time, angle = steady(100.7, seconds=15, fps=120)
    angle[140:146] += np.radians([20, 26, 21, 14, 17, 7])
    rate = measure_rate(phase_track(time, angle, noise_rad=NOISE), timebase=CLOCK)
    assert rate.frames.dropped == 0
    assert abs(rate.rate_rad_s / (100.7 * RPM) - 1) < 1e-5
    assert np.ptp(motion.rate_history(rate.history.angle).rate_rad_s) < 1e-3 * rate.rate_rad_s
