"""The section ``sensor``: presets, data sheets, and their conversion to SI units."""

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from calib.poses.data_sheet import Specs, TriadSpec
from calib.poses.imu_log import Triad
from calib.poses.triad_kind import TRIAD_KINDS, TriadKind
from pipeline.config.types import Positive, Section, no_such, with_keys
from pipeline.config.units import UNITS

ForceUnit = Literal["m_s2", "g", "mg", "ug", "cm_s2", "mm_s2"]
RateUnit = Literal["rad_s", "deg_s", "mrad_s", "mdeg_s", "ddeg_s", "cdeg_s", "deg_h", "rpm"]
Encoding = Literal["offset-binary", "twos-complement", "unsigned-twos-complement"]
FULL_SCALE, COUNTS_PER = "full_scale_", "counts_per_"  #: prefixes of the keys of a data sheet

#: name -> what the user would otherwise write under ``sensor:``.
PRESETS: Mapping[str, Mapping[str, Any]] = {
    # MTi data sheet as used by Angrisano et al.: 16 bit, ±5 g class (50 m/s²), ±150 °/s.
    "xsens-mti": {
        "name": "Xsens MTi",
        "accelerometer": {"full_scale_m_s2": 50.0, "bits": 16, "encoding": "offset-binary"},
        "gyroscope": {"full_scale_deg_s": 150.0, "bits": 16, "encoding": "offset-binary"},
    },
    # MPU-6000/6050 product specification after reset and after i2cdevlib's initialize():
    # AFS_SEL = 0 (±2 g, 16384 LSB/g) and FS_SEL = 0 (±250 °/s, 131 LSB/(°/s)).
    "mpu-6050": {
        "name": "InvenSense MPU-6050",
        "accelerometer": {"full_scale_g": 2.0, "bits": 16, "encoding": "twos-complement"},
        "gyroscope": {"full_scale_deg_s": 250.0, "bits": 16, "encoding": "twos-complement"},
    },
}


class TriadSheet(Section):
    """Data sheet of a triad: the part common to all kinds of triads."""

    bits: Annotated[int, Field(strict=True, ge=8, le=32)] | None = None
    encoding: Encoding | None = None
    unit: str | None = None


class AccelerometerSheet(TriadSheet):
    """Data sheet of an accelerometer, or the unit of logs that are in physical units already."""

    full_scale_m_s2: Positive | None = None
    full_scale_g: Positive | None = None
    counts_per_m_s2: Positive | None = None
    counts_per_g: Positive | None = None
    unit: ForceUnit | None = None


class GyroscopeSheet(TriadSheet):
    """Data sheet of a gyroscope, or the unit of logs that are in physical units already."""

    full_scale_deg_s: Positive | None = None
    full_scale_rad_s: Positive | None = None
    counts_per_deg_s: Positive | None = None
    counts_per_rad_s: Positive | None = None
    unit: RateUnit | None = None


class SensorSection(Section):
    """A sensor; in YAML a preset's name, or its data sheet."""

    name: str = "IMU"
    accelerometer: AccelerometerSheet | None = None
    gyroscope: GyroscopeSheet | None = None

    @property
    def sheets(self) -> Mapping[Triad, TriadSheet]:
        """The data sheets that are stated, the accelerometer's first."""
        stated = {triad: getattr(self, triad, None) for triad in TRIAD_KINDS}
        return {triad: sheet for triad, sheet in stated.items() if sheet is not None}


def sheet_section(kind: TriadKind) -> type[TriadSheet]:
    """The keys of the data sheet of a further kind of triad, by its units."""
    scales = {f"{stem}{unit}": (Positive | None, None)
              for stem in (FULL_SCALE, COUNTS_PER) for unit in kind.sheet_units}
    unit = Literal[kind.sheet_units] | None  # type: ignore[name-defined]
    return with_keys(TriadSheet, f"{kind.name.title()}Sheet", {**scales, "unit": (unit, None)})


def _preset(sensor: object) -> object:
    if not isinstance(sensor, str):
        return sensor
    if sensor not in PRESETS:
        raise no_such("sensor preset", sensor, tuple(PRESETS))
    return dict(PRESETS[sensor])


def sensor_or_preset(sensor: type[SensorSection]) -> Any:
    """The type of a key that names a preset or holds a data sheet."""
    return Annotated[sensor, BeforeValidator(_preset)]


def sensor_specs(sensor: SensorSection) -> Specs:
    """The data sheets that are stated, in SI units."""
    return {triad: triad_spec(sheet) for triad, sheet in sensor.sheets.items()}


def triad_spec(sheet: TriadSheet) -> TriadSpec:
    """The data sheet in SI units, for the start values of Angrisano et al. eq. (12)."""
    if sheet.unit is not None:
        return TriadSpec(math.inf, 0, "si", UNITS[sheet.unit][1])
    # One of the two is present: pipeline.config.rules.triad_sheet refuses a file without.
    if (per_unit := _stated(sheet, COUNTS_PER)) is not None:
        si_per_count = 1 / per_unit
        if sheet.bits is None or sheet.encoding is None:
            return TriadSpec(math.inf, 0, "si", si_per_count)
        codes = 2**sheet.bits - 1 if sheet.encoding == "offset-binary" else 2**sheet.bits
        return TriadSpec(si_per_count * codes / 2, sheet.bits, sheet.encoding)
    full_scale = _stated(sheet, FULL_SCALE)
    assert full_scale is not None
    assert sheet.bits is not None
    assert sheet.encoding is not None
    return TriadSpec(full_scale, sheet.bits, sheet.encoding)


def _stated(sheet: TriadSheet, stem: str) -> float | None:
    """Value of the key with this prefix: in SI units, counts in counts per SI unit."""
    for key in type(sheet).model_fields:
        value: float | None = getattr(sheet, key) if key.startswith(stem) else None
        if value is not None:
            factor = UNITS[key.removeprefix(stem)][1]
            return value / factor if stem == COUNTS_PER else value * factor
    return None
