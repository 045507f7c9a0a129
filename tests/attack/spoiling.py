"""What a mistake does to the samples of some poses, by its dose."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Rng = np.random.Generator


@dataclass
class Where:
    """A triad of some poses of one run, as arrays that a mistake changes in place.

    Attributes
    ----------
    counts : array, shape (p, n, 3)
        About the middle of the converter.
    time_s : array, shape (p, n)
    middle : float
        What was taken off.
    ends : tuple of float
        Of the converter, about its middle.
    """

    triad: str
    counts: np.ndarray
    time_s: np.ndarray
    middle: float
    ends: tuple[float, float]


def tuples(value: Callable[[Where], float]) -> Callable[[Where, float, Rng], None]:
    def do(at: Where, share: float, rng: Rng) -> None:
        at.counts[rng.uniform(size=at.counts.shape[:2]) < share] = value(at)
    return do


def spikes(at: Where, share: float, rng: Rng) -> None:
    noise = np.median(np.abs(np.diff(at.counts, axis=1)), axis=1, keepdims=True) + 1
    hit = rng.uniform(size=at.counts.shape[:2]) < share
    size = rng.uniform(10, 300) * noise * np.array([1.0, 0.0, 0.0])
    at.counts += np.where(hit[..., None], size, 0.0)


def gain_of(at: Where, dose: float, _rng: Rng) -> None:
    at.counts *= dose


def other_unit(at: Where, dose: float, _rng: Rng) -> None:
    """Another sensor of the same type."""
    at.counts *= 1 - dose * np.array([1.0, -0.7, 0.5])
    at.counts += dose * np.abs(at.counts).max() * np.array([0.3, -0.5, 0.2])


def exchange(at: Where, _dose: float, rng: Rng) -> None:
    order = rng.choice([(1, 0, 2), (0, 2, 1), (2, 1, 0)])
    at.counts[:] = at.counts[..., order]


def mirror(at: Where, _dose: float, rng: Rng) -> None:
    at.counts[..., int(rng.integers(3))] *= -1


def turned(first: float, last: float) -> Callable[[Where, float, Rng], None]:
    """Lies otherwise from one share of the pose to another."""
    def do(at: Where, degrees: float, _rng: Rng) -> None:
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        n = at.counts.shape[1]
        part = slice(int(first * n), int(last * n))
        at.counts[:, part] = at.counts[:, part] @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
    return do


def freeze(at: Where, share: float, rng: Rng) -> None:
    n = at.counts.shape[1]
    length = max(2, round(share * n))
    first = int(rng.integers(0, n - length + 1))
    at.counts[:, first : first + length] = at.counts[:, first : first + 1]


def clip(at: Where, share: float, _rng: Rng) -> None:
    limit = (1 - share) * np.abs(at.counts).max()
    np.clip(at.counts, -limit, limit, out=at.counts)


def add_constant(at: Where, dose: float, _rng: Rng) -> None:
    """Another bias in these poses, in counts of the noise of a sample."""
    at.counts += dose * np.median(np.abs(np.diff(at.counts, axis=1))) * np.array([1.0, -0.5, 0.3])


def stretch(at: Where, dose: float, _rng: Rng) -> None:
    at.time_s[:] = at.time_s[:, :1] + dose * (at.time_s - at.time_s[:, :1])


def gap(at: Where, share: float, rng: Rng) -> None:
    """Some seconds were not logged."""
    n = at.counts.shape[1]
    first = int(rng.integers(n // 4, n // 2))
    at.time_s[:, first:] += share * (at.time_s[:, -1:] - at.time_s[:, :1])


def copy_the_first(at: Where, share: float, _rng: Rng) -> None:
    """The end of the first pose stands in the others."""
    length = max(1, round(share * at.counts.shape[1]))
    at.counts[1:, -length:] = at.counts[0, -length:]


def deaden(at: Where, _dose: float, rng: Rng) -> None:
    axis = int(rng.integers(3))
    at.counts[..., axis] = np.rint(rng.normal(0, 10, at.counts.shape[:2]))


def spin_up(at: Where, share: float, _rng: Rng) -> None:
    """The plate was not yet at its rate when the log began."""
    n = at.counts.shape[1]
    first = max(2, round(share * n))
    at.counts[:, :first] *= np.linspace(0, 1, first)[:, None]


def creep(at: Where, dose: float, _rng: Rng) -> None:
    """A ramp along each pose, in counts of the noise of a sample."""
    ramp = np.linspace(-0.5, 0.5, at.counts.shape[1])[:, None] * np.array([1.0, -0.5, 0.3])
    at.counts += dose * np.median(np.abs(np.diff(at.counts, axis=1))) * ramp


def held(at: Where, dose: float, _rng: Rng) -> None:
    """Each reading stands in several rows."""
    times = round(dose)
    at.counts[:] = np.repeat(at.counts[:, ::times], times, axis=1)[:, : at.counts.shape[1]]


def coarse(at: Where, dose: float, _rng: Rng) -> None:
    """The log was rounded, to so many times the noise of a sample."""
    step = max(1.0, np.rint(dose * np.median(np.abs(np.diff(at.counts, axis=1)))))
    at.counts[:] = np.rint(at.counts / step) * step


def hum(at: Where, dose: float, rng: Rng) -> None:
    """A sine of 3 to 20 Hz, in counts of the noise of a sample."""
    size = dose * np.median(np.abs(np.diff(at.counts, axis=1)))
    phase = 2 * np.pi * (rng.uniform(3, 20) * (at.time_s - at.time_s[:, :1]) + rng.uniform())
    at.counts += size * np.sin(phase)[..., None] * np.array([1.0, -0.5, 0.3])


def mix_with_next(at: Where, share: float, _rng: Rng) -> None:
    """The end of each pose is of the next one."""
    first = round((1 - share) * at.counts.shape[1])
    at.counts[:, first:] = np.roll(at.counts[:, first:], 1, axis=0)


def take_from_next(at: Where, _dose: float, _rng: Rng) -> None:
    """One triad's readings of each pose stand beside the other's of the next."""
    at.counts[:] = np.roll(at.counts, 1, axis=0)


def backwards(at: Where, _dose: float, _rng: Rng) -> None:
    at.time_s[:] = at.time_s[:, ::-1].copy()
