"""Rates that give the same frames.

Between two frames the plate may have made any number of additional turns (or, if it looks the same
S times per turn, of S-th parts of a turn) in either direction. With frames evenly spaced by Δt all
rates Ω + 2πm/(SΔt) look the same; uneven spacing separates them.
"""

from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from vision.errors import RateRefused
from vision.geometry import FloatArray
from vision.image_return import SAME_RETURN, ImageReturn
from vision.numbers import FASTEST_USUAL, RPM, median
from vision.phase_track import PhaseTrack
from vision.rate.unwrap import frame_time, stamped_in_pairs, usable

REACH = 3  # least number of listed aliases on either side
FRAME_RATES = (24, 25, 29.97, 60, 120, 240)  #: fact: of clips, per second


# Limits for aliases, and for their distance from the nominal rate.
WORSE = 0.5  #: relative excess over the smallest scatter of the steps that excludes an alias
NEAR_NOMINAL = 0.15
"""Relative difference beyond which a nominal rate does not choose. Fact: pitch controls usually
reach 8 %."""
FAR_FROM_NOMINAL = 0.02
"""Relative difference that justifies a warning. Fact: a drive without a pitch control keeps it."""
RETIMED_WITHIN = 0.01
"""Relative difference within which a ratio of frame rates is named. Derived: half the distance of
the nearest ratios, 24/30 and 25/30 (4 % apart), less one for the drive."""


@dataclass(frozen=True)
class Aliases:
    """All rates that give the same frames.

    Attributes
    ----------
    rates_rad_s : tuple of float
        Signed, positive counter-clockwise as filmed; the chosen one first.
    reason : str
        The reason for the choice.
    warnings : tuple of str
    """

    rates_rad_s: tuple[float, ...]
    reason: str
    warnings: tuple[str, ...]

    @property
    def chosen_rad_s(self) -> float:
        """The chosen rate, signed."""
        return self.rates_rad_s[0]

    def about(self, rate_rad_s: float) -> "Aliases":
        """The same aliases around the measured rate, signed, at the same distances from it."""
        shift = rate_rad_s - self.chosen_rad_s
        return replace(self, rates_rad_s=tuple(rate + shift for rate in self.rates_rad_s))


def list_aliases(
    track: PhaseTrack, time_s: FloatArray, rough_rad_s: float, nominal_rpm: float | None,
    returns: ImageReturn | None,
) -> Aliases:
    """List the rates that fit the frames and choose one.

    Parameters
    ----------
    track : PhaseTrack
    time_s : array, shape (f,)
        Times of every frame of the track, s.
    rough_rad_s : float
        The smallest rate, signed.
    nominal_rpm : float, optional
        Expected rate, turns per minute; the nearest rate is chosen.
    returns : ImageReturn or None
        Without a nominal rate, a plate of equal parts gets the rate after whose turns its picture
        returns: print on its label, a scratch.

    Raises
    ------
    RateRefused
        Nothing chooses among several rates.
    """
    good = np.flatnonzero(usable(track))
    step_s, step = np.diff(time_s[good]), np.diff(track.phase_rad[good])
    frame_s = frame_time(track, time_s)
    if stamped_in_pairs(track, time_s):
        step_s = np.full_like(step_s, frame_s)  # invalid stamps exclude no rate
    spacing = 2 * np.pi / (track.plate.symmetry * frame_s)
    wanted = (nominal_rpm or 0.0) * RPM
    if not wanted and track.plate.symmetry > 1 and returns is not None:
        wanted = returns.rate_rad_s
    # With many equal parts the nominal rate may be farther away.
    reach = max(REACH, int(np.ceil(wanted / spacing)))
    rates = rough_rad_s + spacing * np.arange(-reach, reach + 1)
    period = 2 * np.pi / track.plate.symmetry
    scatter = []
    for rate in rates:
        surprise = step - rate * step_s
        surprise -= period * np.round(surprise / period)
        scatter.append(float(median(np.abs(surprise - median(surprise)))))
    alike = rates[np.array(scatter) <= (1 + WORSE) * min(scatter) + 1e-9]
    alike = alike[np.argsort(np.abs(alike))]
    nearest = float(alike[np.argmin(np.abs(np.abs(alike) - wanted))])
    warnings: tuple[str, ...] = ()
    if nominal_rpm is None:
        # A plate nearly in step with the frames could turn equally fast the other way.
        told = int((np.abs(np.abs(alike) - wanted) < SAME_RETURN * wanted).sum()) == 1
        why = "the one is chosen after whose turns the picture returns"
    else:
        told = abs(abs(nearest) / RPM / nominal_rpm - 1) < NEAR_NOMINAL
        why = f"the nearest to nominal_rpm {nominal_rpm:g} is chosen"
    if not told:
        _require_one_usual(track, np.asarray(alike))
        why = "the smallest is chosen: no record player turns as fast as the others"
    chosen = nearest if told else float(alike[0])
    if nominal_rpm is not None:
        warnings = _against_nominal(track.source, chosen, nominal_rpm)
    others = tuple(float(rate) for rate in alike if rate != chosen)
    if not others:
        why = "the uneven spacing of the frames excludes every other rate"
    return Aliases((chosen, *others), why, warnings)


def _require_one_usual(track: PhaseTrack, alike: FloatArray) -> None:
    """Refuse rates (m,), smallest first, of which nothing chooses one.

    A plate that looks the same once per turn has the only rate of a record player among them, or
    one at which it turns by less than a quarter from frame to frame.
    """
    folds = track.plate.symmetry
    usual = int((np.abs(alike) < FASTEST_USUAL).sum())
    if len(alike) == 1 or (folds == 1 and usual < 2 and (usual or abs(alike[1] / alike[0]) > 3)):
        return
    cause, better = (
        (f"it looks the same {folds} times per turn", "put one mark of paper or tape on the plate")
        if folds > 1 else (
            "the frames are too few" if usual else
            "no record player turns as fast as the slowest of them",
            "film with more frames per second")
    )
    rates = ", ".join(f"{abs(rate) / RPM:.4g}" for rate in alike)
    raise RateRefused(
        f"{track.source}: what turns may turn at {rates} rpm, and gives the same frames at each: "
        f"{cause}. State the nominal rate (--nominal-rpm, or nominal_rpm), or {better}.")


def _against_nominal(source: str, rate_rad_s: float, nominal_rpm: float) -> tuple[str, ...]:
    ratio = abs(rate_rad_s) / RPM / nominal_rpm
    if abs(ratio - 1) < FAR_FROM_NOMINAL:
        return ()
    text = (
        f"{source}: the plate turns at {abs(rate_rad_s) / RPM:.4g} rpm by the time stamps, "
        f"nominal_rpm is {nominal_rpm:g}"
    )
    for stamped, filmed in permutations(FRAME_RATES, 2):
        if abs(ratio * filmed / stamped - 1) < RETIMED_WITHIN:
            return (
                f"{text}. The ratio {ratio:.4g} is that of a clip filmed at {filmed} frames per "
                f"second and stamped as {stamped}. If so, give the capture rate (--fps, or "
                f"timebase: {{source: constant, fps: ...}}).",
            )
    return (f"{text}. Check the speed of the deck and the frame rate of the clip.",)
