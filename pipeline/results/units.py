"""Units of the nine parameters of a triad, by their keys in results.json."""

from calib.poses.imu_log import SI_UNIT

#: ``{u}`` stands for the SI unit of the triad's readings.
UNITS = {
    "misalignment_rad": "rad",
    "bias_counts": "counts",
    "scale_counts_per_unit": "counts/({u})",
}


def unit_of(key: str, triad: str) -> str:
    """The unit of the parameters that stand under ``key``.

    >>> unit_of("scale_counts_per_unit", "accelerometer")
    'counts/(m/s²)'
    """
    return UNITS[key].replace("{u}", SI_UNIT[triad])
