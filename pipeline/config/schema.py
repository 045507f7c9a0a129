"""The sections of a configuration: every key, its type and its range.

Units are in the keys, as users write them; whoever reads a value converts it once. Which keys
exclude or need each other is in :mod:`pipeline.config.rules`. Paths are relative to the file.
"""

import re
from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag, model_validator

from calib.effects.catalogue import BASE
from pipeline.config.presets import PRESETS
from pipeline.config.types import (
    Columns,
    Count,
    Effects,
    Files,
    Number,
    Positive,
    RateName,
    Section,
    Three,
    VisionTerms,
    no_such,
    refusal,
)
from pipeline.devices.line_pattern import LinePattern
from pipeline.devices.table import DEVICES

#: Sd of a camera's clock, parts per million, where nobody states it: crystals are good to 20-100;
#: a stated frame rate ("15 fps") is often a rounded or nominal one.
CLOCK_PPM = {"container": 100.0, "constant": 500.0}

# --- sensor and site ---------------------------------------------------------------------------


class _TriadSheet(Section):
    bits: Annotated[int, Field(strict=True, ge=8, le=32)] | None = None
    encoding: Literal["offset-binary", "twos-complement"] | None = None


class AccelerometerSheet(_TriadSheet):
    """Data sheet of an accelerometer, or the unit of logs that are in physical units already."""

    full_scale_m_s2: Positive | None = None
    full_scale_g: Positive | None = None
    unit: Literal["m_s2", "g"] | None = None


class GyroscopeSheet(_TriadSheet):
    """Data sheet of a gyroscope, or the unit of logs that are in physical units already."""

    full_scale_deg_s: Positive | None = None
    full_scale_rad_s: Positive | None = None
    unit: Literal["rad_s", "deg_s"] | None = None


class Sensor(Section):
    """A sensor; in YAML a preset's name, or its data sheet."""

    name: str = "IMU"
    accelerometer: AccelerometerSheet | None = None
    gyroscope: GyroscopeSheet | None = None


def _preset(given: object) -> object:
    if not isinstance(given, str):
        return given
    if given not in PRESETS:
        raise no_such("sensor preset", given, tuple(PRESETS))
    return dict(PRESETS[given])


class Site(Section):
    """Where it was done: gravity and the Earth's rate. Ranges are those of the Earth's surface."""

    gravity_m_s2: Annotated[Number, Field(ge=9.7, le=9.9)] | None = None
    sd_m_s2: Positive | None = None
    latitude_deg: Annotated[Number, Field(ge=-90, le=90)] | None = None
    height_m: Annotated[Number, Field(ge=-500, le=9000)] = 0.0


# --- rates -------------------------------------------------------------------------------------

class Timebase(Section):
    """Where a clip's time comes from: its own stamps, or a constant frame rate."""

    source: Literal["container", "constant"] = "container"
    fps: Positive | None = None
    ppm: Annotated[Number, Field(ge=0)] | None = None

    @property
    def relative_sd(self) -> float:
        """One standard deviation of the clock's rate, as a fraction."""
        ppm = CLOCK_PPM[self.source] if self.ppm is None else self.ppm
        return ppm * 1e-6


class Plate(Section):
    """The plate's ellipse and its mark, stated by hand where they cannot be found."""

    centre_px: tuple[Number, Number]
    radii_px: tuple[Positive, Positive]
    angle_deg: Number = 0.0


class VideoRate(Section):
    """A plate setting measured from clips: one for the whole run, or one per pose."""

    video: Files
    nominal_rpm: Positive | None = None
    timebase: Timebase = Timebase()
    model: VisionTerms = ("constant_rate",)
    plate: Plate | None = None


class KnownRate(Section):
    """A plate setting measured elsewhere."""

    rate_rad_s: Positive
    sd_rad_s: Positive


def _kind_of_rate(given: object) -> str:
    """Known where a rate and no video is stated; anything else is read as a video's entry."""
    stated = isinstance(given, Mapping) and any(re.match(r"(rate|sd)(_|$)", key) for key in given)
    return "<known>" if stated and "video" not in given else "<video>"  # type: ignore[operator]


Rate = Annotated[
    Annotated[VideoRate, Tag("<video>")] | Annotated[KnownRate, Tag("<known>")],
    Discriminator(_kind_of_rate),
]

# --- poses and triads --------------------------------------------------------------------------


class StillSection(Section):
    """What the user overrules of the search for static intervals.

    ``seconds`` is the shortest stop, ``threshold`` the noise allowed in it as a multiple of that of
    the quietest rest.
    """

    seconds: Annotated[Positive, Field(le=60)] | None = None
    threshold: Annotated[Positive, Field(ge=1)] | None = None


class Poses(Section):
    """One file per pose (a pattern or a list), or one long log in which still parts are found."""

    files: Files = ()
    log: Files = ()
    columns: Columns | None = None
    sample_rate_hz: Positive | None = None
    find: Literal["still"] | None = None
    still: StillSection = StillSection()

    @model_validator(mode="before")
    @classmethod
    def _files_alone(cls, given: object) -> object:
        return {"files": given} if isinstance(given, str | list) else given

    def columns_of(self, i: int) -> tuple[str, ...] | None:
        """The names for the i-th file: its own list, or the one for all."""
        if self.columns is None:
            return None
        return self.columns[i] if len(self.columns) > 1 else self.columns[0]


class Accelerometer(Section):
    """What to fit to the accelerometer's poses."""

    poses: Poses
    model: Effects = BASE
    solver: Literal["default", "paper"] = "default"
    loss: Literal["squares", "huber"] = "squares"


class Run(Section):
    """Poses taken at one plate setting."""

    poses: Poses
    rate: RateName


class Gyroscope(Section):
    """What to fit to the gyroscope's poses, all runs jointly."""

    runs: Annotated[tuple[Run, ...], Field(min_length=1)]
    model: Effects = BASE
    solver: Literal["default", "paper"] = "default"
    loss: Literal["squares", "huber"] = "squares"


# --- the rest ----------------------------------------------------------------------------------


class TriadCertificate(Section):
    """A factory certificate's values of one triad, to lay beside the estimate."""

    bias_counts: Three
    scale_counts_per_unit: Three
    misalignment_rad: Three | None = None
    alignment: tuple[Three, Three, Three] | None = None


class Certificate(Section):
    """The factory certificate."""

    accelerometer: TriadCertificate | None = None
    gyroscope: TriadCertificate | None = None


class OwnEffect(Section):
    """A user's own effect: an expression in the pose's columns, or a Python function."""

    expression: str | None = None
    python: str | None = None
    per: Literal["axis", "common", "reference"] = "axis"
    unit: str
    triad: Literal["accelerometer", "gyroscope"] | None = None


class Installation(Section):
    """Logs of the sensor where it is mounted, for roll, pitch and yaw of the mounting."""

    log: Files
    reverse_log: Files = ()
    drive_log: Files = ()
    drive_direction: Literal["forward", "backward"] = "forward"
    columns: Columns | None = None
    sample_rate_hz: Positive | None = None
    find: Literal["still"] | None = None
    still: StillSection = StillSection()


def _device(name: str) -> str:
    if name not in DEVICES:
        raise no_such("device", name, tuple(DEVICES))
    return name


def _pattern(text: str) -> str:
    try:
        LinePattern.of(text)
    except ValueError as error:
        raise refusal(str(error)) from error
    return text


class Record(Section):
    """What ``pipeline record`` is to record, and from what."""

    device: Annotated[str, AfterValidator(_device)]
    port: str | None = None  #: the only USB serial port by default
    baud: Count | None = None  #: the usual speeds of the device are tried by default
    sample_rate_hz: Positive | None = None  #: an Xsens is set to it; others have their own
    poses: Annotated[Count, Field(ge=6, le=26)] = 18  #: faces, edges, corners, in this order
    seconds_per_pose: Annotated[Positive, Field(ge=2)] = 10.0
    order: Literal["natural", "random"] = "natural"  #: random parts time from attitude
    pattern: Annotated[str, AfterValidator(_pattern)] | None = None  #: of ``device: lines``
    camera: Annotated[int, Field(strict=True, ge=0)] | None = None  #: films turning poses


SensorOrPreset = Annotated[Sensor, BeforeValidator(_preset)]


