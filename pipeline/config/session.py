"""The configuration of a session: all its sections."""

from collections.abc import Iterator, Mapping
from pathlib import Path

from pydantic import Field, PrivateAttr

from calib.poses.imu_log import TRIADS, Triad
from pipeline.config.certificate import CertificateSection
from pipeline.config.schema import (
    AccelerometerSection,
    EffectSection,
    GyroscopeSection,
    InstallationSection,
    Rate,
    RecordSection,
    RunSection,
    SiteSection,
    TriadFitSection,
)
from pipeline.config.sensor import SensorOrPreset, SensorSection
from pipeline.config.types import FolderName, Section, UserEffectName
from pipeline.config.yaml_text import PathTo, YamlSource


class Config(Section):
    """A session, as its YAML file states it; made by :func:`pipeline.config.load.load_config`.

    Values are as in the file, in the units of their keys. Every path exists.
    """

    title: str = ""
    output: FolderName | None = None
    sensor: SensorOrPreset = SensorSection()
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
        sections = {triad: getattr(self, triad) for triad in TRIADS}
        return {triad: section for triad, section in sections.items() if section is not None}

    def runs_of(self, triad: Triad) -> tuple[RunSection, ...]:
        """The poses of a triad, at rest and run after run; none without its section."""
        section = self.triads.get(triad)
        return () if section is None else section.sections

    def placed_runs(self) -> Iterator[tuple[PathTo, RunSection]]:
        """Every set of poses with the keys to the mapping of the file that names it."""
        for triad, section in self.triads.items():
            yield from (((triad,), run) for run in section.at_rest)
            yield from (((triad, "runs", i), run) for i, run in enumerate(section.runs))

    @property
    def output_folder(self) -> Path:
        """Where results go: ``output``, or the file's stem + ``.run``; beside the file."""
        path = self._source.path
        return path.parent / (self.output or f"{path.stem}.run")
