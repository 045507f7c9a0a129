"""Test of angles against inertia: a plate continues to turn between neighbouring frames.

A frame without a visible mark has an angle nevertheless: the one at which the template looks most
like noise, or like background that was not separated from the plate. Such an angle does not advance
with the rough rotation. Used unchanged, it writes the background into the template, which then
explains such frames well at the wrong angle. The angle of the frames before and after is extended
to such a frame, which then shows the background alone.
"""

import math

import numpy as np

from vision.geometry import FloatArray
from vision.numbers import median, quantile
from vision.phase_track import BoolArray

# Limits of inertia. Tuned on tests.bench.vision_scenes unless stated otherwise.
SLIPPING = 0.5
"""Slip over the rough rotation from which a stationary or slow object replaced the plate. Derived:
half way between turning and stationary."""
FAR_RAD = math.pi / 6
"""Difference beyond which an angle has lost the rough one, rad, at any rate of the plate."""
NEAR_RAD = 0.05
"""Difference within which none has. Derived: two samples of azimuth of the coarse template."""
USUAL = 50.0
"""Factor of the lower quartile of all differences from the rough rotation, which belongs to the
frames that show their angle best. Derived: 4 sds, of which 0.32 hold a quarter of Gaussian values,
of frames that show a label with a quarter of the mark's contrast."""
APART_RAD = 0.3
"""Rotation at the rough rate, rad, over which frames are compared: twelve samples of azimuth of the
coarse template. Tuned on ``tests.bench.clip_study --only mark_leaves``."""


def smooth(angle_rad: FloatArray, rough_rad: FloatArray) -> bool:
    """Whether refined angles advance with rough ones, both of shape (f,)."""
    step = float(median(np.abs(np.diff(rough_rad))))
    slip = abs(float(median(np.diff(angle_rad - rough_rad))))
    return slip < SLIPPING * step


def turns_on(angle_rad: FloatArray, rough_rad: FloatArray) -> BoolArray:
    """Frames whose angle advances like the rough one from earlier frames or to later ones.

    Parameters
    ----------
    angle_rad, rough_rad : array, shape (f,)
        Angles of neighbours in time. The rough ones hold over some frames; over many they drift.

    Returns
    -------
    array of bool, shape (f,)
    """
    step = float(median(np.abs(np.diff(rough_rad))))
    lag = max(1, math.ceil(APART_RAD / max(step, 1e-9)))
    if len(angle_rad) <= 2 * lag:
        return np.ones(len(angle_rad), bool)
    advance = np.abs(rough_rad[lag:] - rough_rad[:-lag])
    beyond = np.angle(np.exp(1j * (angle_rad - rough_rad)))
    slip = np.abs(np.angle(np.exp(1j * (beyond[lag:] - beyond[:-lag]))))
    most = min(USUAL * float(quantile(slip, 0.25)), FAR_RAD)
    # A plate at rest is not lost either.
    limit = np.maximum(np.minimum(SLIPPING * advance, most), NEAR_RAD)
    goes = slip < limit
    nobody = np.zeros(lag, bool)
    return np.asarray(np.concatenate([nobody, goes]) | np.concatenate([goes, nobody]))


def carried_on(angle_rad: FloatArray, rough_rad: FloatArray, shows: BoolArray) -> FloatArray:
    """The angles, extended from the neighbours to frames that show none, rad, shape (f,).

    Parameters
    ----------
    angle_rad, rough_rad : array, shape (f,)
    shows : array of bool, shape (f,)
        Frames that show their angle, one at least.
    """
    frame = np.arange(len(shows))
    beyond = np.unwrap((angle_rad - rough_rad)[shows])
    return np.where(shows, angle_rad, rough_rad + np.interp(frame, frame[shows], beyond))
