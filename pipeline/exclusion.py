"""Excluded poses: their names, and the configuration that excludes them."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from calib.poses.imu_log import Triad
from pipeline.config.edit import set_list
from pipeline.config.load import Config, parse_config
from pipeline.config.yaml_syntax import yaml_word
from pipeline.config.yaml_text import YamlSource, parse_source
from pipeline.errors import ConfigError
from pipeline.stages.excluded_poses import PoseName, choose, short_names
from pipeline.stages.poses import Recordings
from pipeline.stages.run import Outcome
from pipeline.text.names import command

NamesBySection = Mapping[int, Sequence[PoseName]]
PlacedPose = tuple[PoseName, int]
"""Name of a pose in ``exclude``, and the number of its section."""


def pose_sections(
    config: Config, recordings: Recordings, triad: Triad
) -> tuple[PlacedPose, ...]:
    """Name and section of every pose of a triad's fit, in its order."""
    places: list[PlacedPose] = []
    for number, section in enumerate(config.runs_of(triad)):
        recording = recordings.of(section)
        labels = [mean.label for mean in recording.means]
        every = [*labels, *(pose.label for pose in recording.excluded)]
        places += [(name, number) for name in shortest_names(every)[: len(labels)]]
    return tuple(places)


def shortest_names(labels: Sequence[str]) -> list[str]:
    """The shortest unambiguous name of each of ``labels``."""
    count = Counter(name for label in labels for name in short_names(label))
    return [next((name for name in short_names(label) if count[name] == 1), label)
            for label in labels]


def exclude_command(config: Path, triad: Triad, labels: Sequence[str], out: Iterable[str]) -> str:
    """The command that excludes the poses ``out`` among ``labels``, which are all of a triad."""
    names = dict(zip(labels, shortest_names(labels), strict=True))
    return command("exclude", config, *(f"{triad}.{names[label]}" for label in out))


def excluding(outcome: Outcome, targets: Sequence[str]) -> Config:
    """The configuration of a run without the poses ``targets``, as in ``gyroscope.pose_07``.

    Raises
    ------
    ConfigError
        A target names no pose of the run, or several.
    """
    config = outcome.config
    for target in targets:
        triad, _, name = target.partition(".")
        result = next((one for one in outcome.triads if one.triad == triad and name), None)
        if result is None:
            expected = " or ".join(f"{one.triad}.NAME" for one in outcome.triads)
            raise ConfigError(f"{target}: names no pose. Write {expected}, as `pipeline diagnose` "
                              f"names them.")
        try:
            place, = choose(result.calibration.fit.poses.label, [name]).excluded
        except ValueError as error:
            out = [pose.label for section in outcome.config.runs_of(result.triad)
                   for pose in outcome.recordings.of(section).excluded]
            if any(name in short_names(label) for label in out):
                raise ConfigError(f"{target}: is excluded already.") from error
            raise ConfigError(f"{target}: {error.args[1]}.") from error
        known, number = pose_sections(outcome.config, outcome.recordings, result.triad)[place]
        source = with_exclusions(config, config.source, result.triad, {number: [known]})
        config = parse_config(source.path, source.text)
    return config


def with_exclusions(
    config: Config, source: YamlSource, triad: Triad, out: NamesBySection,
    back: NamesBySection | None = None,
) -> YamlSource:
    """The text with further poses of a triad's sections excluded, and some taken ``back``.

    Raises
    ------
    ConfigError
        The text is no YAML.
    """
    back = back or {}
    places = [path for path, _ in config.placed_runs() if path[0] == triad]
    for number in sorted({*out, *back}):
        now = (*config.triads[triad].sections[number].exclude, *out.get(number, ()))
        words = [str(name) if isinstance(name, int) else yaml_word(name)
                 for name in now if name not in back.get(number, ())]
        source = parse_source(source.path, set_list(source, places[number], "exclude", words))
    return source
