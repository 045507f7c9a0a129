"""Excluded poses: their names, and the configuration that excludes them."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from calib.poses.imu_log import Triad
from pipeline.config.edit import set_excluded
from pipeline.config.load import Config, config_from
from pipeline.config.schema import RunSection
from pipeline.config.yaml_syntax import yaml_word
from pipeline.config.yaml_text import YamlSource
from pipeline.errors import ConfigError
from pipeline.stages.excluded_poses import PoseName, choose, chosen, short_names
from pipeline.stages.recordings import Recordings
from pipeline.stages.session_logs import pose_labels
from pipeline.text.names import command

NamesBySection = Mapping[int, Sequence[PoseName]]
PlacedPose = tuple[PoseName, int]
"""Name of a pose in ``exclude``, and the number of its section."""


def labels_in(
    config: Config, section: RunSection, recordings: Recordings | None
) -> tuple[list[str], list[str]]:
    """Labels of the poses of a section that are used, and of those that it excludes.

    ``recordings`` is None where every pose of the configuration is a file, which need not be read.
    """
    if recordings is not None:
        recording = recordings.of(section)
        return ([mean.label for mean in recording.means],
                [pose.label for pose in recording.excluded])
    labels = pose_labels(section.poses, config)
    choice = chosen(labels, section, config)
    return [labels[i] for i in choice.kept], [labels[i] for i in choice.excluded]


def placed_poses(
    config: Config, recordings: Recordings, triad: Triad
) -> tuple[dict[str, PlacedPose], dict[str, PlacedPose]]:
    """Every pose of a triad's fit by its label, in the fit's order; and every excluded one, under
    its name in the configuration.
    """
    used: dict[str, PlacedPose] = {}
    out: dict[str, PlacedPose] = {}
    for number, section in enumerate(config.runs_of(triad)):
        recording = recordings.of(section)
        labels = [mean.label for mean in recording.means]
        excluded = [pose.label for pose in recording.excluded]
        names = shortest_names([*labels, *excluded])[: len(labels)]
        used |= {label: (name, number) for label, name in zip(labels, names, strict=True)}
        out |= {pose.label: (name, number) for pose in recording.excluded
                for name in section.exclude if name in (pose.place + 1, *short_names(pose.label))}
    return used, out


def shortest_names(labels: Sequence[str]) -> list[str]:
    """The shortest unambiguous name of each of ``labels``."""
    count = Counter(name for label in labels for name in short_names(label))
    return [next((name for name in short_names(label) if count[name] == 1), label)
            for label in labels]


def exclude_command(config: Path, triad: Triad, labels: Sequence[str], out: Iterable[str]) -> str:
    """The command that excludes the poses ``out`` among ``labels``, which are all of a triad."""
    names = dict(zip(labels, shortest_names(labels), strict=True))
    return command("exclude", config, *(f"{triad}.{names[label]}" for label in out))


def excluding(
    config: Config, recordings: Recordings | None, targets: Sequence[str]
) -> tuple[Config, list[str]]:
    """The configuration without the poses ``targets``, as in ``gyroscope.pose_07``.

    A pose that serves several runs or triads is left out of all of them.

    Parameters
    ----------
    config : Config
    recordings : Recordings or None
        Its poses; None as in :func:`labels_in`.
    targets : sequence of str

    Returns
    -------
    config : Config
    notes : list of str
        What was excluded that no target names.

    Raises
    ------
    ConfigError
        A target names no pose, or several.
    """
    poses = {triad: [labels_in(config, section, recordings) for section in config.runs_of(triad)]
             for triad in config.triads}
    named = dict.fromkeys(_label_of(target, poses) for target in targets)
    source, notes = config.source, []
    for triad, sections in poses.items():
        names: dict[int, list[PoseName]] = {}
        for number, (used, out) in enumerate(sections):
            short = dict(zip([*used, *out], shortest_names([*used, *out]), strict=True))
            names[number] = [short[label] for _, label in named if label in used]
            notes += [f"{label} is a pose of the {triad} too (rate: "
                      f"{config.runs_of(triad)[number].rate}), and is excluded there as well."
                      for _, label in named if label in used and (triad, label) not in named]
        source = with_exclusions(config, source, triad, {i: out for i, out in names.items() if out})
    return config_from(source), notes


def _label_of(
    target: str, poses: Mapping[Triad, Sequence[tuple[Sequence[str], Sequence[str]]]]
) -> tuple[str, str]:
    """Triad and label of the one pose that ``target`` names, among those used and excluded."""
    triad, _, name = target.partition(".")
    if triad not in poses or not name:
        expected = " or ".join(f"{one}.NAME" for one in poses)
        raise ConfigError(f"{target}: names no pose. Write {expected}, as `pipeline diagnose` "
                          f"names them.")
    every = [*dict.fromkeys(label for used, _ in poses[triad] for label in used)]
    try:
        place, = choose(every, [name]).excluded
    except ValueError as error:
        if any(name in short_names(label) for _, out in poses[triad] for label in out):
            raise ConfigError(f"{target}: is excluded already.") from error
        raise ConfigError(f"{target}: {error.args[1]}.") from error
    return triad, every[place]


def with_exclusions(
    config: Config, source: YamlSource, triad: Triad, out: NamesBySection,
    back: NamesBySection | None = None,
) -> YamlSource:
    """The file with further poses of a triad's sections excluded, and some taken ``back``.

    A ConfigError says where that would be no YAML.
    """
    back = back or {}
    places = [path for path, _ in config.placed_runs() if path[0] == triad]
    for number in sorted({*out, *back}):
        now = (*config.triads[triad].sections[number].exclude, *out.get(number, ()))
        words = [str(name) if isinstance(name, int) else yaml_word(name)
                 for name in now if name not in back.get(number, ())]
        source = set_excluded(source, places[number], words)
    return source
