"""The sections of a configuration on recording and of a factory certificate."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from pipeline.config.types import Count, Positive, SampleRate, Section, Three, one_of, refusal
from pipeline.devices.line_pattern import LinePattern
from pipeline.devices.table import DEVICES


def _pattern(text: str) -> str:
    try:
        LinePattern.stated(text)
    except ValueError as error:
        raise refusal(str(error)) from error
    return text


SECONDS_PER_POSE = 10.0  #: batches of a second show the correlation of a mean's noise; chosen


class RecordSection(Section):
    """Settings of ``pipeline record``: what to record, and from which device."""

    device: Annotated[str, one_of("device", DEVICES)]
    port: str | None = None  #: the only USB serial port by default
    baud: Count | None = None  #: the usual speeds of the device are tried by default
    sample_rate_hz: SampleRate | None = None  #: an Xsens is set to it; others have their own
    poses: Annotated[Count, Field(ge=6, le=26)] = 18  #: faces, edges, corners, in this order
    seconds_per_pose: Annotated[Positive, Field(ge=2)] = SECONDS_PER_POSE
    order: Literal["natural", "random"] = "natural"  #: random separates time from attitude
    pattern: Annotated[str, AfterValidator(_pattern)] | None = None  #: pattern of ``device: lines``
    camera: Annotated[int, Field(strict=True, ge=0)] | None = None  #: films turning poses


class TriadCertificateSection(Section):
    """A factory certificate's values of one triad, for comparison with the estimate."""

    bias_counts: Three
    scale_counts_per_unit: Three
    misalignment_rad: Three | None = None
    alignment: tuple[Three, Three, Three] | None = None


class CertificateSection(Section):
    """The factory certificate."""

    accelerometer: TriadCertificateSection | None = None
    gyroscope: TriadCertificateSection | None = None
