"""Normal gravity against tabulated values and against the exact field of the WGS84 ellipsoid."""

import math

import pytest

from calib.earth import (
    EARTH_RATE_RAD_S,
    FLATTENING,
    GRAVITATIONAL_CONSTANT_M3_S2,
    NORMAL_GRAVITY_SD_M_S2,
    SEMI_MAJOR_AXIS_M,
    earth_rate_horizontal,
    earth_rate_vertical,
    normal_gravity,
)

# Latitude in degrees: gravity in m/s² at 0, 50 and 1000 m. Computed once in double precision and
# checked against a second program (ahrs 0.4.0, WGS.normal_gravity).
TABLE = {
    0.0: (9.7803253359, 9.7801709532, 9.7772383665),
    30.0: (9.7932472692, 9.7930929399, 9.7901613693),
    40.85: (9.8024558593, 9.8023015682, 9.7993707229),
    41.9: (9.8033980533, 9.8032437661, 9.8003129951),
    45.0: (9.8061977693, 9.8060434937, 9.8031129435),
    51.5: (9.8120335750, 9.8118793236, 9.8089492339),
    60.0: (9.8191769531, 9.8190227313, 9.8160932059),
    90.0: (9.8321849378, 9.8320307702, 9.8291022740),
}


def exact_normal_gravity(latitude_rad: float, height_m: float) -> float:
    """Magnitude of the normal field in ellipsoidal coordinates (Heiskanen and Moritz, 2-66, 2-67).

    From a, f, GM and ω alone; neither Somigliana's formula nor any series is in it.
    """
    a, omega, gm = SEMI_MAJOR_AXIS_M, EARTH_RATE_RAD_S, GRAVITATIONAL_CONSTANT_M3_S2
    b = a * (1 - FLATTENING)
    e = math.sqrt(a * a - b * b)  # linear eccentricity
    normal = a * a / math.hypot(a * math.cos(latitude_rad), b * math.sin(latitude_rad))
    x = (normal + height_m) * math.cos(latitude_rad)
    z = (normal * b * b / (a * a) + height_m) * math.sin(latitude_rad)
    d = x * x + z * z - e * e
    u = math.sqrt(d / 2 * (1 + math.sqrt(1 + (2 * e * z / d) ** 2)))
    v = math.hypot(u, e)
    beta = math.atan2(z * v, u * x)
    sine, cosine = math.sin(beta), math.cos(beta)

    def q(u: float) -> float:
        return ((1 + 3 * u * u / (e * e)) * math.atan(e / u) - 3 * u / e) / 2

    slope = 3 * (1 + u * u / (e * e)) * (1 - u / e * math.atan(e / u)) - 1
    w = math.sqrt(u * u + (e * sine) ** 2) / v
    turning = (omega * a) ** 2 / q(b)
    along_u = (
        -gm / v**2 - turning * e / v**2 * slope * (sine**2 / 2 - 1 / 6) + omega**2 * u * cosine**2
    )
    along_beta = (turning * q(u) / v - omega**2 * v) * sine * cosine
    return math.hypot(along_u, along_beta) / w


@pytest.mark.parametrize("latitude", TABLE)
def test_normal_gravity_is_the_tabulated_one(latitude: float) -> None:
    for height, value in zip((0.0, 50.0, 1000.0), TABLE[latitude], strict=True):
        for sign in (1, -1):
            found = normal_gravity(math.radians(sign * latitude), height)
            assert found == pytest.approx(value, abs=1e-10)


@pytest.mark.parametrize("latitude", TABLE)
def test_normal_gravity_is_the_exact_field_on_the_ellipsoid(latitude: float) -> None:
    exact = exact_normal_gravity(math.radians(latitude), 0.0)
    assert normal_gravity(math.radians(latitude)) == pytest.approx(exact, abs=2e-10)


@pytest.mark.parametrize(("height", "within"), [(50.0, 6e-9), (1000.0, 1.05e-7)])
def test_the_height_series_stays_within_its_stated_truncation(height: float, within: float) -> None:
    worst = max(
        abs(normal_gravity(math.radians(d), height) - exact_normal_gravity(math.radians(d), height))
        for d in range(0, 91, 5)
    )
    assert within / 10 < worst < within


def test_the_terms_of_the_uncertainty_budget_are_what_the_field_gives() -> None:
    naples = math.radians(40.85)
    assert normal_gravity(naples) - normal_gravity(naples, 10.0) == pytest.approx(3.1e-5, rel=0.01)
    north = normal_gravity(naples + math.radians(0.01)) - normal_gravity(naples)
    assert north == pytest.approx(9e-6, rel=0.01)
    assert pytest.approx(51e-6, rel=0.01) == NORMAL_GRAVITY_SD_M_S2 / 9.8


def test_earths_rate_is_15_04_degrees_an_hour_and_splits_by_latitude() -> None:
    per_hour = math.degrees(EARTH_RATE_RAD_S) * 3600
    assert per_hour == pytest.approx(15.041, abs=5e-4)
    assert earth_rate_vertical(math.pi / 2) == EARTH_RATE_RAD_S
    assert earth_rate_vertical(-math.pi / 6) == pytest.approx(-EARTH_RATE_RAD_S / 2)
    whole = math.hypot(earth_rate_vertical(0.7), earth_rate_horizontal(0.7))
    assert whole == pytest.approx(EARTH_RATE_RAD_S)
