"""results.json as a whole."""

from functools import cache
from typing import Any, Literal

import numpy as np
from pydantic import Field, create_model, model_validator

from calib.poses.imu_log import TRIADS, Triad
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.results.schema.rate import RateResult
from pipeline.results.schema.triad import (
    AccelerometerResult,
    FurtherResult,
    GyroscopeResult,
    TriadSection,
)
from pipeline.results.schema.types import (
    Count,
    Matrix,
    MaybeSd,
    NotNegative,
    Number,
    Part,
    Text,
    Three,
    means,
)

WHERE_FURTHER = "absent if it was not calibrated; else as the first two, and:"
ORTHOGONAL = 1e-6  #: deviation of R Rᵀ from the unit matrix: no worse in files of other programs


class OrderResult(Part):
    """The mounting in one order of the rotations."""

    order: Text = means("order of the rotations")
    roll_deg: Number = means("roll")
    pitch_deg: Number = means("pitch")
    sd_deg: list[MaybeSd] = means("their sds; null where the order is locked",
                                  min_length=2, max_length=2)
    margin: NotNegative = means("its side of eq. (6); the smaller side names the order")
    residual_m_s2: NotNegative = means("distance of the levelled mean reading from (0, 0, g)")


class InstallationResult(Part):
    """The mounting of the sensor (Promrit et al.)."""

    order: Text = means("order of the rotations")
    roll_deg: Number = means("roll")
    pitch_deg: Number = means("pitch")
    sd_deg: list[MaybeSd] = means("sds of roll and pitch", min_length=2, max_length=2)
    yaw_deg: Number | None = means("yaw; null where no drive was logged")
    yaw_sd_deg: MaybeSd = means("its sd")
    floor_rise_deg: list[Number] | None = means("rise of the floor; null without a reversed log")
    floor_rise_sd_deg: list[MaybeSd] | None = means("its sds")
    rotation: Matrix = means("R, from the axes of the vehicle to those of the sensor")
    before: Three = means("mean specific force before the rotation, m/s²")
    after: Three = means("after it")
    magnitude_error_m_s2: Number = means("magnitude less gravity")
    readings: Count = means("samples")
    orders: list[OrderResult] = Field(default_factory=list,
                                      description="both orders of the rotations")
    notes: list[Text] = means("warnings in words")

    @model_validator(mode="after")
    def _is_a_rotation(self) -> "InstallationResult":
        r = np.array(self.rotation)
        if not np.allclose(r @ r.T, np.eye(3), atol=ORTHOGONAL) or np.linalg.det(r) < 0:
            raise ValueError("rotation is no rotation matrix")
        return self


class ResultsFile(Part):
    """results.json."""

    format: Literal[1] = means("version of the format")
    title: Text = means("title of the session")
    sensor: Text = means("name of the sensor")
    config: Text | None = means("name of the configuration's file", default=None)
    config_sha256: Text = means("SHA-256 of the configuration")
    inputs_sha256: Text | None = means(
        "SHA-256 of what it states and of the logs that it names, without comments", default=None)
    session_start_s: Number | None = means("earliest sample of all logs, s by their clock")
    rate: dict[str, RateResult] = means("plate settings by name")
    accelerometer: AccelerometerResult | None = means("null if it was not calibrated")
    gyroscope: GyroscopeResult | None = means("null if it was not calibrated")
    installation: InstallationResult | None = means("null without the section")
    columns: list[list[Text] | dict[str, Text]] = Field(
        default_factory=list, description="`columns` of the session's logs, each once")
    tables: list[Text] = Field(
        default_factory=list,
        description="for each of `columns` the table in a file that has it, empty if the file is "
                    "one table")
    sample_rates_hz: list[Number] = Field(
        default_factory=list,
        description="`sample_rate_hz` of the session's logs, Hz, each once")
    warnings: list[Text] = Field(default_factory=list, description="warnings of the run in words")

    @property
    def triads(self) -> dict[Triad, TriadSection]:
        """The triads that were calibrated, by name."""
        sections = {triad: getattr(self, triad, None) for triad in TRIAD_KINDS}
        return {triad: one for triad, one in sections.items() if one is not None}


def results_file() -> type[ResultsFile]:
    """The keys of results.json, with those of every kind of triad that is known by now."""
    return _results_file(tuple(kind for kind in TRIAD_KINDS if kind not in TRIADS))


@cache
def _results_file(further: tuple[Triad, ...]) -> type[ResultsFile]:
    sections: dict[str, Any] = {
        triad: (FurtherResult | None, means(WHERE_FURTHER, default=None)) for triad in further}
    return create_model("ResultsFile", __base__=ResultsFile, **sections)
