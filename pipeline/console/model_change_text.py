"""What a change of the model did, and poses that could be left out, on the terminal."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from calib.poses.imu_log import Triad
from pipeline.config.load import Config
from pipeline.config.yaml_syntax import yaml_word
from pipeline.console.parameter_text import effect_rows, shown_effects
from pipeline.console.run_text import verdict_line
from pipeline.model_change import ModelChange, result_of
from pipeline.stages.excluded_poses import PoseName, short_names
from pipeline.stages.poses import Recordings
from pipeline.stages.rate import SettingRate
from pipeline.stages.run import Outcome
from pipeline.stages.triads import TriadResult
from pipeline.text.formatting import DISPLAY
from pipeline.text.tables import table_lines


def change_lines(change: ModelChange) -> Iterator[str]:
    """The table before → after, the new effect's size ± sd, and the new verdict."""
    before, after = (result_of(outcome, change.target) for outcome in (change.before, change.after))
    if before is not None and after is not None:
        yield from _triad_lines(change, before, after)
        return
    setting = str(change.target.section[1])
    yield from _rate_lines(setting, change.before, change.after)


def _triad_lines(change: ModelChange, before: TriadResult, after: TriadResult) -> Iterator[str]:
    unit, factor = DISPLAY[before.triad]
    rows = [[str(change.target), "before", "after"]]
    rows.append([f"RMS [{unit}]", *(f"{r.comparison.residual_rms * factor:.4g}"
                                    for r in (before, after))])
    rows.append([f"leave-one-out [{unit}]", *(f"{r.comparison.loo_rms * factor:.4g}"
                                              for r in (before, after))])
    rows.append(["chi²/dof", *(f"{r.calibration.fit.chi2 / r.calibration.fit.dof:.3g}"
                               for r in (before, after))])
    rows.append(["verdict", *(r.diagnosis.verdict for r in (before, after))])
    yield from table_lines(rows, indent="")
    for shown in shown_effects(after.calibration):
        if shown.effect.name == change.target.name:
            yield from table_lines(effect_rows(shown), indent="")
    yield verdict_line(after)


def _rate_lines(setting: str, before: Outcome, after: Outcome) -> Iterator[str]:
    rates: list[SettingRate] = [outcome.rates[setting] for outcome in (before, after)]
    rows = [[f"rate.{setting}", "before", "after"]]
    rows.append(["phase residual [°]", *(f"{math.degrees(_phase_rms(r)):.4g}" for r in rates)])
    rows.append(["verdict", *(r.clips[0].diagnosis.verdict for r in rates)])
    yield from table_lines(rows, indent="")
    for clip in rates[1].clips[:1]:
        for term in clip.fit.terms:
            values = ", ".join(f"{v:.3g} ± {s:.2g}" for v, s in zip(term.value, term.sd,
                                                                    strict=True))
            yield f"  {term.name}: {values} {term.unit}"
        yield clip.diagnosis.explanation


def _phase_rms(rate: SettingRate) -> float:
    return max(clip.fit.rms_rad for clip in rate.clips)


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
