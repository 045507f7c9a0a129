"""The sensor as it physically is: sensitive axes, gains, noise, and a converter to integer counts.

Nothing here knows the calibration model. An axis is a unit vector in the case along which the part
is sensitive; it delivers ``gain`` counts per unit of what lies along that vector, on top of
``offset`` counts, with noise, through a low pass, rounded to whole counts and stopped at the rails.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

FloatArray = NDArray[np.float64]

G_STANDARD = 9.80665  # m/s², the g of data sheets


@dataclass(frozen=True, eq=False)
class Triad:
    """Three axes of one kind (accelerometers in m/s², gyroscopes in rad/s).

    Parameters
    ----------
    axes : array, shape (3, 3)
        Unit sensitive-axis directions in the case frame, one row per axis; not orthogonal.
    gain : array, shape (3,)
        Counts per unit along the sensitive axis.
    offset : array, shape (3,)
        Counts at zero input.
    white_sd : float
        Standard deviation of the white noise of one sample, in counts, ahead of the low pass.
    slow_sd, slow_tau_s : float
        First-order Gauss-Markov bias: its standard deviation in counts, its time constant.
    bits : int
        Width of the converter.
    offset_binary : bool
        True: counts 0 ... 2^bits - 1; False: two's complement, -2^(bits-1) ... 2^(bits-1) - 1.
    full_scale : float
        Full scale that the data sheet states, in the unit of the triad.
    bandwidth_hz : float
        Corner of the first-order anti-alias low pass; infinite for none.
    step_counts : int
        Counts between two values that the converter delivers: 16 is a converter of four bits less.
    truncates : bool
        Whether a logger cuts to these values toward zero, instead of a converter that rounds.
    dead_band : float
        What an axis does not answer to, in the unit of the triad; beyond, it answers by that less.
    """

    axes: FloatArray
    gain: FloatArray
    offset: FloatArray
    white_sd: float
    slow_sd: float
    slow_tau_s: float
    bits: int
    offset_binary: bool
    full_scale: float
    bandwidth_hz: float = np.inf
    step_counts: int = 1
    truncates: bool = False
    dead_band: float = 0.0

    def __post_init__(self) -> None:
        if not np.allclose(np.linalg.norm(self.axes, axis=1), 1, atol=1e-12):
            raise ValueError("sensitive axes are unit vectors")

    @property
    def rails(self) -> tuple[int, int]:
        """Lowest and highest count that the converter can deliver."""
        span = 2**self.bits
        return (0, span - 1) if self.offset_binary else (-span // 2, span // 2 - 1)

    def project(self, vector: FloatArray) -> FloatArray:
        """What lies along each sensitive axis, shape (..., 3), of vectors in the case frame."""
        return vector @ self.axes.T

    def convert(
        self, along_axes: FloatArray, time_s: FloatArray, rng: np.random.Generator
    ) -> NDArray[np.int64]:
        """Counts, shape (p, n, 3), for what acts along the axes in p poses of n samples.

        ``time_s`` (p, n) is one clock through all poses: the slow part of the noise runs on
        between them.
        """
        analogue = along_axes - np.clip(along_axes, -self.dead_band, self.dead_band)
        analogue *= self.gain
        analogue += self.offset
        analogue += self.white_sd * rng.standard_normal(analogue.shape)
        if self.slow_sd > 0:
            analogue += gauss_markov(time_s, self.slow_sd, self.slow_tau_s, rng)
        if np.isfinite(self.bandwidth_hz):
            analogue = low_pass(analogue, self.bandwidth_hz * (time_s[0, 1] - time_s[0, 0]))
        whole = np.trunc if self.truncates else np.rint
        steps = whole(analogue / self.step_counts) * self.step_counts
        return np.clip(steps, *self.rails).astype(np.int64)

    def pose_mean_sd(self, samples: int, interval_s: float) -> FloatArray:
        """Standard deviation (3,) of the mean of a still pose, in the unit of the triad.

        White and rounding noise fall with the number of samples; the mean over T of a
        Gauss-Markov process has variance ``2 s² (τ/T) (1 - (τ/T) (1 - exp(-T/τ)))``.
        """
        x = self.slow_tau_s / (samples * interval_s)
        slow = 2 * self.slow_sd**2 * x * (1 + x * np.expm1(-1 / x))
        return np.sqrt((self.white_sd**2 + 1 / 12) / samples + slow) / self.gain


@dataclass(frozen=True, eq=False)
class Sensor:
    """One inertial measurement unit.

    Parameters
    ----------
    name : str
    accelerometer, gyroscope : Triad
        In m/s² and rad/s.
    chip_m : array, shape (3,)
        Where the accelerometers sit in the case, from the point of the case that the experimenter
        puts over the spindle.
    """

    name: str
    accelerometer: Triad
    gyroscope: Triad
    chip_m: FloatArray

    def with_noise(self, factor: float) -> "Sensor":
        """The same unit with all its noise scaled; 0 leaves the rounding alone."""

        def scaled(triad: Triad) -> Triad:
            return replace(triad, white_sd=triad.white_sd * factor, slow_sd=triad.slow_sd * factor)

        return replace(
            self,
            accelerometer=scaled(self.accelerometer),
            gyroscope=scaled(self.gyroscope),
        )


def gauss_markov(
    time_s: FloatArray, sd: float, tau_s: float, rng: np.random.Generator
) -> FloatArray:
    """First-order Gauss-Markov process on three axes, shape (p, n, 3), exact at any spacing.

    ``time_s`` (p, n) is evenly spaced inside a pose (row) and increases from row to row.
    """
    poses, samples = time_s.shape
    keep = np.exp(-(time_s[0, 1] - time_s[0, 0]) / tau_s)
    kick = sd * np.sqrt(1 - keep**2) * rng.standard_normal((poses, samples, 3))
    kick[:, 0] = 0.0  # the first sample of a pose is the start drawn below
    driven = lfilter([1.0], [1.0, -keep], kick, axis=1)
    start = np.empty((poses, 3))
    draw = rng.standard_normal((poses, 3))
    start[0] = sd * draw[0]
    for i in range(1, poses):
        gap = np.exp(-(time_s[i, 0] - time_s[i - 1, -1]) / tau_s)
        end = driven[i - 1, -1] + keep ** (samples - 1) * start[i - 1]
        start[i] = gap * end + sd * np.sqrt(1 - gap**2) * draw[i]
    return driven + keep ** np.arange(samples)[:, None] * start[:, None, :]


def low_pass(analogue: FloatArray, corner: float) -> FloatArray:
    """First-order low pass along the samples (axis 1); ``corner`` is in cycles per sample."""
    keep = np.exp(-2 * np.pi * corner)
    settled = keep * analogue[:, :1]  # the filter has been running before the pose begins
    return lfilter([1 - keep], [1.0, -keep], analogue, axis=1, zi=settled)[0]


def sensitive_axes(tilt_rad: ArrayLike, mounting_rad: ArrayLike = (0.0, 0.0, 0.0)) -> FloatArray:
    """Unit axes (rows) that lean towards one another by small angles.

    ``tilt_rad`` lists how far y leans towards z, x towards z, x towards y; ``mounting_rad`` is the
    rotation vector by which the whole triad is turned in the case.
    """
    yz, xz, xy = np.asarray(tilt_rad, float)
    lean = np.array([[1.0, xy, xz], [0.0, 1.0, yz], [0.0, 0.0, 1.0]])
    turned = lean @ Rotation.from_rotvec(mounting_rad).as_matrix().T
    return turned / np.linalg.norm(turned, axis=1)[:, None]


@dataclass(frozen=True)
class Spread:
    """How far one unit of a production run lies from the next (one standard deviation)."""

    gain: float  # relative
    offset: float  # relative to half the converter's span
    tilt_rad: float
    mounting_rad: float


MTI_SPREAD = Spread(gain=0.02, offset=0.03, tilt_rad=0.008, mounting_rad=0.005)
MPU_SPREAD = Spread(gain=0.015, offset=0.004, tilt_rad=0.010, mounting_rad=0.005)


def mti() -> Sensor:
    """Xsens MTi with gains and offsets of its certificate (Angrisano et al., tables 1 and 3).

    The lean of the axes is what those tables measured, read in radians (with the sd of one arc
    minute they state, degrees would be no misalignment at all). Noise: 0.012 m/s² and 0.6 °/s per
    sample at 100 Hz. The slow part makes the mean of an 8 s still pose 3.1 times as uncertain as
    white noise alone, as in a public log of this model of sensor, and of the gyroscope 1.2 times.
    """
    return Sensor(
        name="Xsens MTi",
        accelerometer=Triad(
            axes=sensitive_axes((0.0135, 0.0036, -0.0005)),
            gain=np.array([549.7, 552.7, 550.4]),
            offset=np.array([33652.0, 33395.0, 32034.0]),
            white_sd=6.6,
            slow_sd=2.0,
            slow_tau_s=0.5,
            bits=16,
            offset_binary=True,
            full_scale=50.0,
        ),
        gyroscope=Triad(
            axes=sensitive_axes((0.0089, 0.0026, -0.0130), (0.0041, -0.0063, 0.0052)),
            gain=np.array([9651.0, 9402.0, 9417.0]),
            offset=np.array([28575.0, 36338.0, 34681.0]),
            white_sd=100.0,
            slow_sd=6.0,
            slow_tau_s=0.5,
            bits=16,
            offset_binary=True,
            full_scale=np.deg2rad(150.0),
        ),
        chip_m=np.array([0.006, -0.004, 0.009]),
    )


def mpu6050() -> Sensor:
    """InvenSense MPU-6050 at ±2 g, ±250 °/s, 42 Hz low pass; figures of its data sheet's order.

    Gains within 2 % of 16384 counts per g and 131 counts per °/s, axes leaning by up to 1.5 %,
    0.03 m/s² and 0.08 °/s per sample, and a slow gyroscope bias of 0.02 °/s.
    """
    return Sensor(
        name="InvenSense MPU-6050",
        accelerometer=Triad(
            axes=sensitive_axes((-0.0061, 0.0112, 0.0047)),
            gain=16384 / G_STANDARD * np.array([0.988, 1.006, 1.017]),
            offset=np.array([-236.0, 158.0, 571.0]),
            white_sd=50.0,
            slow_sd=15.0,
            slow_tau_s=0.5,
            bits=16,
            offset_binary=False,
            full_scale=2 * G_STANDARD,
            bandwidth_hz=42.0,
        ),
        gyroscope=Triad(
            axes=sensitive_axes((0.0094, -0.0052, 0.0128), (-0.0083, 0.0037, 0.0118)),
            gain=np.rad2deg(131.072) * np.array([1.012, 0.991, 1.005]),
            offset=np.array([-52.0, -297.0, 75.0]),
            white_sd=11.0,
            slow_sd=3.0,
            slow_tau_s=0.5,
            bits=16,
            offset_binary=False,
            full_scale=np.deg2rad(250.0),
            bandwidth_hz=42.0,
        ),
        chip_m=np.array([0.003, -0.002, 0.001]),
    )


def another_unit(sensor: Sensor, spread: Spread, rng: np.random.Generator) -> Sensor:
    """Another unit of the same production run: gains, offsets and axes drawn about ``sensor``'s."""

    def drawn(triad: Triad) -> Triad:
        lean = Rotation.from_rotvec(spread.mounting_rad * rng.standard_normal(3)).as_matrix()
        axes = triad.axes @ lean.T + spread.tilt_rad * np.triu(rng.standard_normal((3, 3)), 1)
        half_span = 2 ** (triad.bits - 1)
        return replace(
            triad,
            axes=axes / np.linalg.norm(axes, axis=1)[:, None],
            gain=triad.gain * (1 + spread.gain * rng.standard_normal(3)),
            offset=triad.offset + spread.offset * half_span * rng.standard_normal(3),
        )

    return replace(
        sensor,
        accelerometer=drawn(sensor.accelerometer),
        gyroscope=drawn(sensor.gyroscope),
    )
