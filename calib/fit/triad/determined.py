"""Whether a calibration's parameters are determined: their sds against their sizes.

A wrong parameter makes a corrected vector of magnitude m wrong by a share of m: a gain by its
relative error, a misalignment by its angle, a bias by its size over m. ``LARGEST_SHARE`` is the one
limit for all three. It is judged with the stated sds, before any widening by misfit.
"""

from collections.abc import Iterator

import numpy as np

from calib.fit.parameters import TriadParameters
from calib.poses.imu_log import AXES

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


def _each(p: TriadParameters, magnitude: float) -> Iterator[str]:
    gain = np.abs(p.scale_counts_per_unit)
    size = np.where(gain > 0, gain, np.nan)
    misalignment_sd, bias_sd, scale_sd = p.sd
    shares = (
        ("scale", p.scale_counts_per_unit, scale_sd, scale_sd / size),
        ("misalignment", p.misalignment_rad, misalignment_sd, misalignment_sd),
        ("bias", p.bias_counts, bias_sd, bias_sd / size / magnitude),
    )
    for name, value, sd, share in shares:
        for k, axis in enumerate(AXES):
            if name == "scale" and not value[k] > 0:
                yield f"{name} {axis} {value[k]:.3g} (not positive)"
            elif share[k] > LARGEST_SHARE:  # False for NaN: not fitted, or nothing to compare with
                yield f"{name} {axis} {value[k]:.3g} ± {sd[k]:.2g}"
