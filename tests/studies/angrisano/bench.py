"""A small bench for the study of the paper: what its sensor would have logged in its poses.

Forward physics only, no formula of the solver: sensitive axes are unit vectors, a reading is the
projection of what acts on them, times a gain, plus an offset, plus noise, rounded to counts. What
the publication calls alpha, b and k is read off the finished sensor by linear algebra.
"""

import math
from dataclasses import dataclass

import numpy as np

from calib.consistency.certificate import frame_free
from calib.fit.parameters import TriadParameters
from calib.poses.attitudes import natural_directions
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, ImuLog, Triad

SAMPLE_RATE_HZ = 100.0
PAUSE_S = 30.0
"""Between two poses, to lay the next."""


def leaning_axes(theta_rad: FloatArray) -> FloatArray:
    """Sensitive axes that are not at right angles, one unit row per axis, shape (3, 3).

    The direction cosines of eq. (13) for the geometry of figure 2, eq. (14): x_a coincides with
    x_p, y_a lies in the plane of x_p and y_p. The third column of eq. (14) as printed has the
    squared length ``1 - sin² θ_x sin² θ_y``; here it is made a unit vector.
    """
    x, y, z = theta_rad
    axes = np.array(
        [
            [1.0, 0.0, 0.0],
            [math.sin(z), math.cos(z), 0.0],
            [math.cos(x) * math.sin(y), math.cos(y) * math.sin(x), math.cos(x) * math.cos(y)],
        ]
    )
    return np.asarray(axes / np.linalg.norm(axes, axis=1, keepdims=True))


def wedge_directions() -> FloatArray:
    """The 6 faces and 12 edges of :func:`natural_directions` from +x to -x, shape (18, 3).

    The order belongs to the seeds: every pose has its own draw of what lays it askew.
    """
    wedge = natural_directions(corners=False)
    return np.asarray(wedge[np.lexsort(-np.sign(wedge).T[::-1])])


def laid_directions(accuracy_rad: float, rng: np.random.Generator) -> FloatArray:
    """The wedge's directions, each off by ``accuracy_rad`` (sd about two axes), shape (18, 3)."""
    wedge = wedge_directions()
    slip = accuracy_rad * rng.standard_normal(wedge.shape)
    laid = wedge + np.cross(slip, wedge)
    return np.asarray(laid / np.linalg.norm(laid, axis=1, keepdims=True))


@dataclass(frozen=True, eq=False)
class BenchTriad:
    """Three axes of one kind.

    Parameters
    ----------
    kind : str
        ``accelerometer`` or ``gyroscope``.
    spec : TriadSpec
    axes : array, shape (3, 3)
        Unit sensitive axes in the case, by rows.
    gain, offset : array, shape (3,)
        Counts per unit along the axis, counts at zero input.
    """

    kind: Triad
    spec: TriadSpec
    axes: FloatArray
    gain: FloatArray
    offset: FloatArray

    def truth(self) -> TriadParameters:
        """What a perfect calibration by magnitudes reports, without covariance.

        Magnitudes determine the inverse of ``gain * axes`` up to a rotation from the left.
        """
        scale, alpha = frame_free(self.gain, self.axes)
        return TriadParameters(alpha, self.offset, scale, np.full((9, 9), np.nan))

    def readings(self, vectors: FloatArray) -> FloatArray:
        """Noiseless counts, not rounded, for what acts in the case, (n, 3)."""
        return np.asarray(vectors @ self.axes.T * self.gain + self.offset)

    def logs(
        self, vectors: FloatArray, seconds: float, mean_sd: float, rng: np.random.Generator
    ) -> list[ImuLog]:
        """One log per pose in which ``vectors`` (n, 3) act; a pose's mean has the sd ``mean_sd``.

        The noise is white: whatever made the published poses as uncertain as they were, the
        solver is to meet it with the sd it has.
        """
        samples = round(seconds * SAMPLE_RATE_HZ)
        noise_sd = mean_sd * math.sqrt(samples) * self.gain
        found = []
        for i, reading in enumerate(self.readings(vectors)):
            noise = noise_sd * rng.standard_normal((samples, 3))
            counts = np.clip(np.round(reading + noise), *self.spec.count_range)
            blank = np.full_like(counts, np.nan)
            time_s = np.arange(samples) / SAMPLE_RATE_HZ + i * (seconds + PAUSE_S)
            felt = (counts, blank) if self.kind == "accelerometer" else (blank, counts)
            found.append(ImuLog(f"pose {i + 1}", time_s, *felt))
        return found
