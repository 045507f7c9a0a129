"""Sessions of pose means whose truth is known, and how far their stated sds hold."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from calib.poses.averaging.average_pose import average_pose
from calib.poses.averaging.common_course import without_course
from calib.poses.averaging.correlation import correlation_of
from calib.poses.averaging.mean_noise import pose_mean_sd, too_short
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, ImuLog

RATE_HZ = 100.0
NOISE_M_S2 = 1e-3
IN_SI = TriadSpec(np.inf, 0, "si")
POSES, SESSIONS = 26, 60


@dataclass(frozen=True)
class Held:
    """What one line prints; see the module's docstring."""

    covered: float
    spread: float
    factor: float
    factor_sd: float
    noted: float


def session(
    seconds: float, tau_s: float, white: float, seed: int, step: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Samples (p, t, 3) of one session's poses and their truth (p, 1, 3), m/s².

    Gauss-Markov noise of ``NOISE_M_S2`` with the correlation time ``tau_s``, white noise of
    ``white`` times that, rounded to ``step`` times it.
    """
    rng = np.random.default_rng([seed, round(10 * seconds), round(100 * tau_s), round(white)])
    n, settling = round(seconds * RATE_HZ), round(8 * tau_s * RATE_HZ)
    keep = np.exp(-1 / RATE_HZ / tau_s)
    kicks = np.sqrt(1 - keep**2) * rng.standard_normal((POSES, n + settling, 3))
    slow = lfilter([1.0], [1.0, -keep], kicks, axis=1)[:, -n:]
    truth = rng.uniform(-9.8, 9.8, (POSES, 1, 3))
    values = truth + NOISE_M_S2 * (slow + white * rng.standard_normal(slow.shape))
    if step:
        values = np.rint(values / (step * NOISE_M_S2)) * (step * NOISE_M_S2)
    return values, truth


def coverage(
    seconds: float, tau_s: float, white: float, step: float = 0.0, sessions: int = SESSIONS
) -> Held:
    """Average, state sds and compare with the truth."""
    scores, factors, noted = [], [], 0
    for seed in range(sessions):
        values, truth = session(seconds, tau_s, white, seed, step)
        time_s = np.arange(values.shape[1]) / RATE_HZ
        absent = np.full(values.shape[1:], np.nan)
        means = [average_pose(ImuLog("pose", time_s, v, absent), {"accelerometer": IN_SI})
                 for v in values]
        sd = pose_mean_sd([means], "accelerometer")
        error = np.array([mean.accelerometer.mean for mean in means]) - truth[:, 0]
        scores.append(error / sd)
        bare = without_course(means, "accelerometer")
        factors.append(correlation_of(bare, "accelerometer").factor)
        noted += too_short(means, "accelerometer", "run") is not None
    z = np.array(scores)
    return Held(float(np.mean(np.abs(z) < 1.96)), float(z.std()), float(np.mean(factors)),
                float(np.std(factors)), noted / sessions)  # fmt: skip
