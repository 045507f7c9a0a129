"""The configuration of a session: all its sections, and the files that they name."""

from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

from pydantic import Field, PrivateAttr

from calib.poses.imu_log import Triad
from calib.poses.triad_kind import TRIAD_KINDS, TriadKind
from pipeline.cameras import cameras_file
from pipeline.config.record_section import CertificateSection, RecordSection
from pipeline.config.schema import (
    AccelerometerSection,
    EffectSection,
    GyroscopeSection,
    InstallationSection,
    Rate,
    RunSection,
    SiteSection,
    TimebaseSection,
    TriadFitSection,
    resting_section,
)
from pipeline.config.sensor import SensorSection, sensor_or_preset, sheet_section
from pipeline.config.types import FolderName, Section, UserEffectName, with_keys
from pipeline.config.yaml_text import PathTo, YamlSource


class Config(Section):
    """A session, as its YAML file states it; made by :func:`pipeline.config.load.load_config`.

    Values are as in the file, in the units of their keys. Every path exists.
    """

    title: str = ""
    output: FolderName | None = None
    sensor: SensorSection = SensorSection()
    rate: dict[str, Rate] = Field(default_factory=dict)
    site: SiteSection | None = None
    accelerometer: AccelerometerSection | None = None
    gyroscope: GyroscopeSection | None = None
    installation: InstallationSection | None = None
    certificate: CertificateSection | None = None
    effects: dict[UserEffectName, EffectSection] = Field(default_factory=dict)
    covariates: tuple[str, ...] | None = None
    record: RecordSection | None = None
    _source: YamlSource = PrivateAttr()

    @property
    def source(self) -> YamlSource:
        """The file's text, with the place of every value in it."""
        return self._source

    @property
    def triads(self) -> Mapping[Triad, TriadFitSection]:
        """The sections of the triads that are to be calibrated, the accelerometer first."""
        sections = {triad: getattr(self, triad, None) for triad in TRIAD_KINDS}
        return {triad: section for triad, section in sections.items() if section is not None}

    def runs_of(self, triad: Triad) -> tuple[RunSection, ...]:
        """The poses of a triad, at rest and run after run; none without its section."""
        section = self.triads.get(triad)
        return () if section is None else section.sections

    def placed_runs(self) -> Iterator[tuple[PathTo, RunSection]]:
        """Every set of poses with the keys to the mapping of the file that names it."""
        for triad, section in self.triads.items():
            yield from (((triad,), run) for run in section.at_rest)
            yield from (((triad, "runs", i), run) for i, run in enumerate(section.turning))

    @property
    def output_folder(self) -> Path:
        """Folder of the results: ``output``, or the file's stem + ``.run``; beside the file."""
        path = self._source.path
        return path.parent / (self.output or f"{path.stem}.run")


def session_model() -> type[Config]:
    """The keys of a session's file, with those of every kind of triad known so far."""
    return _session_model(tuple(kind for kind in TRIAD_KINDS.values() if kind.magnitude_key))


@cache
def _session_model(further: tuple[TriadKind, ...]) -> type[Config]:
    sheets = {kind.name: (sheet_section(kind) | None, None) for kind in further}
    sections = {kind.name: (resting_section(kind) | None, None) for kind in further}
    sensor = with_keys(SensorSection, "SensorSection", sheets)
    return with_keys(Config, "Config", {
        **sections, "sensor": (sensor_or_preset(sensor), sensor())})


def named_files(config: Config) -> Iterator[Path]:
    """Every file that a configuration names, itself excepted; some more than once.

    The clocks of the user's cameras are among them where it names a camera.
    """
    yield from files_in(config)
    for effect in config.effects.values():
        if effect.python is not None:
            yield config.source.path.parent / effect.python.partition(":")[0]


def files_in(value: object) -> Iterator[Path]:
    """The files in the values of a section, of a mapping or of a list."""
    if isinstance(value, Path):
        yield from _files(value)
    elif isinstance(value, TimebaseSection) and value.camera is not None:
        yield cameras_file()
    elif isinstance(value, Section | dict):
        for one in (dict(value) if isinstance(value, Section) else value).values():
            yield from files_in(one)
    elif isinstance(value, list | tuple):
        for one in value:
            yield from files_in(one)


def _files(path: Path) -> Iterator[Path]:
    """The files of a path: itself, all in a folder, or the archive that contains it."""
    if path.is_dir():
        yield from (one for one in path.rglob("*") if one.is_file())
        return
    yield next((one for one in (path, *path.parents) if one.is_file()), path)
