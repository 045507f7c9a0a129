"""The numbers that Angrisano et al. printed, in the units that they can only have.

A. Angrisano, E. Nocerino, S. Troisi, G. Del Core, *IMU low cost calibration method*, tables 1 to 3
(section Results). ``data/published`` has them as printed, and ``errata.md`` there says why the
units here are others: k⁻¹ is in bit per unit, not unit per bit; alpha is in radians, not degrees;
the sd called sigma_k belongs to k, in unit per bit, not to the k⁻¹ of the same row.
"""

import math
from dataclasses import dataclass

import numpy as np

from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray

ACCELEROMETER = TriadSpec(50.0, 16, "offset-binary")
GYROSCOPE = TriadSpec(math.radians(150.0), 16, "offset-binary")
"""The Xsens MTi's data sheet, section "Procedures & Algorithms"."""

POSES = 18
STOP_RULE = 0.0005
FRAMES_PER_SECOND = 15.0
NOMINAL_RPM = 50 / 3
"""The "16 rpm" of a record player are 16 2/3."""

GRAVITY_M_S2 = 9.80267
"""Gravity of Naples, where the authors worked; the publication does not state what it used."""


@dataclass(frozen=True, eq=False)
class PublishedSet:
    """One measurement set: values (3,) in rad, counts, counts per unit; one sd for each group.

    ``sd_k`` is in units per count.
    """

    name: str
    misalignment_rad: FloatArray
    bias_counts: FloatArray
    scale_counts_per_unit: FloatArray
    sd_misalignment_rad: float
    sd_bias_counts: float
    sd_k: float


TABLE_1 = (
    PublishedSet(
        "first set",
        np.array([-0.0135, -0.0036, 0.0005]),
        np.array([33610.0, 33382.0, 32063.0]),
        np.array([547.6, 552.8, 550.6]),
        math.radians(1 / 60),
        0.6,
        2.6e-7,
    ),
    PublishedSet(
        "second set",
        np.array([-0.0139, -0.0038, 0.0003]),
        np.array([33608.0, 33380.0, 32060.0]),
        np.array([548.6, 553.0, 550.5]),
        math.radians(2.5 / 60),
        1.3,
        5e-7,
    ),
)
POSE_ACCURACY_RAD = (math.radians(1.0), math.radians(10.0))
"""How accurately the poses of the two sets were laid: on a wedge, and by hand."""

ACCELEROMETER_CERTIFICATE = (np.array([33652.0, 33395.0, 32034.0]), np.array([549.7, 552.7, 550.4]))
"""Biases in counts and gains in counts per m/s²; the certificate's alignment is not printed."""

TABLE_2 = {
    "misalignment": (math.radians(-18.0), math.radians(19.0)),
    "bias": (-1500.0, 2500.0),
    "scale": (-0.0006, 0.03),
}
"""Convergence intervals about the start of eq. (12), in rad, counts, m/s² per count."""

TABLE_3 = PublishedSet(
    "gyroscope",
    np.array([-0.0089, -0.0026, 0.0130]),
    np.array([28585.0, 36273.0, 34528.0]),
    np.array([10835.0, 9592.0, 9575.0]),
    math.radians(0.5),
    60.0,
    4.5e-7,
)
GYROSCOPE_CERTIFICATE = (np.array([28575.0, 36338.0, 34681.0]), np.array([9651.0, 9402.0, 9417.0]))
"""Biases in counts and gains in counts per rad/s."""
