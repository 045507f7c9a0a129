"""The messages if no plate can be learned."""

from collections.abc import Sequence

import numpy as np

from vision.geometry import FloatArray
from vision.numbers import quantile
from vision.plate.mark import symmetry
from vision.plate.rotation import CoarseRotation
from vision.plate.template import Alignment
from vision.video.reader import Luma

DARK = 48.0  # luma of the brightest twentieth; black is 16; it chooses the words only
WHITE = 230.0  # luma of the darkest twentieth; white is 235; likewise
BRIGHTEST = 0.95  # quantile


def why_nothing_moves(seen: Sequence[Luma], steps: int, lines: int | None) -> str:
    """The message for frames that differ by noise, by the light, or in steps.

    Parameters
    ----------
    seen : sequence of arrays of uint8, shape (h, w)
        Spread over the time, in order.
    steps : int
        Number of frames that differ from the one before by more than noise.
    lines : int or None
        Axis of the lines whose light changes.
    """
    nothing = "nothing in the frame turns about a fixed axis"
    if lines is not None:
        light = [float(frame.mean()) for frame in seen]
        return (f"{nothing}: the light changes, in bands of a lamp or as a whole (the mean of the "
                f"frames goes from {min(light):.0f} to {max(light):.0f} of 255), and nothing that "
                f"turns is seen beside it. {_advice(seen[0])}")
    if steps > 1:
        return (f"{nothing}: the picture changes in steps and stands still between them: of "
                f"{len(seen)} frames spread over the time {steps} differ from the one before; a "
                f"plate turns on evenly. {_advice(seen[0])}")
    return (f"{nothing}: what changes from frame to frame is no more than the noise of the "
            f"camera. {_advice(seen[0])}")


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
    if float(quantile(seen, 1 - BRIGHTEST)) > WHITE:
        return "Shorten the exposure: nineteen in twenty pixels are white."
    return ("Check that the plate turns; film the whole of it from above and from a stand, with a "
            "mark of paper or tape near its rim that is much brighter or darker than the plate, "
            "and with nothing else that moves.")


def why_it_jumps(seen: Alignment, time_s: FloatArray) -> str:
    """The message for a common rotation whose angle, at times (f,), does not advance evenly."""
    if symmetry(seen.template, seen) > 1:
        return (
            "what turns in the frame repeats itself around its axis (blades, strobe dots, ribs of "
            "a mat), and the frames cannot show how many of its parts pass from frame to frame. "
            "Put one mark on the plate that differs from the pattern (paper, tape) and film again."
        )
    turned = np.ptp(seen.angle_rad) / (2 * np.pi)
    if turned < 1:
        return (f"what resembles a plate most turns by {turned:.2f} of a turn in "
                f"{np.ptp(time_s):.1f} s, and a rate needs one at least. Film for a minute.")
    return (
        "what resembles a plate most does not turn on evenly from frame to frame: it is none, it "
        "turns too fast for the frame rate, it is seen in some frames only, or frames are missing. "
        "Record the whole plate into .mp4 or .mkv in good light, with one bold mark on it."
    )
