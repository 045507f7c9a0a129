"""Formats that store the calibration or its residuals unchanged: JSON, CSV, and imu_tk."""

import csv
import io
import json
from collections.abc import Iterator
from typing import Any

from calib.poses.imu_log import AXES, SI_UNIT
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.export.parts import Export, no_effects, no_sds
from pipeline.results.json_values import unit_of
from pipeline.results.names import PARAMETERS
from pipeline.results.read import Stored, StoredTriad
from pipeline.results.schema.triad import PoseResult
from pipeline.text.plain import cell


def to_json(stored: Stored) -> Export:
    """Matrix, bias and sds of each triad, ready for ``s = M (counts - b)``, with units."""
    triads = {
        triad.name: {
            "unit": SI_UNIT[triad.name],
            "applies_as": "matrix @ (counts - bias_counts)",
            "matrix": triad.parameters.matrix().tolist(),
            **_nine(triad),
            "effects": {name: one.as_json() for name, one in triad.section.effects.items()},
        }
        for triad in stored.triads
    }
    text = json.dumps({"title": stored.contents.title, **triads}, indent=1, ensure_ascii=False)
    return Export({"calibration.json": text + "\n"}, tuple(
        f"The matrix of the {triad.name} does not contain {', '.join(triad.section.effects)}. "
        f"The file lists their values; `pipeline apply` corrects them."
        for triad in stored.triads if triad.section.effects))


def to_csv(stored: Stored) -> Export:
    """One line per parameter: triad, parameter, axis, value, sd, unit, and the effects that it
    represents because the poses cannot separate them.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["triad", "parameter", "axis", "value", "sd", "unit", "stands_for"])
    for triad in stored.triads:
        nine = _nine(triad)
        for key in PARAMETERS:
            unit = unit_of(key, triad.name, triad.correction.spec)
            for axis, value, sd in zip(AXES, nine[key], nine[f"{key}_sd"], strict=True):
                table.writerow([triad.name, key, axis, value, sd, unit, ""])
        for name, effect in triad.section.effects.items():
            others = " ".join(effect.stands_for)
            for (label, unit), value, sd in zip(
                triad.parts_of(name), effect.values, effect.sd, strict=True
            ):
                table.writerow([triad.name, cell(name), cell(label), value, sd, cell(unit),
                                cell(others)])
    return Export({"calibration.csv": text.getvalue()}, ())


def to_imu_tk(stored: Stored) -> Export:
    """imu_tk's ``.calib``: T, K and b of ``X' = T K (X - B)``, the model of this program."""
    files = {}
    for triad in stored.triads:
        k = triad.units_per_count
        scale = [[float(k[i]) if i == j else 0.0 for j in range(3)] for i in range(3)]
        bias = [[float(b)] for b in triad.parameters.bias_counts]
        name = "gyro" if triad.name == "gyroscope" else TRIAD_KINDS[triad.name].prefix
        files[f"{name}.calib"] = "\n".join(
            "".join(" ".join(f"{value:.12g}" for value in row) + "\n" for row in matrix)
            for matrix in (triad.alignment.tolist(), scale, bias))
    return Export(files, (*no_sds(stored), *no_effects(stored, "imu_tk")))


def _nine(triad: StoredTriad) -> dict[str, list[float | None]]:
    return {name: value for key in PARAMETERS for name, value in (
        (key, getattr(triad.section.parameters, key)),
        (f"{key}_sd", getattr(triad.section.sd, key)))}


def to_residuals(stored: Stored) -> Export:
    """``residuals.csv``: a row for each pose of each triad, SI units, empty where not known.

    ``residual_sds`` is the residual over its sd; ``left_out`` the residual predicted from all other
    poses.
    """
    names = sorted({name for triad in stored.triads
                    for pose in triad.section.poses for name in pose.columns})
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow([
        "triad", "pose", "run", "time_s", "unit", "reference", "residual", "sd", "residual_sds",
        "left_out", *(f"{kind}_{axis}" for kind in ("reading", "reading_sd", "corrected")
                      for axis in AXES),
        *(cell(name) for name in names),
    ])
    for triad in stored.triads:
        for pose in triad.section.poses:
            table.writerow(_row(triad.name, pose, names))
    return Export({"residuals.csv": text.getvalue()}, ())


def _row(triad: str, pose: PoseResult, names: list[str]) -> Iterator[Any]:
    yield from (triad, cell(pose.label), cell(pose.run), pose.time_s,
                SI_UNIT[triad])
    residual, sd = pose.residual, pose.sd
    yield from (pose.reference, residual, sd, residual / sd if sd > 0 else None,
                pose.left_out)
    yield from (*pose.reading, *pose.reading_sd, *pose.corrected)
    yield from (pose.columns.get(name) for name in names)
