"""A calibration written for other programs, one function for each.

An exporter takes a :class:`pipeline.stored.Stored` and returns the files it makes, and in words
what they cannot hold: a format that has no place for an effect says so instead of dropping it.
"""

import csv
import io
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from calib.effects import EFFECTS
from calib.imu_log import AXES, SI_UNIT, FloatArray
from pipeline.stored import PARAMETERS, Stored, StoredTriad


@dataclass(frozen=True)
class Export:
    """Text of each file by name, and what of the calibration they do not hold."""

    files: Mapping[str, str]
    loses: tuple[str, ...]


def to_json(stored: Stored) -> Export:
    """Matrix, bias and covariances of each triad, ready for ``s = M (counts - b)``, with units."""
    found = {
        each.triad: {
            "unit": SI_UNIT[each.triad],
            "applies_as": "matrix @ (counts - bias_counts)",
            "matrix": (each.alignment * each.units_per_count).tolist(),
            **_nine(each),
            "effects": each.effects,
        }
        for each in stored.triads
    }
    text = json.dumps({"title": stored.found["title"], **found}, indent=1, ensure_ascii=False)
    return Export({"calibration.json": text + "\n"}, _effects_by_name(stored))


def to_csv(stored: Stored) -> Export:
    """One line for each parameter: triad, parameter, axis, value, sd, unit."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["triad", "parameter", "axis", "value", "sd", "unit"])
    for each in stored.triads:
        units = ("rad", "counts", f"counts/({SI_UNIT[each.triad]})")
        nine = _nine(each)
        for key, unit in zip(PARAMETERS, units, strict=True):
            for axis, value, sd in zip(AXES, nine[key], nine[f"{key}_sd"], strict=True):
                table.writerow([each.triad, key, axis, value, _blank(sd), unit])
        for name, effect in each.effects.items():
            for label, value, sd in zip(
                _labels(name, len(effect["values"])), effect["values"], effect["sd"], strict=True
            ):
                table.writerow([each.triad, name, label, value, _blank(sd), effect["unit"]])
    return Export({"calibration.csv": text.getvalue()}, ())


def to_imu_tk(stored: Stored) -> Export:
    """imu_tk's ``.calib``: T, K and b of ``X' = T K (X - B)``, the very model of this program."""
    files = {}
    for each in stored.triads:
        k = each.units_per_count
        scale = [[float(k[i]) if i == j else 0.0 for j in range(3)] for i in range(3)]
        parts = (each.alignment.tolist(), scale, [[float(b)] for b in each.bias_counts])
        files[f"{_short(each)}.calib"] = "\n".join(map(_matrix_text, parts))
    return Export(files, (*_no_sds(stored), *_no_effects(stored, "imu_tk")))


#: Format -> exporter, in the order in which they are listed.
EXPORTERS: Mapping[str, Callable[[Stored], Export]] = {
    "json": to_json,
    "csv": to_csv,
    "imu_tk": to_imu_tk,
}


def _nine(each: StoredTriad) -> dict[str, list[float | None]]:
    values = (each.misalignment_rad, each.bias_counts, each.scale_counts_per_unit)
    sds = (each.misalignment_sd, each.bias_sd, each.scale_sd)
    found: dict[str, list[float | None]] = {}
    for key, value, sd in zip(PARAMETERS, values, sds, strict=True):
        found[key] = _plain(value)
        found[f"{key}_sd"] = _plain(sd)
    return found


def _plain(values: FloatArray) -> list[float | None]:
    return [float(value) if value == value else None for value in values]  # NaN differs from itself


def _blank(value: float | None) -> float | str:
    return "" if value is None else value


def _labels(name: str, count: int) -> list[str]:
    """What the values of an effect are called: its parameters, then its shape parameter."""
    if name not in EFFECTS:  # column:NAME has one value for each axis
        return list(AXES)
    effect = EFFECTS[name]
    shape = [] if effect.shape is None else [effect.shape.name]
    return [*effect.parameters, *shape][:count]


def _matrix_text(rows: list[list[float]]) -> str:
    return "".join(" ".join(f"{value:.12g}" for value in row) + "\n" for row in rows)


def _short(each: StoredTriad) -> str:
    return {"accelerometer": "acc", "gyroscope": "gyro"}[each.triad]


def _no_sds(stored: Stored) -> tuple[str, ...]:
    return ("The uncertainties are not in it.",) if stored.triads else ()


def _no_effects(stored: Stored, program: str) -> tuple[str, ...]:
    return tuple(
        f"{program} has no place for {', '.join(each.effects)} of the {each.triad}: readings "
        f"corrected by it keep that error. Use `pipeline apply` to correct it."
        for each in stored.triads
        if each.effects
    )


def _effects_by_name(stored: Stored) -> tuple[str, ...]:
    return tuple(
        f"The matrix of the {each.triad} does not contain {', '.join(each.effects)}; their values "
        f"stand beside it, `pipeline apply` corrects them."
        for each in stored.triads
        if each.effects
    )
