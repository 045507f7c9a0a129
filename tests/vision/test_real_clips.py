"""Real clips from public sources, where they are at hand (never copied into the project)."""

from pathlib import Path

import numpy as np
import pytest

from tests.paths import SHARED
from vision.errors import RateRefused
from vision.rate.measure import measure_rate
from vision.rate.timebase import Timebase
from vision.tracking.track import track_phase

RPM = 2 * np.pi / 60


def recorded(name: str) -> Path:
    path = SHARED / name
    if not path.exists():
        pytest.skip(f"the real clip {name} is not at hand")
    return path


def test_an_oblique_record_label_turns_at_its_hand_counted_rate() -> None:
    path = recorded("real_video/turntable_33_perspective/recordplayer.mp4")
    rate = measure_rate(track_phase(path), timebase=Timebase())
    assert rate.rate_rad_s / RPM == pytest.approx(33.68, abs=0.03)
    assert rate.direction == "cw"
    lag = rate.cross_checks.lag
    assert lag is not None
    assert abs(lag.rate_rad_s / rate.rate_rad_s - 1) < 2 * lag.sd_s / lag.period_s


def test_a_coasting_disc_has_no_constant_rate_but_a_history() -> None:
    path = recorded("real_video/physlab_disc/R1.MP4")
    with pytest.raises(RateRefused, match="slows down") as refused:
        measure_rate(track_phase(path), timebase=Timebase())
    history = refused.value.history
    assert history is not None
    angle = history.angle
    seen = angle.without((angle.index < 110) | (angle.index > 1177))
    turns = abs(seen.angle_rad[-1] - seen.angle_rad[0]) / (2 * np.pi)
    assert turns == pytest.approx(9.10, abs=0.02)
    assert np.degrees(history.phase_noise_rad) <= 0.02


@pytest.mark.parametrize(
    ("name", "seen"),
    [
        # Its silhouette comes again after 5.16 frames, four times of which are nearly whole ones.
        ("negative_vortex_blade/BladeExample.MP4", r"every 0\.688 s .* equal marks"),
        ("negative_carom_pucks/Rotation.MP4", "nothing in the frame turns about a fixed axis"),
    ],
)
def test_what_is_no_whole_plate_gives_no_number(name: str, seen: str) -> None:
    with pytest.raises(RateRefused, match=seen):
        measure_rate(track_phase(recorded(f"real_video/{name}")), timebase=Timebase())


def test_half_a_plate_seen_almost_edge_on_is_measured_in_all_its_frames() -> None:
    """The autocorrelation of the label gives 33.41 to 33.43 rpm."""
    path = recorded("real_video/turntable_33_grazing/turntable.mp4")
    rate = measure_rate(track_phase(path), timebase=Timebase())
    assert rate.rate_rad_s / RPM == pytest.approx(33.42, abs=0.03)
    assert rate.direction == "cw"
    assert rate.revolutions > 7.5
    assert any("by the return of the picture" in warning for warning in rate.warnings)


@pytest.mark.parametrize("name", ["a/video/17rpm.mp4", "b/video/m33rpm.mp4"])
def test_bench_clips_agree_with_counted_frames(name: str) -> None:
    rate = measure_rate(track_phase(recorded(f"bench/{name}")), timebase=Timebase())
    count = rate.cross_checks.frame_count
    assert count is not None
    assert abs(count.rate_rad_s - rate.rate_rad_s) < 3 * count.sd_rad_s
    assert rate.uncertainty.image_rad_s / rate.rate_rad_s < 2e-6
    assert rate.direction == ("cw" if "m33" in name else "ccw")
