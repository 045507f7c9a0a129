"""Which of several tracks of a clip is believed, and what is said of a clip without one."""

from dataclasses import replace

import numpy as np
import pytest

from tests.vision.motor_tracks import motor_track
from tests.vision.phase_tracks import phase_track, steady
from vision.errors import EqualReturns, OnlyShifts, RateRefused
from vision.image_return import ImageReturn
from vision.tracking.best_track import best_track, is_good

TIME, ANGLE = steady(33.3, 10.0)


@pytest.mark.parametrize("refusal", [OnlyShifts("it passes by"), EqualReturns("blades")])
def test_a_plate_that_hardly_turns_is_not_believed_where_the_picture_shows_another_motion(
    refusal: RateRefused,
) -> None:
    track = phase_track(TIME, ANGLE, noise_rad=0.03)
    for explained, believed in ((0.25, False), (0.9, True), (np.nan, False)):
        shown = replace(track, plate=replace(track.plate, explained=explained))
        if believed:
            assert best_track("clip.mp4", [shown, refusal]) is shown
        else:
            with pytest.raises(type(refusal), match=str(refusal)):
                best_track("clip.mp4", [shown, refusal])
    from_mark_to_mark = phase_track(TIME, ANGLE + 2.5 * np.floor(TIME / 0.9))
    assert not is_good(from_mark_to_mark)
    with pytest.raises(type(refusal), match=str(refusal)):
        best_track("clip.mp4", [from_mark_to_mark, refusal])
    poor = replace(track, plate=replace(track.plate, explained=0.25))
    assert best_track("clip.mp4", [poor, RateRefused("nothing repeats")]) is poor


@pytest.mark.parametrize(("period_s", "offered"), [(1.8, True), (0.5, False)])
def test_the_rate_of_a_return_is_offered_where_a_record_player_turns_as_fast(
    period_s: float, *, offered: bool
) -> None:
    refusal = RateRefused("the picture repeats", returns=ImageReturn(period_s, 0.002, 9))
    with pytest.raises(RateRefused) as refused:
        best_track("clip.mp4", [refusal])
    said = str(refused.value)
    assert ("one turn in that time, not several," in said) == ("rate_rad_s" in said) == offered
    assert ("no record player turns once in so short a time" in said) != offered


def test_a_track_that_leaps_is_not_believed_beside_one_that_turns_on() -> None:
    """However little it scatters between the leaps."""
    leaping = phase_track(TIME, 0.05 * ANGLE + 3.0 * np.floor(TIME / 0.9))
    turning = phase_track(TIME, ANGLE, noise_rad=0.03)
    assert best_track("clip.mp4", [leaping, turning]) is turning
    assert best_track("clip.mp4", [leaping]) is leaping


@pytest.mark.parametrize("seed", range(12))
def test_a_start_or_a_stop_is_no_scatter_of_the_angles(seed: int) -> None:
    assert is_good(motor_track(np.random.default_rng(seed)).track)


def test_a_wrong_view_is_a_scatter_of_the_angles() -> None:
    for order in (3, 5):
        assert not is_good(phase_track(TIME, ANGLE + 0.04 * np.sin(order * ANGLE)))
