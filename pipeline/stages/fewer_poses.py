"""Recordings without some of their poses; no log is read again."""

from collections.abc import Set
from dataclasses import replace

import numpy as np

from pipeline.config.load import Config
from pipeline.errors import ConfigError
from pipeline.stages.excluded_poses import ExcludedMean, PoseName, short_names
from pipeline.stages.poses import Recording, Recordings
from pipeline.stages.session_logs import Setting


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
            by_setting[Setting.of(then)] = _without(
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
