"""The other files: noise.json, the noise of a sensor at rest, and a line of history.jsonl."""

import math
from collections.abc import Mapping
from datetime import datetime
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from calib.poses.imu_log import TRIADS, Triad
from pipeline.results.schema.types import (
    MaybeSd,
    NotNegative,
    Number,
    Part,
    Positive,
    Text,
    means,
)

FORMAT = 1  #: version of noise.json; raised when its keys change


class CoefficientResult(Part):
    """A coefficient of IEEE Std 952, SI units."""

    value: MaybeSd = means("value; null where the log does not show it")
    sd: MaybeSd = means("its sd")
    below: NotNegative = means("upper limit at 95 %")
    needed_s: MaybeSd = means("length of a log that would show half the limit")


class AxisNoiseResult(Part):
    """One axis."""

    quantisation: CoefficientResult = means("Q, unit s")
    noise_density: CoefficientResult = means("N, unit/√Hz")
    bias_instability: CoefficientResult = means("B, unit; the flat of the curve is 0.664 B")
    random_walk: CoefficientResult = means("K, unit/s/√Hz")
    rate_ramp: CoefficientResult = means("R, unit/s")
    tau_s: list[Number] = means("averaging times")
    deviation: list[NotNegative] = means("overlapping Allan deviation, unit")
    low: list[NotNegative] = means("lower end of its band of 68 %")
    high: list[NotNegative] = means("upper end")


class TriadNoiseResult(Part):
    """A triad; its unit is m/s² or rad/s."""

    unit: Text = means("unit of the readings")
    axes: list[AxisNoiseResult] = Field(
        description="x, y, z", min_length=3, max_length=3)

    def over_axes(self, key: str) -> tuple[float, bool]:
        """Root mean square of a coefficient over the axes, and whether it is an upper limit only.
        """
        axes = [getattr(axis, key) for axis in self.axes]
        values = [axis.below if axis.value is None else axis.value for axis in axes]
        return math.hypot(*values) / math.sqrt(len(values)), any(a.value is None for a in axes)


class NoiseFile(Part):
    """noise.json."""

    format: Literal[1] = means("version of the format")
    log: Text = means("name of the log")
    rate_hz: NotNegative = means("sample rate", gt=0)
    length_s: NotNegative = means("length of the log")
    accelerometer: TriadNoiseResult | None = means("null where the log has none")
    gyroscope: TriadNoiseResult | None = means("null where the log has none")

    @property
    def triads(self) -> dict[Triad, TriadNoiseResult]:
        """The triads that the log has, by name."""
        both = {triad: getattr(self, triad) for triad in TRIADS}
        return {triad: one for triad, one in both.items() if one is not None}


def _moment(text: str) -> str:
    datetime.fromisoformat(text)  # a ValueError is what pydantic reports
    return text


class HistoryTriad(Part):
    """A triad in one run; the errors are in SI units."""

    model: list[Text] = means("effects of the model", min_length=1)
    residual_rms: NotNegative = means("RMS residual")
    loo_rms: NotNegative = means("leave-one-out error")
    chi2: NotNegative = means("chi² of the fit")
    dof: Positive = means("degrees of freedom")
    verdict: Text = means("code")


class HistoryLine(Part):
    """One run."""

    when: Annotated[str, AfterValidator(_moment)] = means("local time, ISO 8601")
    config_sha256: Text = means("SHA-256 of the configuration")
    accelerometer: HistoryTriad | None = means("null if it was not calibrated")
    gyroscope: HistoryTriad | None = means("null if it was not calibrated")
    further: dict[str, HistoryTriad] = means("further triads by name", default_factory=dict)

    @property
    def triads(self) -> Mapping[str, HistoryTriad]:
        """The triads that were calibrated, by name."""
        one = {triad: getattr(self, triad) for triad in TRIADS}
        return {**{triad: result for triad, result in one.items() if result is not None},
                **self.further}
