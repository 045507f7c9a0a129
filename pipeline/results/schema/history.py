"""A line of history.jsonl."""

from collections.abc import Mapping
from datetime import datetime
from typing import Annotated

from pydantic import AfterValidator

from calib.poses.imu_log import TRIADS
from pipeline.results.schema.types import NotNegative, Part, Positive, Text, means


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
