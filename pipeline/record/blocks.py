"""The blocks of a recording: files of their poses, requirements, results of the pose detector."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from calib.numbers import RPM
from calib.poses.data_sheet import Specs
from calib.poses.imu_log import FloatArray
from pipeline.config.file_patterns import is_pattern, natural_key
from pipeline.config.load import Config
from pipeline.config.schema import VideoRateSection
from pipeline.config.types import STOPPED
from pipeline.config.yaml_text import PathTo
from pipeline.errors import ConfigError
from pipeline.record.stream import TimedSample
from pipeline.stages.pose_means import pose_seconds


@dataclass(frozen=True)
class NumberedFiles:
    """Numbered files: ``folder/before07after``."""

    folder: Path
    before: str
    after: str

    def path(self, number: int) -> Path:
        """The file of this number, from 1."""
        return self.folder / f"{self.before}{number:02d}{self.after}"

    def existing(self) -> list[Path]:
        """The files that exist, in natural order."""
        paths = self.folder.glob(f"{self.before}*{self.after}") if self.folder.is_dir() else ()
        return sorted(paths, key=lambda path: natural_key(path.name))

    def next_number(self) -> int:
        """The lowest unused number."""
        number = 1
        while self.path(number).exists():
            number += 1
        return number


@dataclass(frozen=True)
class RecordingBlock:
    """Poses at one plate setting.

    Parameters
    ----------
    rate : str
        Name of the plate setting, ``stopped`` at rest.
    poses : NumberedFiles
        Files to which they are written.
    rate_rad_s : float or None
        The plate's approximate rate, either way round; 0 at rest, None where the configuration
        states none.
    seconds : float
        Length of a pose.
    clips : NumberedFiles or Path or None
        Where the configuration wants clips: one for each pose, one for all, none.
    leans : bool
        Whether the accelerometer is calibrated by them too, so that the plate has to lean.
    """

    rate: str
    poses: NumberedFiles
    rate_rad_s: float | None
    seconds: float
    clips: NumberedFiles | Path | None
    leans: bool = False

    @property
    def turns(self) -> bool:
        """Whether the plate turns."""
        return self.rate != STOPPED


def recording_blocks(config: Config) -> tuple[RecordingBlock, ...]:
    """The blocks of a session, at rest first, each set of files once.

    Raises
    ------
    ConfigError
        A section names its poses in a way that gives no file names for new ones.
    """
    assert config.record is not None
    blocks: dict[NumberedFiles, RecordingBlock] = {}
    for keys, run in config.placed_runs():
        rate, poses = run.rate, _numbered(config, (*keys, "poses"))
        if poses is None or poses in blocks:
            continue
        stated = config.rate.get(rate)
        rate_rad_s: float | None = 0.0 if rate == STOPPED else None
        clips = None
        if isinstance(stated, VideoRateSection):
            clips = _clips(config, ("rate", rate, "video"))
            if stated.nominal_rpm is not None:
                rate_rad_s = stated.nominal_rpm * RPM
        elif stated is not None:
            rate_rad_s = abs(stated.rate_rad_s)  # its sign says which way the plate turns
        blocks[poses] = RecordingBlock(
            rate, poses, rate_rad_s, pose_seconds(config.record, rate_rad_s), clips,
            leans=rate != STOPPED and keys[0] == "accelerometer")
    return tuple(sorted(blocks.values(), key=lambda block: block.turns))


def _numbered(config: Config, path: PathTo) -> NumberedFiles | None:
    """Files for new poses of this section; None if it names existing files."""
    value = config.source.value(path)
    if isinstance(value, dict):
        value = value.get("files", value)
    text = value[0] if isinstance(value, list) and len(value) == 1 else value
    starred = text.replace("[0-9][0-9]", "*") if isinstance(text, str) else ""  # as import writes
    if starred.count("*") == 1 and starred.endswith(".csv"):
        folder, _, name = starred.rpartition("/")
        before, _, after = name.partition("*")
        if "*" in name and not is_pattern(folder + before + after):
            return NumberedFiles(config.source.path.parent / folder, before, after)
    raise ConfigError(config.source.problem(path, (
        f"found {text!r}, from which no names of new files follow; `pipeline record` writes one "
        "file per pose. Give a pattern with one star, as in accelerometer/pose_*.csv."
    )))


def _clips(config: Config, path: PathTo) -> NumberedFiles | Path:
    """Files for clips: numbered like the poses where the name has a star."""
    value = config.source.value(path)
    text = value[0] if isinstance(value, list) and len(value) == 1 else value
    folder, _, name = str(text).rpartition("/")
    home = config.source.path.parent / folder
    if isinstance(text, str) and name.count("*") == 1 and not is_pattern(folder):
        before, _, after = name.partition("*")
        return NumberedFiles(home, before, after)
    if isinstance(text, str) and not is_pattern(text):
        return home / name
    raise ConfigError(config.source.problem(path, (
        f"found {text!r}, from which no name of a new clip follows. Give one name, or a pattern "
        "with one star for a clip of every pose, as in video/17rpm_*.mkv."
    )))


def require_clip_names(config: Config, blocks: tuple[RecordingBlock, ...]) -> None:
    """Refuse to film where the configuration has no name for the clip of every pose.

    Raises
    ------
    ConfigError
        With what to write instead.
    """
    for block in blocks:
        clips = block.clips
        if block.turns and not (isinstance(clips, NumberedFiles) and clips.after.endswith(".mkv")):
            raise ConfigError(config.source.problem(("rate", block.rate), (
                "filming makes a clip of every pose, as Matroska, whose stamps are those of the "
                f"frames. Write `video: video/{block.rate}_*.mkv`, or record without a camera."
            )))


Phase = Literal["moving", "unsteady", "taking", "repeats", "between", "wrong", "taken"]


@dataclass(frozen=True, eq=False)
class Status:
    """State to show.

    ``reading`` (6,) is the mean of the last hop in nominal SI units, ``direction`` names the side
    that faces up, ``progress`` runs from 0 to 1 while a pose is taken.
    """

    phase: Phase
    message: str
    direction: str
    progress: float
    reading: FloatArray


@dataclass(frozen=True)
class Refused:
    """A pose that was begun and not completed; ``message`` gives the reason."""

    message: str


@dataclass(frozen=True)
class Complete:
    """The rows of a whole pose, and the index of the wanted direction that it covers."""

    rows: list[TimedSample]
    direction: int


@dataclass(frozen=True, eq=False)
class Task:
    """Requirements of a block.

    Parameters
    ----------
    wanted : array, shape (n, 3)
        Directions to be covered, in the order in which they are suggested.
    specs : mapping of triad to TriadSpec
        Data sheets.
    seconds : float
        Length of a pose.
    rate_rad_s : float or None
        0 at rest; else about how fast the plate turns, None where that is not known.
    rest_rad_s : array, shape (3,), or None
        What the gyroscope reads at rest, where poses at rest show it.
    """

    wanted: FloatArray
    specs: Specs
    seconds: float
    rate_rad_s: float | None
    rest_rad_s: FloatArray | None

    @property
    def turns(self) -> bool:
        """Whether the plate should turn."""
        return self.rate_rad_s != 0.0
