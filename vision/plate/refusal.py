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
MOSTLY = 0.5  # squared correlation of two frames with one picture; likewise
LIGHT = 0.05  # of the mean luma, change by a light from frame to frame; likewise


def why_nothing_moves(seen: Sequence[Luma], steps: int) -> str:
    """The message for frames that differ by noise, by the light, or in steps.

    Parameters
    ----------
    seen : sequence of arrays of uint8, shape (h, w)
        Spread over the time, in order.
    steps : int
        Number of frames that differ from the one before by more than noise.
    """
    light = np.array([float(frame.mean()) for frame in seen])
    dark, bright = seen[int(light.argmin())], seen[int(light.argmax())]
    nothing = "nothing in the frame turns about a fixed axis"
    if np.ptp(light) > LIGHT * light.mean() and _same_picture(dark, bright):
        return (f"{nothing}: the light changes (the mean of the frames goes from "
                f"{light.min():.0f} to {light.max():.0f} of 255), and nothing else. "
                f"{_advice(seen[0])}")
    if steps > 1:
        return (f"{nothing}: the picture changes in steps and stands still between them: of "
                f"{len(seen)} frames spread over the time {steps} differ from the one before; a "
                f"plate turns on evenly. {_advice(seen[0])}")
    return (f"{nothing}: what changes from frame to frame is no more than the noise of the "
            f"camera. {_advice(seen[0])}")


def _same_picture(one: Luma, other: Luma) -> bool:
    """Whether two frames, (h, w), correlate; frames without contrast do."""
    x, y = (frame.ravel() - frame.mean() for frame in (one, other))
    return bool(float(x @ y) ** 2 >= MOSTLY * float(x @ x) * float(y @ y))


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
