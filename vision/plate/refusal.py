"""What is said where no plate can be learned."""

import math
from dataclasses import dataclass

import numpy as np

from vision.geometry import PlateView
from vision.plate.mark import repeats_itself
from vision.plate.rotation import CoarseRotation
from vision.plate.template import Template


@dataclass(frozen=True)
class RefusalThresholds:
    """Which fault of a plate a refusal names; they choose the words, not the refusal.

    Attributes
    ----------
    whole : float
        Of the rim inside the frame, of a plate seen whole.
    grazing_rad : float
        Tilt above which a plate is seen nearly from the side.
    """

    whole: float = 0.95
    grazing_rad: float = math.radians(75)


THRESHOLDS = RefusalThresholds()


def why_nothing_turns(
    tried: list[tuple[PlateView, CoarseRotation]], best: float, shape: tuple[int, ...]
) -> str:
    """No proposal shows enough that turns together, at ``best`` so much; frames of ``shape``."""
    view = max(tried, key=lambda item: item[1].coherence, default=(None, None))[0]
    fault = "" if view is None else _partly_seen(view, shape)
    return (
        f"nothing in the frame turns about a fixed axis: {len(tried)} round outline(s) were "
        f"tried, and at most {best:.0%} of what changes inside one turns together (a plate gives "
        f"50 to 100 %).{fault and f' The likeliest outline {fault}.'} Film the whole plate from "
        f"above with the camera on a stand, put a mark on it that differs from the plate in "
        f"brightness or colour, or give the rim yourself (plate: centre_px, radius_px)."
    )


def why_it_jumps(found: Template, shape: tuple[int, ...]) -> str:
    """Something turns together, and yet its angle does not go on evenly."""
    fault = _partly_seen(found.grid.view, shape)
    if fault:
        return (
            f"what turns in the frame {fault}, and its angle cannot be told where nothing of its "
            f"pattern is in the frame. Film the whole plate."
        )
    if repeats_itself(found):
        return (
            "the pattern of the plate repeats itself around it (strobe dots, ribs of a mat), and "
            "how many of them pass from frame to frame cannot be seen. Put one mark on the "
            "plate that stands out from the pattern (paper, tape) and film again."
        )
    return (
        "what turns in the frame goes by jumps from frame to frame, as where frames are "
        "missing, their time stamps are wrong, or the pattern of the plate repeats itself. Record "
        "into .mp4 or .mkv in good light, with one bold mark on the plate."
    )


def _partly_seen(view: PlateView, shape: tuple[int, ...]) -> str:
    """What is wrong where a plate is not seen whole, or nearly from the side; else empty."""
    x, y = view.pixels(np.ones(180), np.linspace(0, 2 * np.pi, 180, endpoint=False))
    inside = float(((x >= 0) & (y >= 0) & (x < shape[1]) & (y < shape[0])).mean())
    faults = []
    if inside < THRESHOLDS.whole:
        faults.append(f"lies {1 - inside:.0%} outside the frame")
    if view.tilt_rad > THRESHOLDS.grazing_rad:
        faults.append(f"is seen {np.degrees(view.tilt_rad):.0f}° away from straight above")
    return f"{' and '.join(faults)}: the plate is not fully seen" if faults else ""
