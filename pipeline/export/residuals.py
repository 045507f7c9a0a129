"""What the model leaves of every pose, as a table for other programs."""

import csv
import io
from collections.abc import Iterator
from typing import Any

from calib.poses.imu_log import AXES, SI_UNIT
from pipeline.export.parts import Export
from pipeline.results.read import Stored
from pipeline.text.plain import cell


def to_residuals(stored: Stored) -> Export:
    """``residuals.csv``: a row for each pose of each triad, SI units, empty where not known.

    ``residual_sds`` is the residual over its sd; ``left_out`` the residual predicted from all other
    poses.
    """
    names = sorted({name for triad in stored.triads
                    for pose in stored.contents[triad.name]["poses"] for name in pose["columns"]})
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow([
        "triad", "pose", "run", "time_s", "unit", "reference", "residual", "sd", "residual_sds",
        "left_out", *(f"{kind}_{axis}" for kind in ("reading", "reading_sd", "corrected")
                      for axis in AXES),
        *(cell(name) for name in names),
    ])
    for triad in stored.triads:
        for pose in stored.contents[triad.name]["poses"]:
            table.writerow(_row(triad.name, pose, names))
    return Export({"residuals.csv": text.getvalue()}, ())


def _row(triad: str, pose: dict[str, Any], names: list[str]) -> Iterator[Any]:
    yield from (triad, cell(pose["label"]), cell(pose["run"]), pose["time_s"],
                SI_UNIT[triad])
    residual, sd = pose["residual"], pose["sd"]
    yield from (pose["reference"], residual, sd, residual / sd if sd > 0 else None,
                pose["left_out"])
    yield from (*pose["reading"], *pose["reading_sd"], *pose["corrected"])
    yield from (pose["columns"].get(name) for name in names)
