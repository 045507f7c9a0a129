"""How large a hidden effect is in each evening of a lot, in noise units over the pose equations."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tests.world.imu import FloatArray

if TYPE_CHECKING:
    from tests.world.lot import LotPlan

IntArray = NDArray[np.int64]


GAINS = ("_scale", "scale_drift", "reference_drift")  #: what is a gain where nothing varies
BIASES = ("_bias", "bias_drift", "warm_up", "wander", "periodic")  #: what is a bias there


def rows_of(name: str, each: FloatArray, whitening: FloatArray) -> FloatArray:
    """What an effect adds to the pose equations per unit of each size, noise units, (S, n, k).

    Of one that is a bias or a gain where nothing varies it is how it varies. ``each`` (S, n, 3, k)
    are its errors, ``whitening`` (S, n, 3) what the equations have of an error, along the reading.
    """
    if name.endswith(BIASES) or name.startswith("column:"):
        each = each - each.mean(axis=1, keepdims=True)
    elif name.endswith(GAINS):
        reading = np.where(each != 0, whitening[..., None], 0.0)
        gain = (each * reading).sum(axis=(1, 2)) / (reading**2).sum(axis=(1, 2))
        each = each - gain[:, None, None] * reading
    return np.einsum("sni,snik->snk", whitening, each)


def sizes_of(
    plan: "LotPlan", unit: IntArray, rows: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Sizes (S, k) of the evenings of the sensors ``unit`` (S,); ``rows`` as of :func:`rows_of`."""
    if plan.cauchy_sd is not None:
        return _cauchy_sizes(plan.cauchy_sd, rows, rng)
    if plan.own_sd is None:
        return _sizes(plan, rows, rng)[unit]
    return _own_sizes(plan.own_sd, rows, rng)


def _sizes(plan: "LotPlan", rows: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Sizes (sensors, k): one for all, and a spread, each of the root mean square asked for."""
    k = rows.shape[2]

    def of_size(wanted: float, direction: FloatArray) -> FloatArray:
        rms = np.sqrt(np.mean(np.einsum("snk,k->sn", rows, direction) ** 2))
        return wanted * direction / rms

    common = of_size(plan.common_sd, rng.standard_normal(k))
    per_axis = np.array([of_size(1.0, axis)[j] for j, axis in enumerate(np.eye(k))])
    spread = plan.spread_sd / np.sqrt(k) * per_axis * rng.standard_normal((plan.sensors, k))
    return common + spread


def _own_sizes(
    limits: tuple[float, float], rows: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Sizes (S, k) of evenings that each have a direction and a root mean square of their own."""
    sets, _, k = rows.shape
    direction = rng.standard_normal((sets, k))
    rms = np.sqrt(np.mean(np.einsum("snk,sk->sn", rows, direction) ** 2, axis=1))
    wanted = np.exp(rng.uniform(*np.log(limits), sets))
    return direction * (wanted / rms)[:, None]


SMALLEST_SD = 0.7
"""Noise units: what is smaller leaves an evening as it is."""


def _cauchy_sizes(scale: float, rows: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Sizes (S, k) with a half-Cauchy distribution of their root mean square, noise units."""
    sets, _, k = rows.shape
    lowest = 2 / np.pi * np.arctan(SMALLEST_SD / scale)
    strength = scale * np.tan(np.pi / 2 * rng.uniform(lowest, 1.0, sets))
    together = np.sqrt(np.mean((rows**2).sum(axis=2), axis=1))  # sizes along all axes are alike
    return strength[:, None] * rng.standard_normal((sets, k)) / together[:, None]
