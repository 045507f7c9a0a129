"""Choice among the tracks of a clip by several methods, and the refusal if there is none."""

from functools import reduce
from pathlib import Path
from typing import TYPE_CHECKING, TypeGuard

from vision.errors import EqualReturns, NoPlate, OnlyShifts, RateRefused, more_telling
from vision.numbers import FASTEST_USUAL
from vision.rate.checks import LEAST_TURNS, MOSTLY, SCATTERED_RAD
from vision.rate.slow_camera import frame_times

if TYPE_CHECKING:
    from vision.phase_track import PhaseTrack


#: Largest scatter over the least one at which a plate by its template precedes one by the return of
#: the picture. Tuned on ``tests.bench.clip_study --only pulldown``.
CLEARLY = 1.5


def best_track(name: str, tracks: "list[PhaseTrack | RateRefused]") -> "PhaseTrack":
    """The most even track; without one a refusal that says what was seen."""
    turning = [track for track in tracks if has_turns(track)]
    no_turn = next((each for each in tracks if isinstance(each, OnlyShifts | EqualReturns)), None)
    if no_turn is not None:
        turning = [track for track in turning if is_explained(track)
                   and not frame_times(track, track.time_s).leaps]
    turning = [track for track in turning if is_even(track)] or turning
    if turning:
        # If the times scatter and not the angles, all tracks scatter equally.
        allowed = CLEARLY * min(map(_scatter_rad, turning))
        return next(track for track in turning if _scatter_rad(track) <= allowed)
    refusals = [track for track in tracks if isinstance(track, RateRefused)]
    returned = next(
        (each for each in refusals if each.returns is not None or each is no_turn), None)
    if returned is not None:
        raise _only_returns(name, returned)
    still = [track for track in tracks if not isinstance(track, RateRefused)]
    if still:
        return still[0]
    seen = next((each for each in reversed(refusals) if isinstance(each, NoPlate)), None)
    telling = reduce(more_telling, refusals)
    if seen is None or isinstance(telling, NoPlate):
        raise telling
    more = str(telling).removeprefix(f"{name}: ")
    raise NoPlate(f"{name}: {seen}. {more[:1].upper()}{more[1:]}")


def _only_returns(name: str, refusal: RateRefused) -> RateRefused:
    """A refusal with advice if the picture returns, or moves as a whole, without a plate."""
    if isinstance(refusal, NoPlate):
        advice = "Film the whole plate from above and from a stand, with nothing else that moves."
        if isinstance(refusal, EqualReturns):
            advice = "Put one mark on it that differs (paper, tape) and film again."
        return type(refusal)(f"{name}: {refusal}. {advice}", returns=refusal.returns)
    assert refusal.returns is not None
    rate = refusal.returns.rate_rad_s
    sd = rate * refusal.returns.sd_s / refusal.returns.period_s
    state = (
        f"where it makes one turn in that time, not several, and this rate will do, state it in "
        f"a configuration (rate: {{{Path(name).stem}: {{rate_rad_s: {rate:.4f}, sd_rad_s: {sd:.1g}"
        f"}}}}).")
    if rate > FASTEST_USUAL:
        state = "no record player turns once in so short a time (blades, spokes, a lamp)."
    return RateRefused(f"{name}: {refusal}. Film the whole plate from above, with one bold mark "
                       f"near its rim; {state}", returns=refusal.returns)


def has_turns(result: "PhaseTrack | RateRefused") -> "TypeGuard[PhaseTrack]":
    """Whether a tracked plate turns far enough for a rate."""
    if isinstance(result, RateRefused):
        return False
    return result.apparent_turns * result.plate.symmetry >= LEAST_TURNS


def is_even(result: "PhaseTrack | RateRefused") -> "TypeGuard[PhaseTrack]":
    """Whether a tracked plate turns far enough for a rate, and its angle does not leap."""
    return has_turns(result) and not frame_times(result, result.time_s).leaps


def is_explained(result: "PhaseTrack | RateRefused") -> bool:
    """Whether rotation explains most of what varies in a tracked plate, at whatever rate."""
    return not isinstance(result, RateRefused) and result.plate.explained > MOSTLY


def is_good(result: "PhaseTrack | RateRefused | None") -> "TypeGuard[PhaseTrack]":
    """Whether a plate was tracked well enough to try no other method."""
    return result is not None and is_even(result) and _scatter_rad(result) < SCATTERED_RAD


def _scatter_rad(track: "PhaseTrack") -> float:
    """Scatter of the angles about an even rotation, with a slow camera taken into account."""
    return frame_times(track, track.time_s).scatter_rad
