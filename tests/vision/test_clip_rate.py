"""The whole way in one call."""

from pathlib import Path

import numpy as np
import pytest

import vision
import vision.clip_rate
from tests.vision.phase_tracks import RPM, phase_track
from vision.errors import RateRefused


@pytest.fixture
def two_speeds(monkeypatch: pytest.MonkeyPatch) -> Path:
    """A clip whose plate goes at 33 rpm for 20 s and at 45 rpm for 20 s."""
    time = np.arange(600) / 15
    angle = 33 * RPM * np.minimum(time, 20) + 45 * RPM * np.maximum(time - 20, 0)
    track = phase_track(time, angle, noise_rad=4e-4)
    monkeypatch.setattr(vision.clip_rate, "track_phase", lambda clip: track)
    return Path("made.mp4")


@pytest.mark.parametrize(("part", "rpm"), [((None, 19.0), 33.0), ((21.0, None), 45.0),
                                           ((22.0, 38.0), 45.0)])
def test_the_part_that_is_stated_is_measured(
    two_speeds: Path, part: tuple[float | None, float | None], rpm: float
) -> None:
    rate = vision.measure_rate(two_speeds, part=part)
    assert rate.rate_rad_s == pytest.approx(rpm * RPM, rel=1e-4)


def test_without_one_two_speeds_have_no_rate(two_speeds: Path) -> None:
    with pytest.raises(RateRefused, match="does not turn steadily"):
        vision.measure_rate(two_speeds)
