"""An evening as a hobbyist has it: a file for each pose, at rest and on the turning plate."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

G = 9.80665
DEG = np.pi / 180
SCALE_ACC = np.array([1.02, 0.985, 1.01])
SCALE_GYR = np.array([0.995, 1.012, 1.0])
BIAS_ACC = np.array([0.2, -0.15, 0.3])  #: m/s²
BIAS_GYR = np.array([1.2, -0.8, 0.5]) * DEG
NOISE_ACC, NOISE_GYR = 0.02, 0.1 * DEG


@dataclass(frozen=True)
class Evening:
    """What was recorded: ranges of the sensor, the plate, and how the logger writes.

    ``lean_deg`` is how far the plate's axis leans: what of gravity then goes round is the rate.
    """

    range_g: float = 4.0
    range_deg_s: float = 500.0
    rpm: float = 100 / 3
    lean_deg: float = 0.6
    poses: int = 18
    seconds: float = 8.0
    rate_hz: float = 25.0
    bias_deg_s: tuple[float, float, float] = tuple(BIAS_GYR / DEG)
    zero: int = 0  #: the count of nothing: half of 65536 in offset binary
    header: str = "millis,AcX,AcY,AcZ,Tmp,GyX,GyY,GyZ"

    @property
    def counts_per_rad_s(self) -> float:
        """Scale of the gyroscope by its data sheet."""
        return 32768 / (self.range_deg_s * DEG)

    def write(self, folder: Path, name: str, rpm: float, seed: int) -> list[Path]:
        """Files of poses in ``folder/name`` on a plate at ``rpm``, 0 at rest."""
        (folder / name).mkdir()
        rng = np.random.default_rng(seed)
        sides = _sides()[: self.poses]
        return [self._pose(folder / name / f"p{i + 1:02d}.csv", side, rpm, rng)
                for i, side in enumerate(sides)]

    def _pose(self, path: Path, up: np.ndarray, rpm: float, rng: np.random.Generator) -> Path:
        seconds = max(self.seconds, 3.3 * 60 / abs(rpm)) if rpm else self.seconds
        time_s = np.arange(round(seconds * self.rate_hz)) / self.rate_hz
        turned = Rotation.from_rotvec(np.outer(time_s * rpm * 2 * np.pi / 60, [0, 0, 1]))
        lean = Rotation.from_euler("x", self.lean_deg, degrees=True)
        laid = Rotation.align_vectors([[0, 0, 1]], [up])[0]
        # Sensor to plate, plate to its turned place, and that to the leaning axis of the room.
        whole = lean * turned * laid
        force = whole.inv().apply([0, 0, G])
        rate = np.tile(laid.inv().apply([0, 0, rpm * 2 * np.pi / 60]), (len(time_s), 1))
        acc = force * SCALE_ACC + BIAS_ACC + rng.normal(0, NOISE_ACC, force.shape)
        gyr = rate * SCALE_GYR + np.multiply(self.bias_deg_s, DEG)
        gyr += rng.normal(0, NOISE_GYR, rate.shape)
        counts = np.rint(np.column_stack([acc * 32768 / (self.range_g * G),
                                          np.full(len(time_s), -1500.0),
                                          gyr * self.counts_per_rad_s])) + self.zero
        rows = "\n".join(",".join(map(str, (round(1000 * t), *map(int, row))))
                         for t, row in zip(time_s, counts, strict=True))
        path.write_text(f"{self.header}\n{rows}\n", encoding="utf-8")
        return path


def _sides() -> np.ndarray:
    """The 6 faces and 12 edges, (18, 3)."""
    grid = np.array([[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)], float)
    number = np.abs(grid).sum(axis=1)
    sides = grid[(number == 1) | (number == 2)]
    return sides / np.linalg.norm(sides, axis=1, keepdims=True)
