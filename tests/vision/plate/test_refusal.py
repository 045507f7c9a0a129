"""What a refusal tells the user to change first."""

import numpy as np
import pytest

from vision.errors import NothingMoves, RateRefused, more_telling
from vision.plate.refusal import why_nothing_moves, why_nothing_turns
from vision.plate.rotation import CoarseRotation

GREY = np.full((360, 480), 100, np.uint8)


@pytest.mark.parametrize(("light", "first"), [
    (100, "Check that the plate turns"), (20, "Switch on a light")])
def test_noise_hides_what_turns_in_a_dark_film(light: int, first: str) -> None:
    """Whether it turns cannot be asked yet."""
    seen = np.full_like(GREY, light)
    rotation = CoarseRotation(np.zeros(3), 0.16, slice(0, 3))
    assert first in why_nothing_moves([seen, seen], 0, None)
    assert first in why_nothing_turns([rotation], seen)
    assert "at most 16% of what changes" in why_nothing_turns([rotation], seen)
    assert "no round outline is seen in it. " in why_nothing_turns([], seen)


def test_a_light_that_is_switched_is_not_called_noise() -> None:
    said = why_nothing_moves([GREY, GREY + 40], 1, 1)
    assert "goes from 100 to 140 of 255" in said
    assert "noise" not in said
    assert "no more than the noise" in why_nothing_moves([GREY, GREY + 1], 1, None)
    assert "of 2 frames spread over the time 2 differ" in why_nothing_moves([GREY, GREY], 2, None)


def test_a_film_that_is_white_is_exposed_too_long() -> None:
    assert "Shorten the exposure" in why_nothing_moves([GREY + 135] * 2, 0, None)


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
