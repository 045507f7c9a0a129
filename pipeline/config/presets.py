"""Sensors known by name, as the section they stand for in a configuration."""

from collections.abc import Mapping
from typing import Any

#: name -> what the user would otherwise write under ``sensor:``.
PRESETS: Mapping[str, Mapping[str, Any]] = {
    # MTi data sheet as used by Angrisano et al.: 16 bit, ±5 g class (50 m/s²), ±150 °/s.
    "xsens-mti": {
        "name": "Xsens MTi",
        "accelerometer": {"full_scale_m_s2": 50.0, "bits": 16, "encoding": "offset-binary"},
        "gyroscope": {"full_scale_deg_s": 150.0, "bits": 16, "encoding": "offset-binary"},
    },
    # MPU-6000/6050 product specification after reset and after i2cdevlib's initialize():
    # AFS_SEL = 0 (±2 g, 16384 LSB/g) and FS_SEL = 0 (±250 °/s, 131 LSB/(°/s)).
    "mpu-6050": {
        "name": "InvenSense MPU-6050",
        "accelerometer": {"full_scale_g": 2.0, "bits": 16, "encoding": "twos-complement"},
        "gyroscope": {"full_scale_deg_s": 250.0, "bits": 16, "encoding": "twos-complement"},
    },
}
