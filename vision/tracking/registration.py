"""Registration of the frames of a moving camera to one of them by the surroundings of the plate.

Corners of a reference frame are tracked into every frame (Lucas and Kanade's optical flow, always
from the reference, so that no error adds up). Stationary corners move by the homography of the
camera's motion; corners that turn with the plate do not, and those that rarely agree with the
others are left out. Corners on one side only may belong to a tonearm that rides on a warped record,
and do not count as surroundings. The homography of the table's plane also holds for the plate,
which lies near it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.numbers import median
from vision.plate.background import spread_choice
from vision.video.reader import Frame, Luma

CELLS = 4  # of the frame, each way: a plate full of corners leaves some to its surroundings
CORNERS = 10  #: largest number tracked in each of them; a limit of time
APART_PX = 9  #: least distance from corner to corner
QUALITY = 0.01  # of the strongest corner
WINDOW = (21, 21)  #: pixels around a corner
LEVELS = 3  #: levels of the pyramid: motions of up to eight windows
NEAR_LEVELS = 1  #: levels that are tried first, from one frame to the next: half the time
LOOKED_AT = 14  # frames, to find whether the camera moves and which corners are stationary
FEWEST = 8  # corners, twice what determines a homography
ENOUGH = 24  # corners for a homography; fewer give shift, roll and scale
#: Iterations and pixels at which the tracking of a corner ends.
ENDS = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 12, 0.01)
TRIALS = 300  # random samples for a common motion
LASTING = 3  # examined frames: a hand or a flash does not last as long
FEWEST_QUARTERS, PER_QUARTER = 3, 3  # of the frame, with so many stationary corners


# Limits for stationary corners and a stationary camera.
AGREE_PX = 1.5  #: distance from the common motion within which a corner follows it
STANDS = 0.6
"""Share of the frames in which a corner must do so. Derived: half, and a margin for frames in which
the mark of the plate passes."""
MOVED_PX = 0.6
"""Root mean square motion of the surroundings, pixels of the analysed frame, from which the frames
are registered. Tuned on tests.bench.clip_study hand_held."""
REMAINS = 0.5
"""Largest share of the differences from the reference that remains without the motion of a camera.
Derived: half; cameras that move leave 0.01 to 0.11, flickering lamps 1.4 and more."""


class Registration:
    """Registration of frames to a reference.

    Parameters
    ----------
    reference : array of uint8, shape (h, w)
    corners : array of float32, shape (n, 2)
        Stationary pixels of the reference.
    """

    def __init__(self, reference: Luma, corners: NDArray[np.float32]) -> None:
        self._reference, self.corners = reference, corners
        self._motion = np.eye(3)
        self._away_px: list[float] = []
        self.largest_px = self.largest_roll_rad = 0.0
        self.moves = False  #: whether the camera moves in the frames that were registered first

    def motion(self, luma: Luma, *, fewest: float = 0.0) -> FloatArray | None:
        """Homography from the reference to a frame, px to px, (3, 3); None if it is not visible.

        Parameters
        ----------
        luma : array of uint8, shape (h, w)
        fewest : float
            Least share of the corners that follow it.
        """
        for levels in (NEAR_LEVELS, LEVELS):
            onto, seen = _followed(
                self._reference, luma, self.corners, self._motion, levels=levels)
            if seen.sum() < FEWEST:
                continue
            motion, agree = _common_motion(self.corners[seen], onto[seen])
            share = fewest if levels == LEVELS else STANDS
            if motion is not None and agree.sum() >= max(FEWEST, share * len(agree)):
                self._motion = motion
                return motion
        return None

    def look(self, luma: Luma) -> None:
        """Measure in a frame the displacement of the surroundings."""
        motion = self.motion(luma, fewest=STANDS)
        if motion is not None:
            away = _moved(self.corners, motion) - self.corners
            # By shift and roll alone: with few corners in a dark film the rest is noise.
            (x, y), (u, v) = (self.corners - self.corners.mean(axis=0)).T, away.T
            by_roll = float((x * v - y * u).sum()) / float(np.sqrt((x**2 + y**2).sum() * len(x)))
            self._away_px.append(float(np.hypot(np.hypot(*away.mean(axis=0)), by_roll)))

    def explains(self, lumas: Sequence[Luma]) -> bool:
        """Whether the frames, (h, w), are more like the reference when they are brought back.

        Light that flickers shifts the corners too, and then they are less like it.
        """
        around = np.indices(WINDOW).reshape(2, -1).T - WINDOW[0] // 2
        places = (self.corners[:: 1 + len(self.corners) // ENOUGH, None] + around).reshape(-1, 2)
        wanted = _patches(self._reference, places)
        before = after = 0.0
        for luma in lumas:
            motion = self.motion(luma)
            if motion is not None:
                before += float(((_patches(luma, places) - wanted) ** 2).sum())
                after += float(((_patches(luma, _moved(places, motion)) - wanted) ** 2).sum())
        self._motion = np.eye(3)
        return after < REMAINS * before

    @property
    def moved(self) -> bool:
        """Whether they moved in the examined frames, and not only in a frame or two."""
        if len(self._away_px) < LASTING:
            return False
        lasting = np.lib.stride_tricks.sliding_window_view(self._away_px, LASTING).min(axis=1)
        return bool(lasting.max() > 2 * MOVED_PX)  # a peak, not a root mean square

    def note(self, source: str, reduction: int) -> str:
        """A note on the removed motion for the user; ``reduction`` is the factor of the frames."""
        away_px = reduction * self.largest_px
        return (
            f"{source}: the camera moved by up to {away_px:.0f} px and rolled by up to "
            f"{np.degrees(self.largest_roll_rad):.1f}° while it filmed. Both were taken out by "
            f"what stands around the plate, and the sd includes what is left of them; a camera on "
            f"a stand gives a smaller sd."
        )

    def steadied(self, batches: Iterator[list[Frame]]) -> Iterator[list[Frame]]:
        """The frames of the batches as the reference's camera would have taken them."""
        for batch in batches:
            yield [self.back(frame) for frame in batch]

    def back(self, frame: Frame) -> Frame:
        """A frame as the reference's camera would have taken it; if not visible, like the last."""
        self.motion(frame.luma)
        motion = self._motion
        shift = _moved(self.corners, motion) - self.corners
        self.largest_px = max(self.largest_px, float(np.hypot(*median(shift, axis=0))))
        roll = float(np.arctan2(motion[1, 0] - motion[0, 1], motion[0, 0] + motion[1, 1]))
        self.largest_roll_rad = max(self.largest_roll_rad, abs(roll))
        chroma = brought_back(frame.chroma, motion) if frame.chroma.size else frame.chroma
        return replace(frame, luma=brought_back(frame.luma, motion), chroma=chroma, motion=motion)


def registration(frames: list[Frame]) -> Registration | None:
    """Registration of the frames to that in the middle; None if too little is stationary.

    Parameters
    ----------
    frames : list of Frame
        Some seconds of the clip.
    """
    reference = frames[len(frames) // 2].luma
    corners = _corners(reference)
    if not _all_around(corners, reference.shape):
        return None
    looked_at = [frames[i].luma for i in spread_choice(len(frames), LOOKED_AT)]
    followed, agreements, still = [], np.zeros(len(corners)), np.zeros(len(corners))
    enough = STANDS * len(looked_at)
    for number, luma in enumerate(looked_at, 1):
        onto, seen = _followed(reference, luma, corners, np.eye(3), levels=0)
        away = np.where(seen, np.linalg.norm(onto - corners, axis=1), np.inf)
        agree = away < AGREE_PX
        # Unmoved corners show a fixed camera; otherwise search the motion that most corners share.
        if not _all_around(corners[away < MOVED_PX], reference.shape):
            onto, seen = _followed(reference, luma, corners, np.eye(3))
            agree = np.zeros(len(corners), bool)
            if seen.sum() >= FEWEST:
                agree[seen] = _common_motion(corners[seen], onto[seen])[1]
        followed.append((onto, seen))
        agreements += agree
        still += away < MOVED_PX
        possible = agreements + len(looked_at) - number >= enough
        if not _all_around(corners[possible], reference.shape):
            return None  # however many agree in the remaining frames
    stands = agreements >= enough
    # A moving camera moves everything. Ribs of a mat, from each to the next, also move as a rolling
    # camera would move them, and may be most of the corners; but others are stationary.
    if (still >= enough).sum() >= FEWEST:
        stands = still >= enough
    shifts = [median((onto - corners)[seen & stands], axis=0)
              for onto, seen in followed if (seen & stands).sum() >= FEWEST]
    away = np.array(shifts) - median(shifts, axis=0)
    moved_px = float(np.sqrt((away**2).sum(axis=1).mean()))
    camera = Registration(reference, corners[stands])
    camera.moves = moved_px > MOVED_PX and camera.explains(looked_at)
    return camera


def _corners(reference: Luma) -> NDArray[np.float32]:
    """The strongest corners of every cell of the frame, shape (n, 2)."""
    strongest = cv2.goodFeaturesToTrack(reference, 0, QUALITY, APART_PX)
    if strongest is None:
        return np.empty((0, 2), np.float32)
    corners = np.asarray(strongest, np.float32).reshape(-1, 2)  # the strongest first
    column, row = (corners * CELLS / reference.shape[::-1]).astype(int).T
    cell = row * CELLS + column
    chosen = [np.flatnonzero(cell == number)[:CORNERS] for number in range(CELLS**2)]
    return corners[np.sort(np.concatenate(chosen))]


def _all_around(corners: NDArray[np.float32], shape: tuple[int, ...]) -> bool:
    right, below = (corners > np.array(shape[::-1]) / 2).T
    quarters = np.bincount(right + 2 * below, minlength=4)
    return int((quarters >= PER_QUARTER).sum()) >= FEWEST_QUARTERS


def _followed(
    reference: Luma, luma: Luma, corners: NDArray[np.float32], motion: FloatArray, *,
    levels: int = LEVELS
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Positions of the corners in a frame, and which were found again."""
    start = np.asarray(_moved(corners, motion), np.float32)[:, None]
    onto, status, _ = cv2.calcOpticalFlowPyrLK(
        reference, luma, corners[:, None], start.copy(), winSize=WINDOW, maxLevel=levels,
        criteria=ENDS, flags=cv2.OPTFLOW_USE_INITIAL_FLOW)
    return np.asarray(onto, np.float32)[:, 0], np.asarray(status).ravel() > 0


def _common_motion(
    corners: NDArray[np.float32], onto: NDArray[np.float32]
) -> tuple[FloatArray | None, NDArray[np.bool_]]:
    """The motion that most corners share, shape (3, 3), and the mask of these corners."""
    limit = AGREE_PX
    nobody = np.zeros(len(corners), bool)
    if len(corners) >= ENOUGH:
        whole, agree = cv2.findHomography(corners, onto, cv2.RANSAC, limit, maxIters=TRIALS)
        if whole is None or agree is None:
            return None, nobody
        used = np.asarray(agree).ravel() > 0
        return np.asarray(whole, float), used
    part, agree = cv2.estimateAffinePartial2D(corners, onto, ransacReprojThreshold=limit)
    if part is None or agree is None:
        return None, nobody
    return np.vstack([part, [0, 0, 1.0]]), np.asarray(agree).ravel() > 0


def _moved(corners: NDArray[np.floating], motion: FloatArray) -> FloatArray:
    x, y, n = motion @ np.column_stack([corners, np.ones(len(corners))]).T
    return np.asarray(np.stack([x / n, y / n], axis=1))


def _patches(luma: Luma, places: NDArray[np.floating]) -> FloatArray:
    """Patches (n, p) at places (n p, 2) without their brightness and contrast, no unit."""
    x, y = np.asarray(places.T, np.float32)
    seen = cv2.remap(luma, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    patches = np.asarray(seen, float).reshape(-1, WINDOW[0] * WINDOW[1])
    patches -= patches.mean(axis=1, keepdims=True)
    return np.asarray(patches / np.maximum(patches.std(axis=1, keepdims=True), 1.0))


def brought_back(image: Luma, motion: FloatArray) -> Luma:
    """An image (h, w) in the reference's view, (h, w); by the homography from the reference."""
    h, w = image.shape[:2]
    how = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return np.asarray(
        cv2.warpPerspective(image, motion, (w, h), flags=how, borderMode=cv2.BORDER_REPLICATE),
        np.uint8)
