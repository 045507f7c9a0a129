"""The configuration of a session: one YAML file, checked as a whole before anything slow runs."""

from collections.abc import Iterator, Mapping
from itertools import chain
from pathlib import Path

from pydantic import Field, PrivateAttr, ValidationError

from calib.poses.imu_log import TRIADS, Triad
from pipeline.config.certificate import CertificateSection
from pipeline.config.contradictions import contradictions
from pipeline.config.messages import problems_in
from pipeline.config.problems import ConfigProblem, config_error
from pipeline.config.schema import (
    AccelerometerSection,
    EffectSection,
    GyroscopeSection,
    InstallationSection,
    LogsSection,
    Rate,
    RecordSection,
    RunSection,
    SiteSection,
    TriadFitSection,
    VideoRateSection,
)
from pipeline.config.sensor import SensorOrPreset, SensorSection
from pipeline.config.types import (
    FolderName,
    Section,
    UserEffectName,
    ValidationContext,
)
from pipeline.config.yaml_text import PathTo, YamlSource, parse_source, read_source
from pipeline.text.formatting import count


class Config(Section):
    """A session, as its YAML file states it; made by :func:`load_config`.

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


def load_config(path: Path, *, files_may_be_missing: bool = False) -> Config:
    """Read and check a configuration, and find the files it names.

    Parameters
    ----------
    path : Path
        The YAML file.
    files_may_be_missing : bool
        For commands that plan or record: names of files that are not there yet stand for none.

    Raises
    ------
    MissingFiles
        Nothing is wrong but that files it names are not there.
    ConfigError
        With one paragraph for every mistake in the file: line, keys, what was found, what was
        expected.
    """
    return config_from(read_source(path), files_may_be_missing=files_may_be_missing)


def parse_config(path: Path, text: str) -> Config:
    """Check ``text`` as if it stood in the file ``path``; errors as :func:`load_config`.

    Raises
    ------
    ConfigError
        With a paragraph for each mistake.
    """
    return config_from(parse_source(path, text))


def config_from(source: YamlSource, *, files_may_be_missing: bool = False) -> Config:
    """The configuration in a file that is read; errors and arguments as :func:`load_config`."""
    context = ValidationContext(
        source.path.parent, _names(source, "rate"), _names(source, "effects"), files_may_be_missing
    )
    config, error = None, None
    try:
        config = Config.model_validate(source.values, context=context)
    except ValidationError as invalid:
        error = invalid
    problems = list(problems_in(source, error, context))
    if config is not None and not files_may_be_missing:
        more = chain(_clip_counts(config), _column_counts(config), contradictions(config))
        problems += [ConfigProblem(path, text) for path, text in more]
    if problems or config is None:
        raise config_error(source, problems)
    config._source = source
    return config


def _names(source: YamlSource, section: str) -> tuple[str, ...]:
    entries = source.values.get(section)
    return tuple(entries) if isinstance(entries, dict) else ()


def _clip_counts(config: Config) -> Iterator[tuple[PathTo, str]]:
    """Runs whose poses and clips cannot be paired."""
    for path, run in config.placed_runs():
        rate = config.rate.get(run.rate)
        clips = len(rate.video) if isinstance(rate, VideoRateSection) else 1
        if run.poses.files and clips not in (1, len(run.poses.files)):
            yield (*path, "rate"), (
                f"'{run.rate}' has {clips} clips for {len(run.poses.files)} poses. Give one clip "
                f"for the whole run, or one per pose in the order of the poses."
            )


def _column_counts(config: Config) -> Iterator[tuple[PathTo, str]]:
    """Lists of column names that cannot be paired with the files of a key."""
    sections: list[tuple[PathTo, LogsSection]] = [
        ((*path, "poses"), run.poses) for path, run in config.placed_runs()]
    if config.installation:
        sections.append((("installation",), config.installation))
    for path, section in sections:
        lists = len(section.columns or ())
        for key, paths in section.files_by_key().items():
            if lists > 1 and paths and len(paths) != lists:
                yield (*path, "columns"), (
                    f"{lists} lists of names for the {count(len(paths), 'file')} of `{key}`. Give "
                    f"one list for all files, or one per file in the same order."
                )
