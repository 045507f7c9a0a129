"""The messages if no plate can be learned."""

from collections.abc import Sequence

import numpy as np

from vision.numbers import quantile
from vision.plate.mark import symmetry
from vision.plate.rotation import CoarseRotation
from vision.plate.template import Template
from vision.video.reader import Luma

DARK = 48.0  # luma of the brightest twentieth; black is 16; it chooses the words only
BRIGHTEST = 0.95  # quantile
LIGHT = 0.05  # of the mean luma, change by a light from frame to frame; likewise


def why_nothing_moves(seen: Sequence[Luma]) -> str:
    """The message for frames, (h, w) each, that differ by noise, or by the light alone."""
    light = np.array([float(frame.mean()) for frame in seen])
    if np.ptp(light) > LIGHT * light.mean():
        return (f"nothing in the frame turns about a fixed axis: the light changes (the mean of "
                f"the frames goes from {light.min():.0f} to {light.max():.0f} of 255), and "
                f"nothing else. {_advice(seen[0])}")
    return (f"nothing in the frame turns about a fixed axis: what changes from frame to frame is "
            f"no more than the noise of the camera. {_advice(seen[0])}")


def why_nothing_turns(rotations: Sequence[CoarseRotation], seen: Luma) -> str:
    """The message for outlines without common rotation; a frame (h, w) shows the brightness."""
    tried = "no round outline is seen in it"
    if rotations:
        coherence = max(rotation.coherence for rotation in rotations)
        tried = (f"{len(rotations)} round outline(s) were tried, and at most {coherence:.0%} of "
                 f"what changes inside one turns together (a plate shows 50 to 100 %)")
    return f"nothing in the frame turns about a fixed axis: {tried}. {_advice(seen)}"


def _advice(seen: Luma) -> str:
    light = float(quantile(seen, BRIGHTEST))
    if light < DARK:
        return (f"Switch on a light: nineteen in twenty pixels are darker than {light:.0f} of "
                f"255, where black is 16.")
    return ("Check that the plate turns; film the whole of it from above and from a stand, with a "
            "mark of paper or tape near its rim that is much brighter or darker than the plate, "
            "and with nothing else that moves.")


def why_it_jumps(template: Template) -> str:
    """The message for a common rotation whose angle does not advance evenly."""
    if symmetry(template) > 1:
        return (
            "what turns in the frame repeats itself around its axis (blades, strobe dots, ribs of "
            "a mat), and the frames cannot show how many of its parts pass from frame to frame. "
            "Put one mark on the plate that differs from the pattern (paper, tape) and film again."
        )
    return (
        "what turns in the frame jumps from frame to frame: frames are missing, their time stamps "
        "are wrong, it turns too fast for the frame rate, or it is seen in some frames only. "
        "Record the whole plate into .mp4 or .mkv in good light, with one bold mark on it."
    )
