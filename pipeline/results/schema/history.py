"""A line of history.jsonl."""

from datetime import datetime
from typing import Annotated

from pydantic import Field

from pipeline.results.schema.types import Count, NotNegative, Part, Text, means


class HistoryTriad(Part):
    """A triad in one run; the errors are in SI units."""

    model: list[Text] = means("effects of the model", min_length=1)
    residual_rms: NotNegative = means("RMS residual")
    loo_rms: NotNegative = means("leave-one-out error")
    chi2: NotNegative = means("chi² of the fit")
    dof: Count = means("degrees of freedom", ge=1)
    verdict: Text = means("code")


class HistoryLine(Part):
    """One run."""

    when: Annotated[datetime, Field(strict=False)] = means("local time")
    config_sha256: Text = means("SHA-256 of the configuration")
    accelerometer: HistoryTriad | None = means("null where it was not calibrated")
    gyroscope: HistoryTriad | None = means("null where it was not calibrated")
