"""A magnetometer in the poses at rest: the Earth's field, through iron, heat, noise and converter.

The attitude of every pose is that of the evening's own physics; soft iron, skew axes and gains are
one matrix, hard iron a vector. Nothing here is shared with the solver.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tests.world.bench import TEMPERATURE, Design
from tests.world.imu import FloatArray
from tests.world.physics import live_through

REFERENCE_C = 25.0


@dataclass(frozen=True)
class Magnetometer:
    """Three axes in a field, µT; ``per_kelvin`` (3,) is a hidden drift of its zero."""

    prefix: str = "mag"
    field_ut: float = 49.1
    dip_deg: float = 62.0
    counts_per_ut: float = 6.6
    noise_ut: float = 0.4
    iron: FloatArray = field(default_factory=lambda: np.array(
        [[1.02, 0.010, -0.020], [0.0, 0.97, 0.015], [0.0, 0.0, 1.01]]))
    offset_ut: FloatArray = field(default_factory=lambda: np.array([12.0, -8.0, 20.0]))
    per_kelvin: FloatArray = field(default_factory=lambda: np.zeros(3))

    def readings(
        self, into_case: FloatArray, warmth: FloatArray, rng: np.random.Generator
    ) -> FloatArray:
        """Counts (n, 3) of one pose, whose attitude (3, 3) brings the site's vectors into the case.
        """
        dip = np.radians(self.dip_deg)
        in_site = self.field_ut * np.array([np.cos(dip), 0.0, -np.sin(dip)])
        reading = self.iron @ (in_site @ into_case) + self.offset_ut
        drift = self.per_kelvin * (warmth - REFERENCE_C)[:, None]
        noise = self.noise_ut * rng.standard_normal((len(warmth), 3))
        return np.round((reading + drift + noise) * self.counts_per_ut)


def log_field(folder: Path, design: Design, seed: int, sensor: Magnetometer) -> None:
    """Add the columns of a magnetometer to the logs of poses at rest in ``folder``."""
    rng = np.random.default_rng([seed, 77])
    number = 0
    for physics in live_through(design, seed):
        if not physics.run.in_accelerometer_section:
            continue
        for attitude, warmth in zip(physics.attitude, physics.columns[TEMPERATURE], strict=True):
            number += 1
            path = folder / f"accelerometer/pose_{number:02d}.csv"
            head, *rows = path.read_text(encoding="utf-8").splitlines()
            counts = sensor.readings(attitude, warmth, rng).astype(int).tolist()
            names = ",".join(f"{sensor.prefix}_{axis}" for axis in "xyz")
            path.write_text("\n".join([f"{head},{names}", *(
                f"{row},{x},{y},{z}" for row, (x, y, z) in zip(rows, counts, strict=True))]) + "\n",
                encoding="utf-8")
