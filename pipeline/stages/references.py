"""References that a configuration states: gravity and latitude of the site, a certificate."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from calib.consistency.certificate import FactoryCertificate
from calib.earth import NORMAL_GRAVITY_SD_M_S2, normal_gravity
from calib.poses.imu_log import Triad
from pipeline.config.load import Config
from pipeline.config.record_section import TriadCertificateSection
from pipeline.config.schema import SiteSection


@dataclass(frozen=True)
class Gravity:
    """The reference of the accelerometer: magnitude and sd in m/s², and its source in words.

    A value that is stated without an sd counts as exact: the accelerometer's scale is then in
    units of it, and the report says so.
    """

    value_m_s2: float
    sd_m_s2: float
    source: str


def gravity_of(site: SiteSection) -> Gravity:
    """Gravity at the site: as stated, else WGS84 normal gravity (NIMA TR8350.2).

    Returns
    -------
    Gravity
        Magnitude and sd in m/s²; the sd of a stated value is 0 where none is stated, that of the
        normal value includes the gravity anomaly.
    """
    if site.gravity_m_s2 is not None:
        return Gravity(site.gravity_m_s2, site.sd_m_s2 or 0.0, "stated")
    # The configuration's rules refuse a site with neither.
    assert site.latitude_deg is not None
    value = normal_gravity(math.radians(site.latitude_deg), site.height_m)
    return Gravity(value, site.sd_m_s2 or NORMAL_GRAVITY_SD_M_S2, "WGS84 normal gravity")


def latitude_of(site: SiteSection | None) -> float | None:
    """Geodetic latitude in rad; None where the configuration states none."""
    if site is None or site.latitude_deg is None:
        return None
    return math.radians(site.latitude_deg)


def certificate_of(config: Config, triad: Triad) -> FactoryCertificate | None:
    """The certificate of ``triad``; None where the configuration has none."""
    stated: TriadCertificateSection | None = (
        getattr(config.certificate, triad, None) if config.certificate else None
    )
    if stated is None:
        return None
    parts: dict[str, Any] = {name: part and np.array(part) for name, part in stated}
    return FactoryCertificate(**parts)
