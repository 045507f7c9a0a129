"""Whether angles are those of a plate: it has inertia, and turns on between neighbouring frames.

A frame in which no mark is seen has an angle all the same: that at which the template looks most
like noise, or like what stands still and was not told from the plate. Such an angle does not
advance with the rough rotation. Taken as it is, it writes what stands into the template, which then
explains such frames well at the wrong angle. The angle of the frames before and after is carried on
to such a frame, which then shows the background alone.
"""

import math
from dataclasses import dataclass

import numpy as np

from vision.geometry import FloatArray
from vision.numbers import median, quantile
from vision.phase_track import BoolArray


@dataclass(frozen=True)
class InertiaThresholds:
    """How a plate turns on. Tuned on tests.bench.vision_scenes but where stated.

    Attributes
    ----------
    smooth_rad : float
        Median second difference from the coarse angle, rad, at most: a plate has inertia. Tuned on
        tests.bench.vision_films and the slow cameras of tests.vision.test_clips.
    slipping : float
        Of the rough rotation: what stands or goes slowly took the place of the plate. Derived: half
        way between what turns and what stands.
    far_rad : float
        Beyond it an angle has lost the rough one, rad, however fast the plate.
    near_rad : float
        Within it no angle has. Derived: two samples of azimuth of the coarse template.
    usual : float
        Times the lower quartile of all differences from the rough rotation, which is that of the
        frames that show their angle best. Derived: 4 sds, of which 0.32 hold a quarter of Gaussian
        values, of frames that show a label with a quarter of the mark's contrast.
    apart_rad : float
        Rotation by the rough rate, rad, over which frames are compared: twelve samples of azimuth
        of the coarse template. Tuned on ``tests.bench.clip_study --only mark_leaves``.
    """

    smooth_rad: float = 0.12
    slipping: float = 0.5
    far_rad: float = math.pi / 6
    near_rad: float = 0.05
    usual: float = 50.0
    apart_rad: float = 0.3


THRESHOLDS = InertiaThresholds()


def smooth(angle_rad: FloatArray, rough_rad: FloatArray) -> bool:
    """Whether refined angles go with rough ones, both of shape (f,), without jumps."""
    beyond = angle_rad - rough_rad
    step = float(median(np.abs(np.diff(rough_rad))))
    slip = abs(float(median(np.diff(beyond))))
    # Stamps may come early and late in turn; then the plate goes on evenly over two frames.
    each, over_two = (float(median(np.abs(np.diff(beyond[::n], 2)))) for n in (1, 2))
    return min(each, over_two) < THRESHOLDS.smooth_rad and slip < THRESHOLDS.slipping * step


def turns_on(angle_rad: FloatArray, rough_rad: FloatArray) -> BoolArray:
    """Frames whose angle advances like the rough one from the frames before or to those after.

    Parameters
    ----------
    angle_rad, rough_rad : array, shape (f,)
        Of neighbours in time. The rough ones hold over some frames; over many they drift.

    Returns
    -------
    array of bool, shape (f,)
    """
    step = float(median(np.abs(np.diff(rough_rad))))
    lag = max(1, math.ceil(THRESHOLDS.apart_rad / max(step, 1e-9)))
    if len(angle_rad) <= 2 * lag:
        return np.ones(len(angle_rad), bool)
    advance = np.abs(rough_rad[lag:] - rough_rad[:-lag])
    beyond = np.angle(np.exp(1j * (angle_rad - rough_rad)))
    slip = np.abs(np.angle(np.exp(1j * (beyond[lag:] - beyond[:-lag]))))
    most = min(THRESHOLDS.usual * float(quantile(slip, 0.25)), THRESHOLDS.far_rad)
    # A plate at rest is not lost either.
    limit = np.maximum(np.minimum(THRESHOLDS.slipping * advance, most), THRESHOLDS.near_rad)
    goes = slip < limit
    nobody = np.zeros(lag, bool)
    return np.asarray(np.concatenate([nobody, goes]) | np.concatenate([goes, nobody]))


def carried_on(angle_rad: FloatArray, rough_rad: FloatArray, shows: BoolArray) -> FloatArray:
    """The angles, and where a frame shows none that of its neighbours, rad, shape (f,).

    Parameters
    ----------
    angle_rad, rough_rad : array, shape (f,)
    shows : array of bool, shape (f,)
        Frames that show their angle, one at least.
    """
    frame = np.arange(len(shows))
    beyond = np.unwrap((angle_rad - rough_rad)[shows])
    return np.where(shows, angle_rad, rough_rad + np.interp(frame, frame[shows], beyond))
