"""Facts about every term of the plate's phase: its formula, its size, its separation."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class TermPage:
    """The page of a term.

    Attributes
    ----------
    formula : str
        The addition to the angle θ_0 + Ω t.
    typical : str
        Its size on record players and with webcams.
    source : str
    confounded : str
        Effects that look the same.
    separates : str
        The recording that separates them.
    """

    formula: str
    typical: str
    source: str
    confounded: str
    separates: str


TERM_PAGES: Mapping[str, TermPage] = {
    "once_per_rev": TermPage(
        "a cos θ + b sin θ",
        "amplitude 0.2 to 4°: a centre that is off by 1 % of the mark's radius gives 0.6°, a view "
        "tilted by 20° from five plate radii away 4°, 0.1 % wow 0.06°",
        "geometry of the track: A = e / r",
        "rolling_shutter, and wow of the drive",
        "the other direction or a second speed; a second mark opposite the first"),
    "twice_per_rev": TermPage(
        "a cos 2θ + b sin 2θ",
        "amplitude tan²(α/2) for a camera tilted by α: 0.4° for 10°, 1.8° for 20°, less where the "
        "rim shows the tilt",
        "geometry of the view: a circle is seen as an ellipse",
        "a drive that is oval",
        "a camera straight above the spindle"),
    "rate_drift": TermPage(
        "½ c t²",
        "0.1 to 1 % of the rate per hour while the motor warms up",
        "record players: a motor and a belt that warm up",
        "a clock of the camera that drifts",
        "a clip that begins minutes after the plate has started"),
    "frame_steps": TermPage(
        "n Ω T, n the frames dropped so far, T the frame time",
        "13° for each frame lost at 33 rpm and 15 frames per second",
        "recorders that drop frames and leave the time stamps even",
        "a plate that slips",
        "time stamps of the container; a recorder that keeps them"),
    "rolling_shutter": TermPage(
        "Ω τ r(θ), r the rows between spindle and mark, τ the time between rows",
        "1.2° at 33 rpm for a readout of 30 ms and a mark 100 of 480 rows off the spindle",
        "CMOS cameras read their rows one after the other",
        "once_per_rev",
        "the other direction, a second speed, or the camera turned by 90°"),
}
