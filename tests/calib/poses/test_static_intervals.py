"""Still stretches of one long log: found whatever the units, the noise and the lengths."""

import numpy as np
import pytest

from calib.errors import Undetermined
from calib.poses.imu_log import ImuLog
from calib.poses.static_intervals import find_still, quiet_level, window_variance


def long_log(
    seed: int, poses: int = 12, noise: float = 1.0, rate_hz: float = 100.0
) -> tuple[ImuLog, list[tuple[float, float]]]:
    """Rest of 2.5 to 6 s between movements of 1 to 2 s, and when each rest began and ended."""
    rng = np.random.default_rng(seed)
    parts, spans, now = [], [], 0.0
    level = rng.uniform(-1000, 1000, 3)
    for _ in range(poses):
        rest, move = rng.uniform(2.5, 6.0), rng.uniform(1.0, 2.0)
        spans.append((now, now + rest))
        now += rest + move
        following = rng.uniform(-1000, 1000, 3)
        n = round(move * rate_hz)
        fade = np.linspace(0, 1, n)[:, None]
        shake = 200 * rng.standard_normal((n, 3))
        parts += [np.tile(level, (round(rest * rate_hz), 1)),
                  (1 - fade) * level + fade * following + shake]
        level = following
    values = np.concatenate(parts)
    values = values + noise * rng.standard_normal(values.shape)
    time_s = np.arange(len(values)) / rate_hz
    return ImuLog("log", time_s, values, np.full_like(values, np.nan)), spans


@pytest.mark.parametrize("noise", [0.01, 1.0, 20.0])
@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 400.0])
def test_every_rest_is_found_once_and_lies_inside(noise: float, rate_hz: float) -> None:
    log, spans = long_log(1, noise=noise, rate_hz=rate_hz)
    found = find_still(log)
    assert len(found) == len(spans)
    for pose, (start, end) in zip(found, spans, strict=True):
        assert start - 0.05 <= pose.time_s[0]
        assert pose.time_s[-1] <= end + 0.05
        assert pose.time_s[-1] - pose.time_s[0] > 0.6 * (end - start) - 0.5


def test_the_unit_of_the_log_does_not_matter() -> None:
    log, _ = long_log(2)
    scaled = ImuLog("log", log.time_s, 1e-4 * log.accelerometer, log.gyroscope)
    spans = [[(p.time_s[0], p.time_s[-1]) for p in find_still(each)] for each in (log, scaled)]
    assert spans[0] == spans[1]


def test_the_quiet_level_is_that_of_the_noise_even_when_movement_takes_half_the_log() -> None:
    rng = np.random.default_rng(3)
    still = rng.standard_normal((4000, 3))
    moving = 30 * rng.standard_normal((4000, 3))
    level = quiet_level(window_variance(np.vstack([still, moving]), 100))
    assert level == pytest.approx(3.0, rel=0.15)


def test_a_hand_that_never_rests_long_enough_is_refused() -> None:
    """1.9 s of rest at a time: less its margins, that is no pose of 1.5 s."""
    rng = np.random.default_rng(4)
    n = 4000
    shaken = (np.arange(n) % 220 < 30)[:, None]
    values = np.where(shaken, 300.0, 1.0) * rng.standard_normal((n, 3))
    with pytest.raises(Undetermined, match=r"no stretch of 1\.5 s or more is still"):
        find_still(ImuLog("log", np.arange(n) / 100, values, np.full((n, 3), np.nan)))


def test_a_log_of_a_second_is_refused() -> None:
    rng = np.random.default_rng(5)
    log = ImuLog("log", np.arange(100) / 100, rng.standard_normal((100, 3)),
                 np.full((100, 3), np.nan))
    with pytest.raises(Undetermined, match="too few to look for still poses"):
        find_still(log)
