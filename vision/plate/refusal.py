"""The messages where no plate can be learned."""

import numpy as np

from vision.geometry import PlateView
from vision.numbers import quantile
from vision.plate.mark import symmetry
from vision.plate.rotation import CoarseRotation
from vision.plate.template import Template
from vision.video.reader import Luma

WHOLE = 0.95  # of the rim inside the frame; it chooses the words only
GRAZING_RAD = np.radians(75)  # tilt; likewise
DARK = 48.0  # luma of the brightest twentieth; black is 16; likewise
BRIGHTEST = 0.95  # quantile
NOTHING = 0.15  # coherence of what only flickers, whose outline may lie anywhere; likewise


def why_nothing_moves(seen: Luma) -> str:
    """Frames such as the one seen, (h, w), differ by noise alone."""
    return (
        "nothing in the frame turns about a fixed axis: what changes from frame to frame is no "
        "more than the noise of the camera. "
    ) + (_too_dark(seen) or (
        "Check that the plate turns; if it does, put a mark of paper or tape on it that is much "
        "brighter or darker than the plate."
    ))


def why_nothing_turns(
    outlines: list[tuple[PlateView, CoarseRotation]],
    background: Luma,
    *,
    camera_stands: bool,
) -> str:
    """No outline shows enough that turns together; what to change first.

    Parameters
    ----------
    outlines : list of (PlateView, CoarseRotation)
    background : array of uint8, shape (h, w)
        What stands still, in brightness.
    camera_stands : bool
        What surrounds the plate is seen, and does not move.
    """
    view, rotation = max(outlines, key=lambda outline: outline[1].coherence, default=(None, None))
    coherence = 0.0 if rotation is None else rotation.coherence
    fault = ""
    if view is not None and coherence > NOTHING:
        fault = _partly_seen(view, background.shape)
    return (
        f"nothing in the frame turns about a fixed axis: {len(outlines)} round outline(s) were "
        f"tried, and at most {coherence:.0%} of what changes inside one turns together (a plate "
        f"shows 50 to 100 %).{fault and f' The likeliest outline {fault}.'} "
        f"{_too_dark(background) or _to_change_first(fault, coherence, camera_stands)}"
    )


def _too_dark(seen: Luma) -> str:
    """What to do about a frame, (h, w), that is nearly black; else empty."""
    light = float(quantile(seen, BRIGHTEST))
    return "" if light >= DARK else (
        f"Switch on a light: nineteen in twenty pixels are darker than {light:.0f} of 255, where "
        f"black is 16."
    )


def _to_change_first(fault: str, coherence: float, camera_stands: bool) -> str:
    if fault:
        return "Film the whole plate from above."
    if coherence < NOTHING:
        return (
            "Put a mark of paper or tape on the plate near its rim, or state the rim if there is "
            "one (--rim, or plate: centre_px, radii_px)."
        )
    if camera_stands:
        return (
            "Put a mark of paper or tape on the plate near its rim, much brighter or darker than "
            "the plate, and keep hands and shadows out of the frame."
        )
    return "Fix the camera to a stand, and film the whole plate from above."


def why_it_jumps(template: Template, shape: tuple[int, ...]) -> str:
    """Something turns together, but its angle does not advance evenly; frames of ``shape``."""
    fault = _partly_seen(template.grid.view, shape)
    if fault:
        return (
            f"what turns in the frame {fault}, and its angle cannot be measured where no part of "
            f"its pattern is in the frame. Film the whole plate."
        )
    if symmetry(template) > 1:
        return (
            "the pattern of the plate repeats itself around it (strobe dots, ribs of a mat), and "
            "the frames cannot show how many of them pass from frame to frame. Put one mark on "
            "the plate that differs from the pattern (paper, tape) and film again."
        )
    return (
        "what turns in the frame jumps from frame to frame: frames are missing, their time stamps "
        "are wrong, or the pattern of the plate repeats itself. Record into .mp4 or .mkv in good "
        "light, with one bold mark on the plate."
    )


def _partly_seen(view: PlateView, shape: tuple[int, ...]) -> str:
    """What is wrong where a plate is not seen whole, or nearly from the side; else empty."""
    x, y = view.pixels(np.ones(180), np.linspace(0, 2 * np.pi, 180, endpoint=False))
    inside = float(((x >= 0) & (y >= 0) & (x < shape[1]) & (y < shape[0])).mean())
    faults = []
    if inside < WHOLE:
        faults.append(f"lies {1 - inside:.0%} outside the frame")
    if view.tilt_rad > GRAZING_RAD:
        faults.append(f"is seen {np.degrees(view.tilt_rad):.0f}° away from straight above")
    return f"{' and '.join(faults)}: the plate is not fully seen" if faults else ""
