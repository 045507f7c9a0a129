"""Rates that give the same pictures.

Between two pictures the plate may have made any number of whole turns more (or, on a plate that
looks the same S times per turn, of S-th parts of a turn) in either direction. With pictures evenly
spaced by Δt all rates Ω + 2πm/(SΔt) look alike; uneven spacing tells them apart.
"""

from dataclasses import dataclass

import numpy as np

from vision.geometry import FloatArray
from vision.phase_track import PhaseTrack
from vision.rate.unwrap import frame_time, usable

REACH = 3  # aliases looked at to either side
WORSE = 1.5  # an alias that leaves this much more scatter than the best is excluded
NEAR_NOMINAL = 0.15  # relative; further away the nominal rate does not choose
FAR_FROM_NOMINAL = 0.02  # relative; worth a word
RETIMED = {  # playback rate over capture rate of clips that were retimed, and how that happens
    29.97 / 240: "filmed at 240 pictures per second and stamped as 29.97",
    30 / 240: "filmed at 240 pictures per second and stamped as 30",
    29.97 / 120: "filmed at 120 pictures per second and stamped as 29.97",
    30 / 120: "filmed at 120 pictures per second and stamped as 30",
    29.97 / 60: "filmed at 60 pictures per second and stamped as 29.97, or slowed to half",
    2.0: "sped up to twice",
    24 / 30: "filmed at 30 pictures per second and stamped as 24",
    25 / 30: "filmed at 30 pictures per second and stamped as 25",
    30 / 25: "filmed at 25 pictures per second and stamped as 30",
    30 / 24: "filmed at 24 pictures per second and stamped as 30",
}
RETIMED_WITHIN = 0.01
RPM = 2 * np.pi / 60


@dataclass(frozen=True)
class Alias:
    """The chosen rate, all that look alike (the chosen first), why, and what to warn of."""

    rate_rad_s: float
    aliases: tuple[float, ...]
    says: str
    warnings: tuple[str, ...]


def choose_alias(
    track: PhaseTrack, time_s: FloatArray, rough_rad_s: float, nominal_rpm: float | None
) -> Alias:
    """List the rates that fit the pictures and choose one.

    Parameters
    ----------
    track : PhaseTrack
    time_s : array, shape (f,)
    rough_rad_s : float
        The smallest, signed.
    nominal_rpm : float, optional
    """
    good = np.flatnonzero(usable(track))
    step_s, step = np.diff(time_s[good]), np.diff(track.phase_rad[good])
    spacing = 2 * np.pi / (track.plate.symmetry * frame_time(time_s[good]))
    rates = rough_rad_s + spacing * np.arange(-REACH, REACH + 1)
    period = 2 * np.pi / track.plate.symmetry
    scatter = []
    for rate in rates:
        surprise = step - rate * step_s
        surprise -= period * np.round(surprise / period)
        scatter.append(float(np.median(np.abs(surprise - np.median(surprise)))))
    alike = rates[np.array(scatter) <= WORSE * min(scatter) + 1e-9]
    alike = alike[np.argsort(np.abs(alike))]
    if nominal_rpm is None:
        chosen = float(alike[0])
        says = "the smallest was taken, since no nominal_rpm is given"
        warnings: tuple[str, ...] = ()
    else:
        nearest = float(alike[np.argmin(np.abs(np.abs(alike) / RPM - nominal_rpm))])
        near = abs(abs(nearest) / RPM / nominal_rpm - 1) < NEAR_NOMINAL
        chosen = nearest if near else float(alike[0])
        says = (
            f"the nearest to nominal_rpm {nominal_rpm:g} was taken"
            if near
            else f"the smallest was taken; none is near nominal_rpm {nominal_rpm:g}"
        )
        warnings = _against_nominal(track.source, chosen, nominal_rpm)
    others = tuple(float(rate) for rate in alike if rate != chosen)
    if not others:
        says = "the uneven spacing of the pictures excludes every other rate"
    return Alias(chosen, (chosen, *others), says, warnings)


def _against_nominal(source: str, rate_rad_s: float, nominal_rpm: float) -> tuple[str, ...]:
    ratio = abs(rate_rad_s) / RPM / nominal_rpm
    if abs(ratio - 1) < FAR_FROM_NOMINAL:
        return ()
    text = (
        f"{source}: the plate turns at {abs(rate_rad_s) / RPM:.4g} rpm by the time stamps, "
        f"nominal_rpm is {nominal_rpm:g}"
    )
    for factor, how in RETIMED.items():
        if abs(ratio / factor - 1) < RETIMED_WITHIN:
            return (
                f"{text}. The ratio {ratio:.4g} is that of a clip {how}. If so, give the capture "
                f"rate (timebase: {{source: constant, fps: ...}}).",
            )
    return (f"{text}. Check the speed of the deck and the frame rate of the clip.",)
