"""The numbers of Promrit et al., *In-Vehicle MEMS IMU Calibration Using Accelerometer*, repeated.

The published mean reading goes through :mod:`calib.mounting.levelling`, the very equations that
measure an installation; beside each result stands what the publication printed.
"""

import math
from collections.abc import Iterator

import numpy as np

from calib.mounting.levelling import mounting_rotation, order_margins, roll_pitch, rotation_order
from pipeline.text.tables import aligned

READING_G = np.array([-0.2235, 0.4937, 0.8330])
"""Mean of 300 readings of an MPU-6050 on two lamps of 30° and 15°, section V."""

LAMPS_DEG = (30.0, 15.0)
PRINTED_ANGLES_DEG = (30.6532, 12.9997)
PRINTED_MARGINS = (0.03168771, 0.197543)
PRINTED_CORRECT_PER_CENT = (99.978, 86.66)


def mounting_lines() -> Iterator[str]:
    """Order, angles, correctness and the compensated output beside the printed ones."""
    margins = order_margins(READING_G)
    order = rotation_order(READING_G)
    roll, pitch = roll_pitch(READING_G, order)
    found_deg = (math.degrees(roll), math.degrees(pitch))
    correct = [
        100 * (1 - abs(printed - lamp) / lamp)
        for printed, lamp in zip(PRINTED_ANGLES_DEG, LAMPS_DEG, strict=True)
    ]
    x, _, z = READING_G
    slip = abs(math.sqrt(-(x**2) + z**2) - 1)
    after = mounting_rotation(order, roll, pitch).T @ READING_G
    yield "Promrit et al.: roll and pitch of an MPU-6050 on two lamps"
    yield from aligned(
        [
            ["", "published", "found", ""],
            ["eq. (6), xyz", f"{PRINTED_MARGINS[0]:.6f}", f"{margins['xyz']:.6f}", ""],
            ["eq. (6), yxz", f"{PRINTED_MARGINS[1]:.6f}", f"{margins['yxz']:.6f}",
             f"-x² for (-x)² gives {slip:.6f}"],
            ["order", "xyz", order, ""],
            ["roll, eq. (A)", f"{PRINTED_ANGLES_DEG[0]:.4f}°", f"{found_deg[0]:.4f}°",
             "from a reading rounded to 0.0001 g: ±0.003°"],
            ["pitch, eq. (B)", f"{PRINTED_ANGLES_DEG[1]:.4f}°", f"{found_deg[1]:.4f}°", "the same"],
            ["roll correct to", f"{PRINTED_CORRECT_PER_CENT[0]:.3f} %", f"{correct[0]:.2f} %",
             "1 - |30.6532 - 30|/30"],
            ["pitch correct to", f"{PRINTED_CORRECT_PER_CENT[1]:.2f} %", f"{correct[1]:.2f} %",
             "one log cannot tell the lamp's 2° from the table's"],
            ["before [g]", "", "  ".join(f"{value:.4f}" for value in READING_G), ""],
            ["after [g]", "0  0  1 expected", "  ".join(f"{abs(value):.4f}" for value in after),
             "the length stays: the calibration is 0.6 % off"],
        ]
    )  # fmt: skip
