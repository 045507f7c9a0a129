"""Whether a pose is one: in range, still, or turning steadily in one attitude.

``SHORT_BATCHES`` means of equal stretches show motion. What counts is by how much they stray from
their median on average, times two: a jump in mid-pose by d, to and fro between two attitudes d
apart, and a creep by 2 d from end to end all come out as d, as does whatever else pulls the mean
of the pose by d/2.
"""

import math

import numpy as np

from calib.errors import Remedy, Undetermined, UnusableLog
from calib.poses.batches import batch_means
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import AXES, SI_UNIT, FloatArray

SHORT_BATCHES = 12  #: stretches of a pose; derived: twice the batches of its sd
MEDIAN_OF_NORMAL = 0.6745
"""Median of the absolute value of a standard normal variable."""

FINER = 4  #: times as many stretches where a pose has the samples for it
RAIL_SHARE = 1e-3
"""Of the samples, at the end of the range. Derived: normal noise cut off there moves its mean by
σ(φ(z) - z p) = 2.8e-4 of its sd, a hundredth of the sd of the mean of 1300 samples; half of the
share by 1.3e-4, twice by 5.8e-4."""
LARGEST_SHIFT_SD = 10.0  #: of the noise of the means: far beyond what noise does
LARGEST_STILL_SHIFT = {"accelerometer": 0.02, "gyroscope": 0.02}
"""m/s² and rad/s: a tilt of 0.1°, a turn of 1°/s. Smaller shifts are drift, not motion."""

LARGEST_RATE_CHANGE = 0.005
"""Of the plate's rate, within a pose and from pose to pose. A judgement: 2.5 times the wow of belt
drives (0.2 %), of which whole turns leave little. Half and double contradict none of 2 ordinary
sessions (``tests.bench.contradiction_limits``); what is refused is this change by definition."""
LARGEST_TURN = 0.005
"""Of the mean, 0.3°: what is laid on a plate by hand and loosened would turn by more."""


MUST_MOVE, STANDS_STILL = 0.5, 0.05
"""Of the magnitude: what the other axes demand of one that is alive, and how little a dead one
moves. Derived: an error of the data sheet by a third leaves the first, cross-axis sensitivities of
a few per cent move a dead axis by less than the second."""


class SensorMoved(Undetermined):
    """A pose at rest whose readings stray by more than noise, by the scatter within it alone."""


def _stray(values: FloatArray, finer: int = 1) -> tuple[FloatArray, FloatArray]:
    """How far batch means stray from their median, as the module says, and by noise alone, (k,).

    The noise is the sd that the difference of both halves has. It comes from the median second
    difference of the batch means, which neither a few jumps nor a steady creep enter: measured by
    the motion itself, no motion would be large. The axes share it, since a median of so few would
    often come out far too small. ``finer`` times as many batches, each of so much less, show it
    where what is left of waves bends the batch means.
    """
    means = batch_means(values, SHORT_BATCHES)
    count = finer * SHORT_BATCHES
    bends = np.diff(batch_means(values, count), n=2, axis=0)
    of_batch = np.median(np.abs(bends), axis=0) / MEDIAN_OF_NORMAL
    noise = math.sqrt(np.mean(of_batch**2) / 6 * 4 / count)
    return 2 * np.abs(means - np.median(means, axis=0)).mean(axis=0), np.full(means.shape[1], noise)


def check_counts(label: str, triad: str, counts: FloatArray, spec: TriadSpec) -> None:
    """Refuse counts (t, 3) that the converter cannot give, or that stand at its rails."""
    low, high = spec.count_range
    if counts.min() < low or counts.max() > high:
        span = f"{counts.min():g} to {counts.max():g}"
        other = "twos-complement" if counts.min() < 0 else "unsigned-twos-complement, offset-binary"
        raise UnusableLog(
            f"{label}: {triad} counts run from {span}, but {spec.bits} bit {spec.encoding} spans "
            f"{low:g} to {high:g}. Is the encoding {other}, or the number of bits another? "
            f"State encoding and bits as the data sheet has them.",
            Remedy("data_sheet", triad),
        )
    at_rail = (counts <= low) | (counts >= high)
    share = at_rail.mean(axis=0)
    if share.max() > RAIL_SHARE:
        axis = AXES[int(np.argmax(share))]
        raise Undetermined(
            f"{label}: {triad} {axis} is saturated: {100 * share.max():.1f} % of its samples "
            f"stand at the end of the range ({low:g} or {high:g} counts). The true value is "
            f"unknown there; choose a larger full scale or a slower plate, and record the pose "
            f"again."
        )


def is_still(values: FloatArray, step: FloatArray | float, largest_shift: float) -> bool:
    """Whether readings (t, 3), SI, pass :func:`check_still`; ``step`` may be one for all axes."""
    stray, noise = _stray(values)
    return bool((stray <= _accepted(noise, step, largest_shift)).all())


def check_still(
    label: str, triad: str, values: FloatArray, step: FloatArray, largest_shift: float
) -> None:
    """Refuse a pose whose readings (t, 3), SI, stray by more than ``largest_shift`` and noise.

    ``step`` (3,) is that of the converter: to and fro between two of its values is no motion.
    """
    stray, noise = _stray(values)
    limit = _accepted(noise, step, largest_shift)
    axis = int(np.argmax(stray / limit))
    if stray[axis] > limit[axis]:
        unit = SI_UNIT[triad]
        raise SensorMoved(
            f"{label}: the sensor moved: {triad} {AXES[axis]} strays by {stray[axis]:.3g} {unit} "
            f"within the pose, where still poses stray by {limit[axis]:.2g} {unit} at most. Record "
            f"the pose again, or cut the log to the part in which it lay still."
        )


def _accepted(noise: FloatArray, step: FloatArray | float, shift: float) -> FloatArray:
    """By how much the readings of a still pose may stray, (3,), SI."""
    return np.asarray(np.maximum(np.maximum(shift, LARGEST_SHIFT_SD * noise), step))


def check_attitude(label: str, triad: str, values: FloatArray, step: FloatArray) -> None:
    """Refuse a pose on the turning plate that changed its attitude; ``values`` (t, 3), SI.

    What comes back with every turn must be off them; ``step`` as in :func:`check_still`.
    """
    finer = FINER if len(values) >= 2 * FINER * SHORT_BATCHES else 1
    stray, noise = _stray(values, finer)
    size = float(np.linalg.norm(values.mean(axis=0)))
    limit = _accepted(noise, step, LARGEST_TURN * size)
    axis = int(np.argmax(stray - limit))
    if stray[axis] > limit[axis]:
        raise Undetermined(
            f"{label}: the sensor was moved on the turning plate: {triad} {AXES[axis]} strays by "
            f"{stray[axis]:.3g} {SI_UNIT[triad]} within the pose, once what comes back with every "
            f"turn is taken off; {limit[axis]:.2g} {SI_UNIT[triad]} is accepted. Record the pose "
            f"again, or cut the log to the part in which it kept its attitude."
        )


def check_steady(label: str, values: FloatArray) -> None:
    """Refuse a pose of the gyro, (t, 3) rad/s, in which the plate sped up or slowed down."""
    half = len(values) // 2
    first, second = values[:half].mean(axis=0), values[half:].mean(axis=0)
    noise = float(_stray(values)[1].max())
    start, end = float(np.linalg.norm(first)), float(np.linalg.norm(second))
    change = end - start
    limit = max(LARGEST_RATE_CHANGE * start, LARGEST_SHIFT_SD * noise)
    if abs(change) > limit:
        verb = "sped up" if change > 0 else "slowed down"
        raise Undetermined(
            f"{label}: the plate {verb} during the pose: the gyro reads {start:.4g} rad/s in the "
            f"first half and {end:.4g} rad/s in the second ({100 * change / start:+.2f} %, at most "
            f"{100 * limit / start:.1f} % expected). Start the log when the plate has reached its "
            f"speed, or cut the log to the steady part."
        )


def check_axes_alive(run: str, triad: str, readings: FloatArray, magnitude: FloatArray) -> None:
    """Refuse poses of a run in which an axis stays where it is while the others demand a change.

    Two axes leave ``√(m² - a² - b²)`` for the third. Its noise does not tell a dead axis from one
    that is alive; that it does not follow does.

    Parameters
    ----------
    readings : array, shape (n, 3)
        Pose means by the data sheet, SI.
    magnitude : array, shape (n,)
        Of gravity or of the plate's rate, SI.
    """
    share = readings / magnitude[:, None]
    for k, axis in enumerate(AXES):
        others = np.delete(share, k, axis=1)
        demanded = np.sqrt(np.clip(1 - (others**2).sum(axis=1), 0.0, None))
        if np.ptp(demanded) > MUST_MOVE and np.ptp(share[:, k]) < STANDS_STILL:
            unit = SI_UNIT[triad]
            raise Undetermined(
                f"{run}: {triad} {axis} is dead: it reads {readings[:, k].min():.3g} to "
                f"{readings[:, k].max():.3g} {unit} in all {len(readings)} poses, where the other "
                f"axes leave up to {(demanded * magnitude).max():.3g} {unit} for it. Check its "
                f"wiring, and whether its column is that of the axis."
            )
