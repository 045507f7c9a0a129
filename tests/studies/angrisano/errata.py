"""Where the two publications err, each with a number that shows it.

``data/published/errata.md`` says in words what these lines say in figures.
"""

import math
from collections.abc import Iterator

import numpy as np

from calib.consistency.certificate import frame_free
from calib.fit.least_squares.angrisano import data_sheet_start
from calib.fit.parameters import alignment
from calib.mounting.levelling import mounting_rotation
from calib.poses.imu_log import FloatArray
from pipeline.text.tables import aligned
from tests.studies.angrisano.bench import leaning_axes
from tests.studies.angrisano.iteration import iterate_as_printed
from tests.studies.angrisano.published import ACCELEROMETER, GRAVITY_M_S2
from tests.studies.angrisano.table1 import accelerometer
from tests.studies.angrisano.table2 import StartStudy, start_study

SHOWN = 6
"""Iterations shown of one that does not end."""

SCALE_WRONG_BY = 1 / 3
"""A data sheet's full scale that is a third too small, as on a public log of an MTi."""

LEAN_RAD = math.radians(1.0)
SENSOR_ERRORS = np.diag([0.01, -0.01, 0.02])
"""S of Promrit et al.: one to two per cent, as a low-cost accelerometer has them."""

LAMPS_RAD = (math.radians(30.0), math.radians(15.0))


def errata_lines() -> Iterator[str]:
    """One paragraph of figures per slip."""
    study = start_study()
    yield "Errata of the publications, in figures"
    yield "eq. (6), entry of b_x: rms of |N| - s after each iteration [m/s²]"
    yield from aligned([_sign(study, printed=False), _sign(study, printed=True)])
    yield f"stop rule, start k too small by {100 * SCALE_WRONG_BY:.0f} %"
    yield from aligned([_rule(study, absolute=False), _rule(study, absolute=True)])
    yield "unit of Table 1's third column: 1 g on the x-axis with the certificate's 549.7"
    yield from aligned(_units())
    yield "eq. (14), length of the third column, less 1, for θ_x = θ_y"
    yield from aligned([[f"{degrees}°", f"{third_column(math.radians(degrees)) - 1:.1e}"]
                        for degrees in (0.8, 5)])
    yield "eq. (15), axes y and z 1° closer than a right angle, θ_x = +1°"
    yield from aligned(_lean())
    yield "Promrit et al., order of R and (I + S + M), S of 1 to 2 %"
    yield from aligned([["error of the compensated reading [mm/s²]",
                         f"{1e3 * misordered():.0f}"]])


def _sign(study: StartStudy, printed: bool) -> list[str]:
    with np.errstate(over="ignore", invalid="ignore"):
        found = iterate_as_printed(
            data_sheet_start(ACCELEROMETER), study.counts, GRAVITY_M_S2,
            absolute=True, printed_sign=printed, most=SHOWN,
        )  # fmt: skip
    name = "-k_x as printed" if printed else "+k_x"
    return [name, *(f"{rms:.3g}" for rms in found.rms[1:])]


def _rule(study: StartStudy, absolute: bool) -> list[str]:
    start = data_sheet_start(ACCELEROMETER)
    start[6:] *= 1 - SCALE_WRONG_BY
    found = study.as_printed(start, absolute)
    return [
        "with bars" if absolute else "without bars, as printed",
        f"stops after {found.count} iterations at an rms of {found.rms[-1]:.3g} m/s²",
    ]


def _units() -> list[list[str]]:
    gain = accelerometer().gain[0]
    bits = gain * GRAVITY_M_S2
    return [
        ["549.7 bit per (m/s²)", f"{bits:.0f} of 65536 bit: within ±50 m/s²"],
        ["549.7 (m/s²) per bit", f"{GRAVITY_M_S2 / gain:.3f} bit: nothing would be seen"],
    ]


def third_column(theta_rad: float) -> float:
    """Length of the third column of eq. (14) with θ_x = θ_y; a direction should have 1."""
    s, c = math.sin(theta_rad), math.cos(theta_rad)
    return float(np.linalg.norm([c * s, c * s, c * c]))


def alpha_of(axes: FloatArray) -> FloatArray:
    """α of eq. (2), x, y, z, for which T times the projections on ``axes`` has true lengths."""
    return frame_free(np.ones(3), axes)[1]


def _lean() -> list[list[str]]:
    theta = np.array([LEAN_RAD, 0.0, 0.0])
    axes = leaning_axes(theta)
    vectors = np.random.default_rng(0).standard_normal((50, 3))
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)

    def length_error(alpha: FloatArray) -> float:
        s = vectors @ axes.T @ alignment(alpha).T
        return float(np.abs(np.linalg.norm(s, axis=1) - 1).max())

    return [
        ["α = θ, by eq. (15)", f"magnitude wrong by up to {length_error(theta):.1e}"],
        ["α = -θ", f"magnitude wrong by up to {length_error(-theta):.1e}"],
        ["α_x exactly", f"{math.degrees(alpha_of(axes)[0]):+.4f}°"],
    ]


def misordered() -> float:
    """Error (m/s²) of inverting ``K a = R (I + S + M) a + b`` as printed, for its two lamps."""
    rotation = mounting_rotation("xyz", *LAMPS_RAD)
    sensor = np.eye(3) + SENSOR_ERRORS
    reading = sensor @ rotation @ [0.0, 0.0, GRAVITY_M_S2]
    printed = np.linalg.inv(sensor) @ rotation.T @ reading
    return float(np.linalg.norm(printed - [0.0, 0.0, GRAVITY_M_S2]))
