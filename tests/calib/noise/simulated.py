"""Noise with known coefficients, by recursion and by a filter in the frequency domain."""

import numpy as np


def noise(
    rng: np.random.Generator, count: int, step_s: float, density: float, flicker: float,
    walk: float,
) -> np.ndarray:
    """White noise, 1/f noise and a random walk, shape (count,).

    Two-sided densities: N², B²/(2π|f|) and (K/2πf)². The 1/f noise is cut from a record four times
    as long, so that it has the frequencies below the record's own.
    """
    white = density / np.sqrt(step_s) * rng.standard_normal(count)
    wander = walk * np.sqrt(step_s) * np.cumsum(rng.standard_normal(count))
    longer = 4 * count
    f = np.fft.rfftfreq(longer, step_s)
    gain = np.zeros_like(f)
    gain[1:] = flicker / np.sqrt(2 * np.pi * f[1:] * step_s)
    pink = np.fft.irfft(np.fft.rfft(rng.standard_normal(longer)) * gain, longer)[:count]
    return np.asarray(white + wander + pink)
