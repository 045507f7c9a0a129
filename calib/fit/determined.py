"""Whether a calibration's parameters are determined: their sds against their sizes.

A wrong parameter makes a corrected vector of magnitude m wrong by a share of m: a gain by its
relative error, a misalignment by its angle, a bias by its size over m. ``LARGEST_SHARE`` is the one
limit for all three. It is judged with the stated sds, before any widening by misfit.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from calib.poses.imu_log import AXES, FloatArray

LARGEST_SHARE = 0.1
"""The sds are those of a linear fit: at a relative sd r its curvature moves a parameter by r sds. A
data sheet states most gains to 3 %: ten are no calibration."""


@dataclass(frozen=True, eq=False)
class BaseParameters:
    """Misalignment (rad), bias (counts) and scale (counts per unit), values and sds, each (3,).

    The sd of what was not fitted is NaN. ``magnitude`` is the largest that was measured, SI; NaN
    where nothing but rest was.
    """

    misalignment_rad: FloatArray
    bias_counts: FloatArray
    scale_counts_per_unit: FloatArray
    misalignment_sd: FloatArray
    bias_sd: FloatArray
    scale_sd: FloatArray
    magnitude: float


def undetermined(parameters: BaseParameters) -> tuple[str, ...]:
    """The parameters that the data do not determine, each in words; empty where all are.

    Examples
    --------
    >>> one, nil = np.ones(3), np.zeros(3)
    >>> undetermined(BaseParameters(nil, nil, 9e3 * one, nil, nil, [2e4, 3, 3], 1.7))
    ('scale x 9e+03 ± 2e+04',)
    """
    return tuple(_each(parameters))


def _each(p: BaseParameters) -> Iterator[str]:
    gain = np.abs(np.asarray(p.scale_counts_per_unit, dtype=float))
    size = np.where(gain > 0, gain, np.nan)
    shares = (
        ("scale", p.scale_counts_per_unit, p.scale_sd, np.asarray(p.scale_sd) / size),
        ("misalignment", p.misalignment_rad, p.misalignment_sd, p.misalignment_sd),
        ("bias", p.bias_counts, p.bias_sd, np.asarray(p.bias_sd) / size / p.magnitude),
    )
    for name, value, sd, share in shares:
        for k, axis in enumerate(AXES):
            if name == "scale" and not value[k] > 0:
                yield f"{name} {axis} {value[k]:.3g} (not positive)"
            elif share[k] > LARGEST_SHARE:  # False for NaN: not fitted, or nothing to compare with
                yield f"{name} {axis} {value[k]:.3g} ± {sd[k]:.2g}"
