"""Whether a calibration's parameters are determined: their sds against their sizes.

A wrong parameter makes a corrected vector of magnitude m wrong by a share of m: a gain by its
relative error, a misalignment by its angle, a bias by its size over m. ``LARGEST_SHARE`` is the one
limit for all three. It is judged with the stated sds, before any widening by misfit.
"""

from collections.abc import Iterator

import numpy as np

from calib.fit.parameters import TriadParameters
from calib.poses.imu_log import AXES, BoolArray, FloatArray

LARGEST_SHARE = 0.1
"""The sds are those of a linear fit: at a relative sd r its curvature moves a parameter by r sds. A
data sheet states most gains to 3 %: ten are no calibration. Derived."""


def undetermined(parameters: TriadParameters, magnitude: float) -> tuple[str, ...]:
    """The parameters that the data do not determine.

    Parameters
    ----------
    parameters : TriadParameters
        With the stated sds; the sd of what was not fitted is NaN.
    magnitude : float
        The largest that was measured, SI; NaN where nothing but rest was.

    Returns
    -------
    tuple of str
        Each in words; empty where all are determined.

    Examples
    --------
    >>> nil, cov = np.zeros(3), np.diag([0, 0, 0, 0, 0, 0, 4e8, 9, 9])
    >>> undetermined(TriadParameters(nil, nil, nil + 9e3, cov), 1.7)
    ('scale x 9e+03 ± 2e+04',)
    """
    return tuple(_each(parameters, magnitude))


def is_undetermined(p: TriadParameters, magnitude: FloatArray) -> BoolArray:
    """Which parameters the data do not determine, of one sensor or of many.

    Parameters
    ----------
    p : TriadParameters
    magnitude : array, shape (...,)
        The largest that was measured, SI; NaN where nothing but rest was.

    Returns
    -------
    array of bool, shape (..., 3, 3)
        Scale, misalignment and bias, each x, y, z; a gain that is not positive counts.
    """
    gain = np.abs(p.scale_counts_per_unit)
    size = np.where(gain > 0, gain, np.nan)
    misalignment_sd, bias_sd, scale_sd = p.sd
    shares = [scale_sd / size, misalignment_sd, bias_sd / size / np.asarray(magnitude)[..., None]]
    lost = np.stack(shares, axis=-2) > LARGEST_SHARE  # False for NaN: not fitted, or only rest
    lost[..., 0, :] |= ~(p.scale_counts_per_unit > 0)
    return np.asarray(lost)


def _each(p: TriadParameters, magnitude: float) -> Iterator[str]:
    misalignment_sd, bias_sd, scale_sd = p.sd
    values = (("scale", p.scale_counts_per_unit, scale_sd),
              ("misalignment", p.misalignment_rad, misalignment_sd),
              ("bias", p.bias_counts, bias_sd))
    lost = is_undetermined(p, np.asarray(magnitude))
    for (name, value, sd), of_group in zip(values, lost, strict=True):
        for k in np.flatnonzero(of_group):
            if name == "scale" and not value[k] > 0:
                yield f"{name} {AXES[k]} {value[k]:.3g} (not positive)"
            else:
                yield f"{name} {AXES[k]} {value[k]:.3g} ± {sd[k]:.2g}"
