"""Films in which nothing moves, or no plate, in brightness or in colour."""

from dataclasses import replace

import numpy as np
import pytest

from vision.errors import NothingMoves
from vision.rate.measure import measure_rate
from vision.tracking.track import track_phase

pytest.importorskip("av", reason="rendering clips needs PyAV")

from tests.vision.phase_tracks import CLOCK
from tests.vision.rendered_clips import Render, error_ppm
from tests.world.plate import PlateMotion
from tests.world.scene import colour_scene


def test_a_plate_at_rest_is_refused_with_what_was_seen(render: Render) -> None:
    path, _ = render(PlateMotion(0.0), seconds=6, preset="veryfast")
    with pytest.raises(NothingMoves, match="no more than the noise of the camera"):
        track_phase(path)


def test_what_turns_only_in_colour_is_measured(render: Render) -> None:
    motion = PlateMotion(33.3 * 2 * np.pi / 60)
    path, _ = render(motion, colour_scene(np.random.default_rng(1000)), seconds=10)
    track = track_phase(path)
    assert track.plate.channel != "luma"
    assert abs(error_ppm(measure_rate(track, timebase=CLOCK), motion)) < 300


def test_a_hand_over_a_slow_plate_of_colours_does_not_refuse_a_short_clip(render: Render) -> None:
    """In brightness the hand alone moves; in 7.5 s nothing can return twice after 3.6 s each."""
    motion = PlateMotion(16.7 * 2 * np.pi / 60)
    scene = replace(colour_scene(np.random.default_rng(1000)), hand_until_s=3.0)
    path, _ = render(motion, scene, seconds=7.5)
    track = track_phase(path)
    assert track.plate.channel != "luma"
    rate = measure_rate(track, timebase=CLOCK)
    assert abs(error_ppm(rate, motion)) < 3e6 * rate.sd_rad_s / rate.rate_rad_s < 3000
