"""The section of a configuration on recording."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from pipeline.config.types import Count, Positive, Section, no_such, refusal
from pipeline.devices.line_pattern import LinePattern
from pipeline.devices.table import DEVICES


def _device(name: str) -> str:
    if name not in DEVICES:
        raise no_such("device", name, tuple(DEVICES))
    return name


def _pattern(text: str) -> str:
    try:
        LinePattern.stated(text)
    except ValueError as error:
        raise refusal(str(error)) from error
    return text


SECONDS_PER_POSE = 10.0  #: batches of a second show the correlation of a mean's noise; chosen


class RecordSection(Section):
    """What ``pipeline record`` is to record, and from what."""

    device: Annotated[str, AfterValidator(_device)]
    port: str | None = None  #: the only USB serial port by default
    baud: Count | None = None  #: the usual speeds of the device are tried by default
    sample_rate_hz: Positive | None = None  #: what a sample counter counts
    poses: Annotated[Count, Field(ge=6, le=26)] = 18  #: faces, edges, corners, in this order
    seconds_per_pose: Annotated[Positive, Field(ge=2)] = SECONDS_PER_POSE
    order: Literal["natural", "random"] = "natural"  #: random separates time from attitude
    pattern: Annotated[str, AfterValidator(_pattern)] | None = None  #: pattern of ``device: lines``
    camera: Annotated[int, Field(strict=True, ge=0)] | None = None  #: films turning poses
