"""Tests of a pose: in range, still, or turning steadily in one attitude.

``PARTS`` means of equal stretches show motion. The statistic is their mean distance from their
median, times two: a jump in mid-pose by d, alternation between two attitudes d apart, and a creep
by 2 d from end to end all give d, as does any other change that moves the mean of the pose by d/2.
"""

import math

import numpy as np

from calib.errors import Remedy, Undetermined, UnusableLog
from calib.numbers import MEDIAN_OF_NORMAL
from calib.poses.data_sheet import LARGEST_SI, TriadSpec
from calib.poses.imu_log import AXES, SI_UNIT, FloatArray
from calib.poses.samples.batches import PARTS, batch_means

FINER = 4
"""Factor in the number of stretches on the turning plate, if a pose has enough samples: a wave that
bends the means of ``PARTS`` is straight over a quarter of their length. Derived."""

RAIL_SHARE = 1e-3
"""Share of the samples at the end of the range. Derived: normal noise cut off there moves its mean
by σ(φ(z) - z p) = 2.8e-4 of its sd, a hundredth of the sd of the mean of 1300 samples; half of the
share by 1.3e-4, twice by 5.8e-4."""
LARGEST_SHIFT_SD = 10.0
"""Number of sds of the noise that the pose itself shows. Derived: of 200,000 poses of white noise
0.8 % stray by more than 5 of it, none by more than 8.4 (a twentieth as many in
``test_no_pose_of_white_noise_strays_by_the_limit_and_some_stray_by_half_of_it``)."""

LARGEST_STILL_SHIFT = {"accelerometer": 0.02, "gyroscope": 0.02}
"""m/s² and rad/s: a tilt of 0.1°, a turn of 1°/s. Smaller shifts are drift, not motion.
A judgement."""

LARGEST_RATE_CHANGE = 0.005
"""Change of the plate's rate, as a share, within a pose and from pose to pose. A judgement: 2.5
times the wow of belt drives (0.2 %), of which whole turns leave little. Half and double contradict
none of 2 ordinary sessions (``tests.bench.contradiction_limits``); what is refused is this change
by definition."""
LARGEST_TURN = 0.005
"""Share of the mean, 0.3°: a sensor placed on a plate by hand and loosened would turn by more. A
judgement."""

MUST_MOVE, STANDS_STILL = 0.5, 0.05
"""Shares of the magnitude: the change that the other axes require of a working axis, and the
largest one of a dead axis. Derived: an error of the data sheet by a third leaves the first,
cross-axis sensitivities of a few per cent move a dead axis by less than the second."""


WANDERS = 4.0
"""Multiple of the median stray of the run's poses. Derived: of 6000 poses of noise that stays
correlated over a fiftieth of a pose to a hundred poses, one in 10⁴ strays by more
(``test_noise_of_any_correlation_strays_by_four_medians_once_in_ten_thousand``)."""

MOST_WANDER = 5.0
"""Multiple of the shift that is accepted if the poses show nothing. Derived: of two directions 1.4°
apart, half of the pose each, the mean is short by 8e-5 of itself."""


CUT = "Start the log when the plate has reached its speed, or cut the log to the steady part."


class SensorMoved(Undetermined):
    """A pose whose readings stray by more than noise, judged by the scatter within it alone."""


def _median(values: FloatArray) -> FloatArray:
    """The median of (b, k) over b; ``np.median`` takes seven times as long for so few values."""
    half = len(values) // 2
    ordered = np.sort(values, axis=0)
    return np.asarray(ordered[half] if len(values) % 2 else (ordered[half - 1] + ordered[half]) / 2)


def _stray(means: FloatArray) -> FloatArray:
    """Stray of ``PARTS`` means (b, k) from their median, as defined above, (k,)."""
    return np.asarray(2 * np.abs(means - _median(means)).mean(axis=0))


def _noise(means: FloatArray) -> float:
    """Sd of the difference between both halves of a pose by noise alone.

    It comes from the median second difference of the batch means (b, k), which neither a few jumps
    nor a steady creep affect: an estimate from the motion itself would hide any motion. The axes
    share it, since a median of so few would often be far too small. More, shorter batches are used
    where the remaining waves bend the batch means.
    """
    bends = means[2:] - 2 * means[1:-1] + means[:-2]
    of_batch = _median(np.abs(bends)) / MEDIAN_OF_NORMAL
    # A second difference has 6 variances of a batch; the difference of two halves of b, 4/b.
    return math.sqrt(np.mean(of_batch**2) / 6 * 4 / len(means))


def check_range(label: str, triad: str, counts: FloatArray, spec: TriadSpec) -> None:
    """Refuse counts (t, 3) outside the converter's range, or of a size that no sensor reads.

    Raises
    ------
    UnusableLog
        With what the data sheet may have wrong.
    """
    low, high = spec.count_range
    lowest, highest = counts.min(), counts.max()
    if lowest < low or highest > high:
        span = f"{lowest:g} to {highest:g}"
        other = "twos-complement" if lowest < 0 else "unsigned-twos-complement, offset-binary"
        raise UnusableLog(
            f"{label}: {triad} counts run from {span}, but {spec.bits} bit {spec.encoding} spans "
            f"{low:g} to {high:g}. Is the encoding {other}, or the number of bits another? "
            f"State encoding and bits as the data sheet has them.",
            Remedy("data_sheet", triad),
        )
    largest = max(-lowest, highest) * spec.nominal_scale
    if largest >= LARGEST_SI:
        raise UnusableLog(f"{label}: the {triad} reads {largest:.3g} {SI_UNIT[triad]}, "
                          f"which no sensor does. Correct the damaged row.")


def check_counts(label: str, triad: str, counts: FloatArray, spec: TriadSpec) -> None:
    """Refuse counts (t, 3) outside the converter's range, or saturated at its ends.

    Raises
    ------
    UnusableLog
        A value that the converter cannot give.
    Undetermined
        An axis is saturated.
    """
    if not len(counts):
        return
    check_range(label, triad, counts, spec)
    low, high = spec.count_range
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
    means = batch_means(values, PARTS)
    return bool((_stray(means) <= _accepted(_noise(means), step, largest_shift)).all())


def stray_of(values: FloatArray) -> FloatArray:
    """Stray of the readings (t, 3) of a pose, as defined above, in their unit, (3,)."""
    return _stray(batch_means(values, PARTS))


def check_still(
    label: str, triad: str, values: FloatArray, step: FloatArray, largest_shift: float,
    usual: FloatArray | float = 0.0,
) -> None:
    """Refuse a pose whose readings (t, 3), SI, stray by more than ``largest_shift`` and noise.

    ``step`` (3,) is that of the converter: alternation between two of its values is no motion.
    ``usual`` (3,) is the stray of the run's other poses, where that is known.
    """
    means = batch_means(values, PARTS)
    stray, limit = _stray(means), _accepted(_noise(means), step, largest_shift, usual)
    axis = int(np.argmax(stray / limit))
    if stray[axis] > limit[axis]:
        unit = SI_UNIT[triad]
        raise SensorMoved(
            f"{label}: the sensor moved: {triad} {AXES[axis]} strays by {stray[axis]:.3g} {unit} "
            f"within the pose, where still poses stray by {limit[axis]:.3g} {unit} at most. Record "
            f"the pose again, or cut the log to the part in which it lay still.",
            Remedy("exclude_pose"),
        )


def _accepted(
    noise: float, step: FloatArray | float, shift: float, usual: FloatArray | float = 0.0
) -> FloatArray:
    """Largest stray of the readings of a still pose, SI, of the shape of ``step``."""
    wandering = np.minimum(WANDERS * np.asarray(usual), MOST_WANDER * shift)
    return np.asarray(np.maximum.reduce(np.broadcast_arrays(
        shift, LARGEST_SHIFT_SD * noise, step, wandering)))


def check_attitude(
    label: str, triad: str, values: FloatArray, step: FloatArray, usual: FloatArray | float = 0.0
) -> None:
    """Refuse a pose on the turning plate that changed its attitude or, for a while, its rate.

    Waves in step with the plate must be removed from ``values`` (t, 3), SI; ``step`` and ``usual``
    as in :func:`check_still`.
    """
    finer = FINER if len(values) >= 2 * FINER * PARTS else 1
    means = batch_means(values, PARTS)
    noise = _noise(means if finer == 1 else batch_means(values, finer * PARTS))
    size = float(np.linalg.norm(values.mean(axis=0)))
    stray, limit = _stray(means), _accepted(noise, step, LARGEST_TURN * size, usual)
    axis = int(np.argmax(stray - limit))
    if stray[axis] > limit[axis]:
        along = means.mean(axis=0) / size
        rate = means @ along
        of_rate = float(_stray(rate[:, None])[0])
        if triad == "gyroscope" and of_rate > _stray(means - np.outer(rate, along)).max():
            raise SensorMoved(
                f"{label}: the plate did not turn steadily: the gyro's rate strays by "
                f"{100 * of_rate / size:.2g} % within the pose, more than its direction does. {CUT}"
            )
        raise SensorMoved(
            f"{label}: the sensor was moved on the turning plate: {triad} {AXES[axis]} strays by "
            f"{stray[axis]:.3g} {SI_UNIT[triad]} within the pose, once what comes back with every "
            f"turn is taken off; {limit[axis]:.3g} {SI_UNIT[triad]} is accepted. Record the pose "
            f"again, or cut the log to the part in which it kept its attitude."
        )


def check_steady(label: str, values: FloatArray) -> None:
    """Refuse a pose of the gyro, (t, 3) rad/s, in which the plate sped up or slowed down."""
    half = len(values) // 2
    first, second = values[:half].mean(axis=0), values[half:].mean(axis=0)
    noise = _noise(batch_means(values, PARTS))
    start, end = float(np.linalg.norm(first)), float(np.linalg.norm(second))
    change = end - start
    limit = max(LARGEST_RATE_CHANGE * start, LARGEST_SHIFT_SD * noise)
    if abs(change) > limit:
        verb = "sped up" if change > 0 else "slowed down"
        raise Undetermined(
            f"{label}: the plate {verb} during the pose: the gyro reads {start:.4g} rad/s in the "
            f"first half and {end:.4g} rad/s in the second ({100 * change / start:+.2f} %, at most "
            f"{100 * limit / start:.1f} % expected). {CUT}"
        )


def check_axes_alive(run: str, triad: str, readings: FloatArray, magnitude: FloatArray) -> None:
    """Refuse poses of a run in which an axis stays constant although the others require a change.

    Two axes leave ``√(m² - a² - b²)`` for the third. Noise does not distinguish a dead axis from a
    working one; its failure to follow does.

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
