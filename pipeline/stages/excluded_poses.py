"""Poses that the configuration excludes, among those that were recorded.

A pose is excluded as if it had never been recorded: it takes no part in any mean, sd or fit. It is
averaged by itself where it can be, so that the report shows what the fit predicts for it.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from calib.consistency.raw_samples import levels_of_cut
from calib.errors import CalibrationError
from calib.fit.validation.elsewhere import PredictedPose
from calib.poses.averaging.average_pose import average_pose
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.data_sheet import Specs
from calib.poses.imu_log import FloatArray, ImuLog, IntArray, Triad
from pipeline.config.load import Config
from pipeline.config.schema import RunSection
from pipeline.config.yaml_text import PathTo
from pipeline.errors import ConfigError
from pipeline.text.formatting import count
from pipeline.text.names import nearest_name

_PART_OF_FILE = re.compile(r"(?:row \d+|\d+\.\d-\d+\.\d s)$")
"""Endings of the labels of rows of a table and of stops of a long log."""

PoseName = str | int


@dataclass(frozen=True, eq=False)
class Choice:
    """Indices of the used and of the excluded poses, in the recorded order."""

    kept: IntArray
    excluded: IntArray


@dataclass(frozen=True, eq=False)
class ExcludedMean:
    """One excluded pose by itself: its index among the recorded ones, 0 for a stop of a long log.

    ``mean`` is None where it cannot be averaged; ``cut_off`` has, for every triad with an axis that
    is cut off, the levels (3,) of :func:`calib.consistency.raw_samples.levels_of_cut`.
    """

    label: str
    place: int
    mean: PoseMean | None
    cut_off: Mapping[Triad, FloatArray] = field(default_factory=dict)

    @classmethod
    def of(
        cls, label: str, place: int, log: ImuLog | None, others: Sequence[ImuLog], specs: Specs,
        rate_rad_s: float,
    ) -> "ExcludedMean":
        """The pose of ``log`` among the ``others`` of the session; None cannot be read.

        What keeps it from being averaged may be the very reason why it is excluded.
        """
        if log is None:
            return cls(label, place, None)
        levels = {triad: levels_of_cut(log, others, triad) for triad in specs if log.has(triad)}
        cut = {triad: level for triad, level in levels.items() if np.isfinite(level).any()}
        try:
            return cls(label, place, average_pose(log, specs, rate_rad_s), cut)
        except CalibrationError:
            return cls(label, place, None, cut)


@dataclass(frozen=True, eq=False)
class ExcludedPose:
    """Comparison of one excluded pose with the fit.

    ``predicted`` is the prediction of the fit, None where the pose does not belong to its run;
    ``cut_off`` the levels (3,) at which its axes are cut off, None where none is.
    """

    label: str
    run: str
    predicted: PredictedPose | None
    cut_off: FloatArray | None = None


def short_names(label: str) -> tuple[str, ...]:
    """The names by which a pose may be excluded, the shortest first.

    >>> short_names("gyroscope/17rpm/pose_07.csv.gz")
    ('pose_07', 'pose_07.csv.gz', '17rpm/pose_07', 'gyroscope/17rpm/pose_07.csv.gz')
    >>> short_names("evening.csv 138.0-145.2 s")
    ('138.0-145.2 s', 'evening.csv 138.0-145.2 s')
    """
    part = _PART_OF_FILE.search(label)
    if part:
        return part[0], label
    folder, _, base = label.rpartition("/")
    stem = base.partition(".")[0] or base
    return tuple(dict.fromkeys((stem, base, f"{folder.rpartition('/')[2]}/{stem}".lstrip("/"),
                                label)))


def choose(labels: Sequence[str], names: Sequence[PoseName]) -> Choice:
    """Used poses among ``labels`` when those in ``names`` are excluded.

    Parameters
    ----------
    labels : sequence of str
        All recorded poses of the section.
    names : sequence of str or int
        A pose's name as in :func:`short_names`, or its number, the first being 1.

    Raises
    ------
    ValueError
        A name means no pose or several, or no pose remains; with the place in ``names`` first.
    """
    out: set[int] = set()
    for i, name in enumerate(names if labels else ()):  # nothing is recorded yet
        places = _places(labels, name)
        if len(places) == 1 and places[0] not in out:
            out.add(places[0])
            continue
        raise ValueError(i, _problem(labels, name, places))
    kept = np.array([i for i in range(len(labels)) if i not in out], dtype=np.int64)
    if out and not len(kept):
        raise ValueError(0, f"all {count(len(labels), 'pose')} of the section are excluded. Keep "
                            f"those that are to be used, or remove the section")
    return Choice(kept, np.array(sorted(out), dtype=np.int64))


def _places(labels: Sequence[str], name: PoseName) -> list[int]:
    if isinstance(name, int):
        return [name - 1] if name <= len(labels) else []
    return [i for i, label in enumerate(labels) if name in short_names(label)]


def _problem(labels: Sequence[str], name: PoseName, places: Sequence[int]) -> str:
    if len(places) == 1:
        return f"'{name}' is excluded twice. Delete one of the two"
    if places:
        several = ", ".join(labels[i] for i in places)
        return f"'{name}' means several poses: {several}. Write the whole name of one of them"
    if isinstance(name, int):
        return f"there is no pose {name}: the section has {count(len(labels), 'pose')}"
    known = [one for label in labels for one in short_names(label)]
    first, last = (short_names(labels[i])[0] for i in (0, -1))
    return (f"no pose is named '{name}'{nearest_name(name, known)}. The section has "
            f"{count(len(labels), 'pose')}, from '{first}' to '{last}'")


def chosen(
    labels: Sequence[str], section: RunSection, config: Config
) -> Choice:
    """:func:`choose` for a section of a configuration.

    Raises
    ------
    ConfigError
        With the line of the name that is wrong.
    """
    try:
        return choose(labels, section.exclude)
    except ValueError as error:
        item, problem = error.args
        of_section = next(path for path, run in config.placed_runs() if run == section)
        path: PathTo = (*of_section, "exclude")
        where = (*path, item) if (*path, item) in config.source.spans else path
        raise ConfigError(config.source.problem(where, problem)) from error
