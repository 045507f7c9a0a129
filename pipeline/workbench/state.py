"""State of a screen beyond the files: ticked effects, left-out poses; and its configuration.

The state becomes a configuration text, and everything is computed from that text:
``Write to config`` writes exactly what is shown.
"""

import difflib
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from calib.effects.catalogue import BASE
from calib.poses.imu_log import Triad
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.config.edit import add_item, remove_item
from pipeline.config.load import Config
from pipeline.config.schema import TriadFitSection
from pipeline.config.yaml_text import PathTo, YamlSource
from pipeline.errors import ConfigError
from pipeline.exclusion import PlacedPose, with_exclusions
from pipeline.model_change import CONSTANT_RATE
from pipeline.stages.excluded_poses import ExcludedMean, PoseName, short_names
from pipeline.stages.recordings import Recording, Recordings

PosesByLabel = Mapping[str, PlacedPose]


@dataclass(frozen=True)
class TriadScreen:
    """One triad on the screen: added effects in their order; labels of left-out poses, and of
    readmitted ones that the configuration excludes.
    """

    ticked: tuple[str, ...]
    out: tuple[str, ...] = ()
    back: tuple[str, ...] = ()


@dataclass(frozen=True)
class Screen:
    """The whole screen: the triads, and the terms of the plate settings that were changed."""

    triads: Mapping[Triad, TriadScreen]
    terms: Mapping[str, tuple[str, ...]]


def read_state(value: Any) -> Screen:
    """The state in a request of the page.

    Raises
    ------
    ConfigError
        It is none.
    """
    try:
        triads: dict[Triad, TriadScreen] = {
            triad: TriadScreen(*(_texts(value["triads"][triad].get(key, ()))
                                 for key in ("ticked", "out", "back")))
            for triad in TRIAD_KINDS if triad in value["triads"]}
        terms = {str(name): _texts(each) for name, each in value.get("terms", {}).items()}
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise ConfigError(f"the page asked for no state of this session ({error}).") from error
    return Screen(triads, terms)


def _texts(value: Sequence[Any]) -> tuple[str, ...]:
    if isinstance(value, str) or not all(isinstance(name, str) for name in value):
        raise ValueError("effects and poses are named by texts")
    return tuple(dict.fromkeys(value))


def source_of(
    config: Config, state: Screen, poses: Mapping[Triad, PosesByLabel],
    excluded: Mapping[Triad, PosesByLabel],
) -> YamlSource:
    """The file of the configuration with what the screen shows; comments and order are kept.

    Parameters
    ----------
    config : Config
        As it stands in the file.
    state : Screen
    poses, excluded : mapping of triad to mapping of label to PlacedPose
        Name and section of every pose that the file's configuration uses, and excludes.

    Raises
    ------
    ConfigError
        The state names a pose or a section that is not there.
    """
    source = config.source
    for triad, of_triad in state.triads.items():
        section = _section(config, triad)
        model = model_of(section.model, of_triad.ticked)
        source = _with_model(source, (triad,), section.model, model, BASE)
        out = _by_section(triad, of_triad.out, poses[triad])
        back = _by_section(triad, of_triad.back, excluded[triad])
        source = with_exclusions(config, source, triad, out, back)
    for setting, terms in state.terms.items():
        now = getattr(config.rate.get(setting), "model", None)
        if now is None:
            raise ConfigError(f"{source.path} has no clip of '{setting}'.")
        model = model_of(now, terms, CONSTANT_RATE)
        source = _with_model(source, ("rate", setting), now, model, CONSTANT_RATE)
    return source


def model_of(
    now: Sequence[str], ticked: Sequence[str], base: Sequence[str] = BASE
) -> tuple[str, ...]:
    """The model ``now`` with the ticked effects beyond ``base``, in the order of the file.

    >>> model_of(("bias", "cubic", "scale"), ("quadratic", "cubic"))
    ('bias', 'cubic', 'scale', 'quadratic')
    """
    keep = [name for name in now if name in base or name in ticked]
    return (*keep, *(name for name in ticked if name not in now))


def _with_model(
    source: YamlSource, section: PathTo, now: Sequence[str], then: Sequence[str],
    default: Sequence[str],
) -> YamlSource:
    for name in now:
        if name not in then:
            source = remove_item(source, section, name)
    for name in then:
        if name not in now:
            source = add_item(source, section, name, default)
    return source


def _section(config: Config, triad: Triad) -> TriadFitSection:
    if triad not in config.triads:
        raise ConfigError(f"{config.source.path} has no section '{triad}'.")
    return config.triads[triad]


def _by_section(
    triad: Triad, labels: Sequence[str], poses: PosesByLabel
) -> dict[int, list[PoseName]]:
    """The names of poses, by the number of their section."""
    names: dict[int, list[PoseName]] = {}
    for label in labels:
        if label not in poses:
            raise ConfigError(f"the {triad} has no pose '{label}'; load the page again.")
        name, number = poses[label]
        names.setdefault(number, []).append(name)
    return names


def config_of(
    config: Config, state: Screen, poses: Mapping[Triad, PosesByLabel]
) -> Config:
    """The configuration of :func:`source_of`, computed without its text and the plate's terms.

    Raises
    ------
    ConfigError
        As :func:`source_of`; and effects that no triad has.
    """
    changed: dict[str, Any] = {}
    for triad, of_triad in state.triads.items():
        section = _section(config, triad)
        names = _by_section(triad, of_triad.out, poses[triad])
        then = [each.model_copy(update={"exclude": (*each.exclude, *names.get(i, ()))})
                for i, each in enumerate(section.sections)]
        at_rest = len(section.at_rest)
        update = {"model": model_of(section.model, of_triad.ticked),
                  "runs": tuple(then[at_rest:])}
        if at_rest:
            update["exclude"] = then[0].exclude
        changed[triad] = section.model_copy(update=update)
    return config.model_copy(update=changed)


def changed_lines(before: str, after: str) -> list[dict[str, Any]]:
    """The lines that differ: number from 1 in ``after``, and the line before and after."""
    old, new = before.splitlines(), after.splitlines()
    return [
        {"line": j1 + 1, "before": "\n".join(old[i1:i2]), "after": "\n".join(new[j1:j2])}
        for tag, i1, i2, j1, j2 in difflib.SequenceMatcher(None, old, new, False).get_opcodes()
        if tag != "equal"]


def recordings_without(
    recordings: Recordings, config: Config, more: Config
) -> Recordings:
    """The recordings of ``config`` without the poses that ``more`` excludes in addition to its own.

    No log is read again: a mean depends on its own samples alone. ``more`` names every pose by an
    unambiguous text.

    Raises
    ------
    ConfigError
        No pose of a section remains.
    """
    by_setting = {}
    for triad in config.triads:
        for section, then in zip(config.runs_of(triad), more.runs_of(triad),
                                 strict=True):
            of_section = recordings.of(section)
            names = {name for name in then.exclude if name not in section.exclude}
            by_setting[then.recorded] = _without(
                of_section, names, bool(section.poses.log)) if names else of_section
    return Recordings(by_setting)


def _without(recording: Recording, names: Set[PoseName], from_log: bool) -> Recording:
    """A recording without the poses of these names."""
    out = [not names.isdisjoint(short_names(mean.label)) for mean in recording.means]
    kept = [i for i, is_out in enumerate(out) if not is_out]
    if not kept:
        raise ConfigError("all poses of a section are left out. Take one back.")
    starts = recording.starts_s
    excluded = tuple(ExcludedMean(mean.label, int(place), mean) for mean, place, is_out in
                     zip(recording.means, recording.places, out, strict=True) if is_out)
    return replace(
        recording,
        means=tuple(recording.means[i] for i in kept),
        starts_s=tuple(starts[i] for i in kept) if len(starts) == len(out) else starts,
        places=np.arange(len(kept)) if from_log else recording.places[kept],
        excluded=(*recording.excluded, *excluded))
