"""Gravity and Earth rate at a site.

WGS84 normal gravity (Somigliana's formula with the second-order height correction, NIMA
TR8350.2) and the constants that define it; ``tests/calib/test_earth.py`` has the values it is
tested against, the exact normal field among them.

What real gravity adds to it, one sd each, as a share of an accelerometer's scale:

==============================================  ==============  ==========
anomaly (masses below and around)               5e-4 m/s²       51 ppm
height wrong by 10 m                            3.1e-5 m/s²     3.1 ppm
latitude wrong by 0.01° (1.1 km)                9e-6 m/s²       0.9 ppm
tides of Moon and Sun, at most                  1.6e-6 m/s²     0.2 ppm
truncation of the height series at 1000 m       1e-7 m/s²       0.01 ppm
==============================================  ==============  ==========

The anomaly (tens of mGal; over 100 mGal in mountains) dwarfs the rest and stands for all of them
in ``NORMAL_GRAVITY_SD_M_S2``. The deflection of the vertical, 10 to 30 seconds of arc and up to a
minute and more in mountains, tilts the plumb line by 0.003 to 0.02° against the ellipsoid's
normal. It leaves the magnitude alone (1e-8 and less), and roll and pitch of an installation too,
which are measured against the plumb line itself; only attitudes that are compared with a
geodetic vertical contain it.
"""

import math

EARTH_RATE_RAD_S = 7.292115e-5  #: rad/s, WGS84
STANDARD_GRAVITY_M_S2 = 9.80665  #: the unit g, by definition
SEMI_MAJOR_AXIS_M = 6378137.0  #: m, WGS84
FLATTENING = 1 / 298.257223563  #: WGS84
GRAVITATIONAL_CONSTANT_M3_S2 = 3.986004418e14  #: GM in m³/s², WGS84
EQUATOR_GRAVITY_M_S2 = 9.7803253359  #: m/s², WGS84
POLE_GRAVITY_M_S2 = 9.8321849378  #: m/s², WGS84

LEAST_GRAVITY_M_S2, GREATEST_GRAVITY_M_S2 = 9.763, 9.835
"""Gravity on the Earth's surface, rounded outwards: 9.7639 m/s² on Huascarán, 9.8337 on the Arctic
Ocean (Hirt et al., New ultrahigh-resolution picture of Earth's gravity field, Geophys. Res. Lett.
40, 2013). Fact."""
LARGEST_ANOMALY_M_S2 = 4e-3
"""Free-air anomalies of mountains and trenches; the largest are 300 to 400 mGal. Fact."""

NORMAL_GRAVITY_SD_M_S2 = 5e-4
"""How far real gravity strays from the normal field, 1 sd: the budget above. Fact."""


def normal_gravity(latitude_rad: float, height_m: float = 0.0) -> float:
    """Normal gravity of WGS84 on the ellipsoid at ``latitude_rad``, raised by ``height_m``.

    Somigliana's formula and its second-order height correction: NIMA TR8350.2, section 4.

    Parameters
    ----------
    latitude_rad : float
        Geodetic latitude, rad.
    height_m : float
        Height above the ellipsoid, m.

    Returns
    -------
    float
        Gravity in m/s²; the height series is within 1e-7 m/s² up to 1000 m.

    Examples
    --------
    >>> round(normal_gravity(math.radians(40.85)), 10)
    9.8024558593
    """
    a, f = SEMI_MAJOR_AXIS_M, FLATTENING
    b = a * (1 - f)
    e2 = 2 * f - f * f
    k = b * POLE_GRAVITY_M_S2 / (a * EQUATOR_GRAVITY_M_S2) - 1
    m = EARTH_RATE_RAD_S**2 * a * a * b / GRAVITATIONAL_CONSTANT_M3_S2
    s2 = math.sin(latitude_rad) ** 2
    on_ellipsoid = EQUATOR_GRAVITY_M_S2 * (1 + k * s2) / math.sqrt(1 - e2 * s2)
    h = height_m / a
    return on_ellipsoid * (1 - 2 * (1 + f + m - 2 * f * s2) * h + 3 * h * h)


def gravity_bounds(latitude_rad: float, height_m: float) -> tuple[float, float]:
    """Lowest and highest gravity of any place at this latitude and height, m/s².

    Parameters
    ----------
    latitude_rad : float
        Geodetic latitude, rad.
    height_m : float
        Height above the ellipsoid, m.

    Returns
    -------
    low, high : float
    """
    normal = normal_gravity(latitude_rad, height_m)
    return normal - LARGEST_ANOMALY_M_S2, normal + LARGEST_ANOMALY_M_S2


def earth_rate_vertical(latitude_rad: float) -> float:
    """Vertical (upward) part of the Earth's rotation, rad/s."""
    return EARTH_RATE_RAD_S * math.sin(latitude_rad)


def earth_rate_horizontal(latitude_rad: float) -> float:
    """Horizontal (northward) part of the Earth's rotation, rad/s.

    Parameters
    ----------
    latitude_rad : float
        Geodetic latitude, rad.

    Returns
    -------
    float
        ``EARTH_RATE_RAD_S cos(latitude)``, rad/s.
    """
    return EARTH_RATE_RAD_S * math.cos(latitude_rad)
