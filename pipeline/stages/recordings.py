"""The averaged poses of each setting of the plate, and what the logs say beside them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from calib.consistency.clock_ratio import ClockRatio
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.imu_log import IntArray
from pipeline.config.schema import RunSection
from pipeline.stages.excluded_poses import ExcludedMean


@dataclass(frozen=True, eq=False)
class Recording:
    """The averaged poses of one setting.

    ``starts_s`` are the start times of the log of each mean, or one value common to all;
    ``warnings`` list the found poses that were left out; ``sense`` is the direction of the plate by
    the accelerometer alone, +1 ccw, -1 cw, 0 unknown. ``places`` (n,) are the indices of ``means``
    among all recorded poses, some of which the configuration excludes. ``clock`` compares the rate
    in turning poses with that of their run.
    """

    means: tuple[PoseMean, ...]
    starts_s: tuple[float, ...]
    places: IntArray
    warnings: tuple[str, ...] = ()
    sense: float = 0.0
    excluded: tuple[ExcludedMean, ...] = ()
    clock: ClockRatio | None = None

    def beside(self, name: str, ratio: ClockRatio | None) -> "Recording":
        """The same with the ``ratio`` to rate ``name``, and a note where they contradict it."""
        told = (ratio.warning(f"rate.{name}"),) if ratio and ratio.contradicts else ()
        return replace(self, clock=ratio, warnings=(*self.warnings, *told))


@dataclass(frozen=True, eq=False)
class Recordings:
    """All poses of a session, averaged."""

    by_setting: Mapping[RunSection, Recording]

    def of(self, section: RunSection) -> Recording:
        """The recording of a section."""
        return self.by_setting[section.recorded]

    @property
    def origin_s(self) -> float:
        """Start of the session: the earliest sample of all logs; 0 where no time is known."""
        start_s = min(min(recording.starts_s) for recording in self.by_setting.values())
        return start_s if math.isfinite(start_s) else 0.0

    @property
    def clocks(self) -> Mapping[str, ClockRatio]:
        """Rate in the logs over that of the run, by the rate's name, where known."""
        return {setting.rate: recording.clock for setting, recording in self.by_setting.items()
                if recording.clock is not None}

    @property
    def warnings(self) -> tuple[str, ...]:
        """The warnings of all recordings, each once: two settings may use the same log."""
        return tuple(dict.fromkeys(
            w for recording in self.by_setting.values() for w in recording.warnings))
