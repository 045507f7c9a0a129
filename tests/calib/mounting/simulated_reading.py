"""Mounted sensors for the tests: the plumb line and a drive, from rotations and sensitive axes.

Shares no formula with the package: attitudes are scipy rotations, readings are projections on the
simulated sensor's physical axes, the truth is the rotation that was put in.
"""

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import TriadCalibration, calibrate_triad
from calib.mounting.mounting import Mounting
from calib.poses.imu_log import ImuLog
from calib.poses.pose_set import pose_set
from calib.poses.runs.reference_runs import gravity_run
from tests.fitting import averaged, spec_of
from tests.world.designs import paper_design
from tests.world.imu import Triad, mti
from tests.world.session import simulate
from tests.world.truth import parameters

FloatArray = NDArray[np.float64]
Up = tuple[float, float, float]
G = 9.80267
RATE_HZ = 100.0
TRIAD = mti().accelerometer


def vehicle_to_sensor(order: str, roll: float, pitch: float, yaw: float = 0.0) -> FloatArray:
    """The mounting: the sensor's axes turned out of the vehicle's, first by yaw, about own axes."""
    turns = {"x": roll, "y": pitch}
    first, second = (order[1], order[0])
    angles = [yaw, turns[first], turns[second]]
    return Rotation.from_euler(f"Z{first}{second}".upper(), angles).as_matrix().T


@dataclass(frozen=True, eq=False)
class Mounted:
    """A simulated accelerometer in a vehicle.

    ``rotation`` (3, 3) takes the vehicle's axes to the orthogonal axes of the calibration.
    """

    triad: Triad
    rotation: FloatArray

    def log(
        self, force: FloatArray, seed: int, label: str = "installed.csv", **columns: float
    ) -> ImuLog:
        """What is logged while ``force`` (n, 3) acts in the vehicle's axes, m/s²."""
        in_case = force @ self.rotation.T @ parameters(self.triad).case_to_orthogonal
        time_s = np.arange(len(force)) / RATE_HZ
        rng = np.random.default_rng([seed, 77])
        counts = self.triad.convert(self.triad.project(in_case)[None], time_s[None], rng)[0]
        return ImuLog(
            label, time_s, counts.astype(float), np.full_like(force, np.nan),
            {name: np.full(len(force), value) for name, value in columns.items()},
        )

    def still(
        self, seconds: float, seed: int, up: Up = (0.0, 0.0, 1.0)
    ) -> ImuLog:
        """At rest, with ``up`` the direction that is up in the vehicle's axes."""
        direction = np.array(up) / np.linalg.norm(up)
        return self.log(np.tile(G * direction, (round(seconds * RATE_HZ), 1)), seed)


def floor(rise_x_rad: float, rise_y_rad: float, reversed_by_rad: float | None = None) -> Up:
    """Up in the vehicle's axes on a sloping floor; after turning round where an angle is given."""
    up = np.array([np.sin(rise_x_rad), np.sin(rise_y_rad), 0.0])
    up[2] = np.sqrt(1 - up @ up)
    if reversed_by_rad is not None:
        up = Rotation.from_euler("z", -reversed_by_rad).apply(up)
    return float(up[0]), float(up[1]), float(up[2])


def drive(
    seconds: float,
    seed: int,
    sign: float = 1.0,
    shake_m_s2: float = 0.8,
    sway_m_s2: float = 0.15,
    road_slope_rad: float = 0.02,
) -> FloatArray:
    """Specific force (n, 3) of stop-and-go on a straight road, in the vehicle's axes.

    Pushes of 1 to 2.5 m/s² for 4 to 7 s, forward and backward in turn beginning with ``sign``;
    engine and road shake all axes; the lane is held by a slow sway to the side.
    """
    rng = np.random.default_rng([seed, 78])
    n = round(seconds * RATE_HZ)
    push, at, now = np.zeros(n), round(4 * RATE_HZ), sign
    while at < n:
        length = round(rng.uniform(4, 7) * RATE_HZ)
        shape = np.sin(np.pi * np.arange(length) / length) ** 0.5
        part = slice(at, min(at + length, n))
        push[part] = now * rng.uniform(1, 2.5) * shape[: part.stop - part.start]
        at += length + round(rng.uniform(2, 5) * RATE_HZ)
        now = -now
    keep = np.exp(-1 / RATE_HZ / 0.7)
    kick = np.sqrt(1 - keep**2) * rng.standard_normal(n + 1000)
    sway = sway_m_s2 * lfilter([1], [1, -keep], kick)[1000:]
    force = shake_m_s2 * rng.standard_normal((n, 3))
    force[:, 0] += push + G * np.sin(road_slope_rad)
    force[:, 1] += sway
    force[:, 2] += G * np.cos(road_slope_rad)
    return force


@cache
def calibration(seed: int = 0, noise: float = 1.0) -> TriadCalibration:
    """The accelerometer after 18 poses of 8 s."""
    design = paper_design(mti().with_noise(noise))
    session = simulate(replace(design, runs=design.runs[:1]), seed)
    specs = (spec_of(TRIAD, TRIAD.full_scale), spec_of(mti().gyroscope, 2.6))
    means = averaged(session.runs[0], specs, 0.0)
    poses = pose_set("accelerometer", [gravity_run("still", means, G, 0.0)], 0.0)
    return calibrate_triad(fit(poses, Model.of(["bias", "scale", "misalignment"])), specs[0])


def angles_off(found: Mounting, rotation: FloatArray) -> FloatArray:
    """Roll and pitch less those of ``rotation`` (scipy's Euler angles), radians, (2,)."""
    first, second = found.order[1], found.order[0]
    _, inner, outer = Rotation.from_matrix(rotation.T).as_euler(f"Z{first}{second}".upper())
    truth = {first: inner, second: outer}
    return np.array(
        [
            math.remainder(found.roll_rad - truth["x"], 2 * math.pi),
            math.remainder(found.pitch_rad - truth["y"], 2 * math.pi),
        ]
    )


def any_mounting(rng: np.random.Generator) -> FloatArray:
    return np.asarray(Rotation.random(random_state=int(rng.integers(2**31))).as_matrix())
