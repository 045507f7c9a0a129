"""The lines of a configuration that exclude poses of a triad, for terminal and report."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from calib.poses.imu_log import Triad
from pipeline.config.load import Config
from pipeline.config.yaml_words import yaml_word
from pipeline.stages.excluded_poses import PoseName, short_names
from pipeline.stages.poses import Recordings
from pipeline.stages.run import Outcome
from pipeline.stages.triads import TriadResult


@dataclass(frozen=True)
class ExcludeLines:
    """The lines that exclude poses: ``head``, then of every section that excludes some ``before``
    and a list of the names in ``known``, which it excludes already, and of further ones.
    """

    head: str
    before: tuple[str, ...]
    known: tuple[tuple[str, ...], ...]

    def text(self, names: Mapping[int, Sequence[str]]) -> str:
        """The lines with these further names by the number of their section."""
        return "\n".join([self.head, *(
            f"{self.before[k]}[{', '.join([*self.known[k], *names[k]])}]" for k in sorted(names))])


def exclude_lines(config: Config, triad: Triad) -> ExcludeLines:
    """What to write where, of one triad."""
    section = config.triads[triad]
    first = "  runs:\n" if section.at_rest else ""  # below the poses at rest, if any
    before = ["  exclude: "] * len(section.at_rest)
    before += [f"{'' if k else first}  - rate: {yaml_word(run.rate)}\n    exclude: "
               for k, run in enumerate(section.turning)]
    head = f"{triad}:" if section.at_rest else f"{triad}:\n  runs:"
    return ExcludeLines(head, tuple(before), tuple(
        tuple(map(yaml_name, run.exclude)) for run in section.sections))


@dataclass(frozen=True)
class PoseSection:
    """What a pose is called in ``exclude``, and the number of the section that it belongs to."""

    name: PoseName
    number: int

    @property
    def word(self) -> str:
        """Its name as it stands in a YAML list."""
        return yaml_name(self.name)


def pose_sections(
    config: Config, recordings: Recordings, triad: Triad
) -> tuple[PoseSection, ...]:
    """Name and section of every pose of a triad's fit, in its order."""
    places = []
    for number, section in enumerate(config.runs_of(triad)):
        recording = recordings.of(section)
        labels = [mean.label for mean in recording.means]
        every = [*labels, *(pose.label for pose in recording.excluded)]
        names = shortest_names(every)[: len(labels)]
        places += [PoseSection(name, number) for name in names]
    return tuple(places)


def lines_to_exclude(outcome: Outcome, result: TriadResult, labels: Sequence[str]) -> str:
    """The lines that exclude the poses ``labels`` of a fit."""
    names: dict[int, list[str]] = {}
    places = pose_sections(outcome.config, outcome.recordings, result.triad)
    every = zip(result.calibration.fit.poses.label, places, strict=True)
    for label, place in every:
        if label in labels:
            names.setdefault(place.number, []).append(place.word)
    return exclude_lines(outcome.config, result.triad).text(names)


def shortest_names(labels: Sequence[str]) -> list[str]:
    """The shortest name of each of ``labels`` that means it alone."""
    count = Counter(name for label in labels for name in short_names(label))
    return [next((name for name in short_names(label) if count[name] == 1), label)
            for label in labels]


def yaml_name(name: PoseName) -> str:
    """A name or a number as it stands in a YAML list.

    >>> yaml_name("pose_07"), yaml_name("138.0-145.2 s"), yaml_name(7)
    ('pose_07', '"138.0-145.2 s"', '7')
    """
    return str(name) if isinstance(name, int) else yaml_word(name)
