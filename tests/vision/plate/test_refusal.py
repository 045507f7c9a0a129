"""What a refusal tells the user to change first."""

import numpy as np
import pytest

from vision.errors import NothingMoves, RateRefused, more_telling
from vision.geometry import PlateView, view_of_ellipse
from vision.plate.refusal import why_nothing_moves, why_nothing_turns
from vision.plate.rotation import CoarseRotation

GREY = np.full((360, 480), 100, np.uint8)
WHOLE = view_of_ellipse((240.0, 180.0), (140.0, 130.0), 0.0)
CUT = view_of_ellipse((240.0, 180.0), (300.0, 290.0), 0.0)


def said(view: PlateView, coherence: float, *, light: int = 100, camera_stands: bool) -> str:
    rotation = CoarseRotation(np.zeros(3), coherence, 1.0, slice(0, 3))
    background = np.full_like(GREY, light)
    return why_nothing_turns([(view, rotation)], background, camera_stands=camera_stands)


@pytest.mark.parametrize(("view", "coherence", "light", "camera_stands", "first"), [
    (WHOLE, 0.2, 100, True, "Put a mark of paper or tape on the plate"),
    (WHOLE, 0.2, 100, False, "Fix the camera to a stand"),
    (WHOLE, 0.05, 100, True, "Put a mark of paper or tape on the plate"),
    (WHOLE, 0.2, 20, True, "Switch on a light"),
    (CUT, 0.2, 100, True, "Film the whole plate"),
])
def test_the_first_thing_to_change_is_what_is_wrong(
    view: PlateView, coherence: float, light: int, camera_stands: bool, first: str
) -> None:
    """A camera that stands still is not told to be fixed to a stand."""
    text = said(view, coherence, light=light, camera_stands=camera_stands)
    assert first in text
    assert ("stand" in first) == ("Fix the camera" in text)


def test_a_plate_at_rest_in_the_dark_is_told_of_the_light_first() -> None:
    """Noise hides what turns in a dark film: whether it turns cannot be asked yet."""
    assert "Switch on a light" in why_nothing_moves(np.full_like(GREY, 20))
    assert "Check that the plate turns" in why_nothing_moves(GREY)


def test_of_two_refusals_the_one_that_saw_something_is_told() -> None:
    still, moves = NothingMoves("a"), RateRefused("b")
    assert more_telling(None, still) is still
    assert more_telling(still, moves) is moves
    assert more_telling(moves, still) is moves
    assert more_telling(still, NothingMoves("c")) is still


def test_a_refusal_that_is_kept_holds_on_to_no_frames() -> None:
    """A traceback would, through the variables of the functions in it: hundreds of megabytes."""
    refusal: RateRefused | None = None
    for error in (NothingMoves("nothing moves"), RateRefused("nothing turns")):
        try:
            raise error
        except RateRefused as raised:
            refusal = more_telling(refusal, raised)
        assert refusal is error
        assert refusal.__traceback__ is None
