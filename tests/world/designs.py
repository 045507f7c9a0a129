"""The named evenings: the paper's experiment, the rich gyroscope design, three temperatures."""

import numpy as np

from tests.world.bench import (
    HUMIDITY,
    SUPPLY_V,
    Course,
    Design,
    Run,
    Turntable,
    corner_directions,
    wedge_directions,
)
from tests.world.imu import FloatArray, Sensor, mpu6050, mti
from tests.world.plate import PlateMotion

RPM = np.pi / 30  # rad/s
SLOW, FAST = 50 / 3 * RPM, 100 / 3 * RPM

PLATEAU = Course(  # °C: the unit was switched on an hour before
    start=30.0, wander_sd=0.2, wander_tau_s=200.0, reference=25.0, logging_sd=0.02, decimals=2
)


def still_run(directions: FloatArray, name: str = "stopped", **conditions: float) -> Run:
    """Poses of 8 s on a table, for the accelerometers, and for the gyroscopes at rest."""
    return Run(name, None, directions, seconds=8.0, in_accelerometer_section=True, **conditions)


def turning_run(name: str, motion: PlateMotion, directions: FloatArray) -> Run:
    """Poses of 20 s on the turning plate, after a minute to set it up."""
    return Run(name, motion, directions, seconds=20.0, lead_s=60.0)


def paper_design(sensor: Sensor | None = None, motion: PlateMotion | None = None) -> Design:
    """Angrisano et al.: 18 poses of 8 s at rest, 18 of 20 s at 16 2/3 rpm, wedge within 1°."""
    wedge = wedge_directions()
    return Design(
        title="MTi on a 16 rpm record player",
        sensor=sensor or mti(),
        runs=(still_run(wedge), turning_run("17rpm", motion or PlateMotion(SLOW), wedge)),
        rests_count_for_gyroscope=False,
    )


def rich_design(sensor: Sensor | None = None) -> Design:
    """18 poses, two speeds, both directions, plate stopped: 126 gyroscope rows.

    The rates are known as one camera measures them: its clock to 50 ppm, each clip to 5 ppm.
    """
    wedge = wedge_directions()
    speeds = {"17rpm": SLOW, "m17rpm": -SLOW, "33rpm": FAST, "m33rpm": -FAST}
    return Design(
        title="MPU-6050, two speeds, both directions and plate stopped",
        sensor=sensor or mpu6050(),
        runs=(
            still_run(wedge),
            *(turning_run(name, PlateMotion(rate), wedge) for name, rate in speeds.items()),
        ),
        columns={"supply_v": SUPPLY_V, "humidity_pct": HUMIDITY},
        jitter_deg=3.0,
        rate_sd_relative=5e-6,
        clock_sd_relative=50e-6,
    )


def tilted_design(
    tilt_deg: float, sensor: Sensor | None = None, motion: PlateMotion | None = None,
    mountings: int = 9,
) -> Design:
    """Three minutes: 6 faces and 3 edges of 20 s on a plate with 15 cm of books under one side.

    With 18 ``mountings`` the whole wedge. The case is put down within 8 mm of the spindle.
    """
    wedge = wedge_directions()
    faces = np.abs(wedge).max(axis=1) > 0.9
    directions = wedge if mountings == len(wedge) else np.vstack(
        [wedge[faces], wedge[~faces][[0, 5, 10]]])
    return Design(
        title="nine mountings on a tilted plate",
        sensor=sensor or mpu6050(),
        runs=(turning_run("17rpm", motion or PlateMotion(SLOW), directions),),
        turntable=Turntable(tilt_rad=(float(np.radians(tilt_deg)), 0.0), placement_sd_m=0.008),
        jitter_deg=3.0,
    )


def soak_design(sensor: Sensor | None = None) -> Design:
    """26 poses (faces, edges, corners) at three temperatures, 0, +20 and 0 °C: 78 rows."""
    directions = np.vstack([wedge_directions(), corner_directions()])
    return Design(
        title="26 poses at three temperatures",
        sensor=sensor or mpu6050(),
        runs=tuple(
            still_run(directions, name, soak_c=warmth, lead_s=lead)
            for name, warmth, lead in (
                ("room", 0.0, 0.0),
                ("warm", 20.0, 1200.0),
                ("room again", 0.0, 1200.0),
            )
        ),
        temperature=PLATEAU,
        columns={"supply_v": SUPPLY_V, "humidity_pct": HUMIDITY},
        jitter_deg=3.0,
    )
