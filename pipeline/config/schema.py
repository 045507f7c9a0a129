"""The sections of a configuration: every key, its type and its range.

Units are in the keys, as users write them; the reader of a value converts it once. Keys that
exclude or require each other are in :mod:`pipeline.config.rules`. Paths are relative to the file.
"""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import (
    AfterValidator,
    Discriminator,
    Field,
    Tag,
    ValidationInfo,
    model_validator,
)

from calib.earth import GREATEST_GRAVITY_M_S2, LEAST_GRAVITY_M_S2
from calib.effects.catalogue import BASE
from calib.mounting.levelling import Order
from calib.poses.triad_kind import TriadKind
from pipeline.cameras import known_cameras
from pipeline.config.types import (
    STOPPED,
    CameraName,
    Columns,
    Effects,
    Files,
    Number,
    PoseNames,
    Positive,
    RateName,
    SampleRate,
    Section,
    TriadName,
    VisionTerms,
    may_be_missing,
    refusal,
    with_keys,
)
from pipeline.config.units import FASTEST_RPM
from pipeline.logs.columns import Renamed, TimeUnit
from vision.rate.timebase import CLOCK_PPM

# --- site ---------------------------------------------------------------------------------------


class SiteSection(Section):
    """The site: gravity and the Earth's rate. The ranges are those of the Earth's surface."""

    gravity_m_s2: Annotated[
        Number, Field(ge=LEAST_GRAVITY_M_S2, le=GREATEST_GRAVITY_M_S2)] | None = None
    sd_m_s2: Positive | None = None
    latitude_deg: Annotated[Number, Field(ge=-90, le=90)] | None = None
    height_m: Annotated[Number, Field(ge=-500, le=9000)] = 0.0


# --- rates -------------------------------------------------------------------------------------

class TimebaseSection(Section):
    """Source of a clip's time: its own stamps, or a constant frame rate.

    ``camera`` names a camera whose clock was measured; its stamps are corrected by that.
    """

    source: Literal["container", "constant"] = "container"
    fps: Positive | None = None
    ppm: Annotated[Number, Field(ge=0)] | None = None
    camera: CameraName | None = None

    @property
    def relative_sd(self) -> float:
        """One standard deviation of the clock's rate, as a fraction."""
        if self.camera is not None:
            return known_cameras()[self.camera].sd_ppm * 1e-6
        ppm = CLOCK_PPM[self.source] if self.ppm is None else self.ppm
        return ppm * 1e-6


class PlateSection(Section):
    """The plate's ellipse and its mark, stated by hand where they are not detected."""

    centre_px: tuple[Number, Number]
    radii_px: tuple[Positive, Positive]
    angle_deg: Number = 0.0


class VideoRateSection(Section):
    """A plate setting measured from clips: one for the whole run, or one per pose."""

    video: Files
    nominal_rpm: Annotated[Positive, Field(le=FASTEST_RPM)] | None = None
    timebase: TimebaseSection = TimebaseSection()
    model: VisionTerms = ("constant_rate",)
    plate: PlateSection | None = None
    from_s: Positive | None = None
    to_s: Positive | None = None

    @model_validator(mode="after")
    def _forwards(self) -> "VideoRateSection":
        if self.to_s is not None and self.to_s <= (self.from_s or 0.0):
            raise refusal(f"to_s is {self.to_s:g}, which is not after from_s")
        return self


def _turning(rate_rad_s: float) -> float:
    if rate_rad_s == 0:
        raise refusal("a plate that does not turn has no entry; write `rate: stopped` in the run")
    return rate_rad_s


class KnownRateSection(Section):
    """A plate setting measured elsewhere; a negative rate turns the other way."""

    rate_rad_s: Annotated[Number, AfterValidator(_turning)]
    sd_rad_s: Positive


def _kind_of_rate(entry: object) -> str:
    """Known if a rate and no video is stated; otherwise the entry is read as a video's."""
    stated = isinstance(entry, Mapping) and any(re.match(r"(rate|sd)(_|$)", key) for key in entry)
    return "<known>" if stated and "video" not in entry else "<video>"  # type: ignore[operator]


Rate = Annotated[
    Annotated[VideoRateSection, Tag("<video>")] | Annotated[KnownRateSection, Tag("<known>")],
    Discriminator(_kind_of_rate),
]

# --- poses and triads --------------------------------------------------------------------------


class StillSection(Section):
    """The user's settings of the search for static intervals.

    ``seconds`` is the shortest stop, ``threshold`` the noise allowed in it as a multiple of that of
    the quietest rest.
    """

    seconds: Annotated[Positive, Field(le=60)] | None = None
    threshold: Annotated[Positive, Field(ge=1)] | None = None


class LogsSection(Section):
    """Log files: how their columns are named, and whether static intervals are to be found."""

    FILE_KEYS: ClassVar[tuple[str, ...]] = ()

    columns: Columns | None = None
    sample_rate_hz: SampleRate | None = None
    time_unit: TimeUnit | None = None  #: unit of the column of times; by default its name states it
    find: Literal["still"] | None = None
    still: StillSection = StillSection()

    def files_by_key(self) -> Mapping[str, tuple[Path, ...]]:
        """The files that each key of the section names."""
        return {key: getattr(self, key) for key in self.FILE_KEYS}

    def columns_of(self, i: int) -> tuple[str, ...] | Renamed | None:
        """The names for the i-th file of a key: the i-th list, or the one list for all files."""
        if self.columns is None:
            return None
        return self.columns[i] if len(self.columns) > 1 else self.columns[0]


class PosesSection(LogsSection):
    """One file per pose (a pattern or a list), long logs with static intervals, or pose means."""

    FILE_KEYS = ("files", "log", "means")

    files: Files = ()
    log: Files = ()
    means: Files = ()

    @model_validator(mode="before")
    @classmethod
    def _files_alone(cls, poses: object) -> object:
        return {"files": poses} if isinstance(poses, str | list) else poses

    @model_validator(mode="after")
    def _names_files(self, info: ValidationInfo) -> "PosesSection":
        if not any(self.files_by_key().values()) and not may_be_missing(info):
            raise refusal("names no file. Name the logs of the poses, as in 'pose_*.csv'")
        return self


#: Sd of the attitude of a case on a face or an edge in every pose, degrees.
AttitudeSd = Annotated[Positive, Field(le=5)]


class RunSection(Section):
    """Poses taken at one plate setting."""

    poses: PosesSection
    rate: RateName
    exclude: PoseNames = ()
    attitude_sd_deg: AttitudeSd | None = None

    @model_validator(mode="after")
    def _attitudes_turn(self) -> "RunSection":
        if self.rate == STOPPED and self.attitude_sd_deg is not None:
            raise refusal("attitude_sd_deg says nothing of a gyroscope at rest: take it out")
        return self

    @property
    def recorded(self) -> "RunSection":
        """Key of the recording of its poses, at this rate and without the excluded ones."""
        return self.model_copy(update={"attitude_sd_deg": None})


class TriadFitSection(Section):
    """Settings of the fit of a triad's poses, all runs jointly."""

    model: Effects = BASE
    solver: Literal["default", "paper"] = "default"
    loss: Literal["squares", "huber"] = "squares"

    @property
    def at_rest(self) -> tuple[RunSection, ...]:
        """Poses that are named outside ``runs``, as a run of a plate that is stopped."""
        poses: PosesSection | None = getattr(self, "poses", None)
        if poses is None:
            return ()
        return (RunSection.model_construct(
            poses=poses, rate=STOPPED, exclude=getattr(self, "exclude", ()),
            attitude_sd_deg=getattr(self, "attitude_sd_deg", None)),)

    @property
    def turning(self) -> tuple[RunSection, ...]:
        """The runs on the plate."""
        runs: tuple[RunSection, ...] = getattr(self, "runs", ())
        return runs

    @property
    def sections(self) -> tuple[RunSection, ...]:
        """The poses at rest, then the runs."""
        return self.at_rest + self.turning


class AccelerometerSection(TriadFitSection):
    """The accelerometer: poses at rest, runs on a turning plate that leans, or both."""

    poses: PosesSection | None = None
    exclude: PoseNames = ()
    attitude_sd_deg: AttitudeSd | None = None
    runs: tuple[RunSection, ...] = ()

    @model_validator(mode="after")
    def _attitudes_at_rest(self) -> "AccelerometerSection":
        if any(run.attitude_sd_deg is not None for run in self.runs):
            raise refusal("attitude_sd_deg is for poses at rest or on a level plate, and the runs "
                          "of an accelerometer are taken on a plate that leans: take it out")
        if self.attitude_sd_deg is not None and self.poses is None:
            raise refusal("attitude_sd_deg belongs to poses, and none are named")
        return self


class GyroscopeSection(TriadFitSection):
    """The gyroscope: its poses stand in runs."""

    runs: Annotated[tuple[RunSection, ...], Field(min_length=1)]


def resting_section(kind: TriadKind) -> type[TriadFitSection]:
    """A further triad: poses at rest, and the magnitude of the field that it senses there."""
    magnitudes = dict.fromkeys((kind.magnitude_key, kind.sd_key), (Positive, ...))
    return with_keys(TriadFitSection, f"{kind.name.title()}Section", {
        "poses": (PosesSection, ...), "exclude": (PoseNames, ()), **magnitudes})


class EffectSection(Section):
    """A user-defined effect: an expression in the pose's columns, or a Python function.

    ``shapes`` maps the name of a shape parameter to its unit and its bounds; ``alike`` holds the
    expressions that the poses did not tell from its own where it was found.
    """

    expression: str | None = None
    python: str | None = None
    per: Literal["axis", "common", "matrix", "reference"] = "axis"
    shapes: Annotated[dict[str, tuple[str, Positive, Positive]], Field(max_length=1)] = Field(
        default_factory=dict)
    alike: tuple[str, ...] = ()
    unit: str
    triad: TriadName | None = None


class InstallationSection(LogsSection):
    """Logs of the sensor where it is mounted, for roll, pitch and yaw of the mounting."""

    FILE_KEYS = ("log", "reverse_log", "drive_log")

    log: Files
    reverse_log: Files = ()
    drive_log: Files = ()
    drive_direction: Literal["forward", "backward"] = "forward"
    order: Order | None = None  #: order of the rotations; by eq. (6) of Promrit et al. where None
