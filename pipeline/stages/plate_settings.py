"""The vision stage: every entry under ``rate:`` becomes the rate of one plate setting."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np

from calib.poses.reference import PlateRate
from pipeline.cameras import known_cameras
from pipeline.config.load import Config
from pipeline.config.schema import KnownRateSection, PlateSection, TimebaseSection, VideoRateSection
from pipeline.stages.context import RunContext
from pipeline.stages.rate import (
    ClipToFollow,
    SettingRate,
    camera_timebase,
    follow_clips,
    measure_setting,
)
from vision.geometry import PlateOverride
from vision.rate.steady_part import ClipPart
from vision.rate.timebase import Timebase
from vision.rate.together import judge_together


def measure_rates(config: Config, context: RunContext) -> Mapping[str, SettingRate]:
    """Measure the rates of all plate settings.

    Returns
    -------
    mapping of str to SettingRate
        By the setting's name, in the order of the file.

    Raises
    ------
    UnreadableVideo, RateRefused
        From :mod:`vision`: a clip cannot be read, or its rate cannot be determined.
    UnreadableInput
        A clip is none, or a camera's measured clock cannot be read.
    """
    filmed = {
        name: rate for name, rate in config.rate.items() if isinstance(rate, VideoRateSection)
    }
    clips_of = {name: clips_to_follow(rate) for name, rate in filmed.items()}
    clips = list(dict.fromkeys(chain.from_iterable(clips_of.values())))
    tracks = dict(zip(clips, follow_clips(clips, context), strict=True))
    return _judged_together({
        name: stated_rate(name, rate)
        if isinstance(rate, KnownRateSection)
        else measure_setting(
            name,
            [tracks[clip] for clip in clips_of[name]],
            clock(rate.timebase, rate.video),
            rate.nominal_rpm,
            rate.model,
            ClipPart(rate.from_s, rate.to_s),
        )
        for name, rate in config.rate.items()
    })


def clips_to_follow(rate: VideoRateSection) -> list[ClipToFollow]:
    """The clips of a setting, each with the plate data that the configuration states."""
    plate = None if rate.plate is None else rim(rate.plate)
    return [ClipToFollow(clip, plate, rate.from_s or 0.0) for clip in rate.video]


def _judged_together(rates: Mapping[str, SettingRate]) -> Mapping[str, SettingRate]:
    """The rates with those verdicts on their clips that need all clips of the session."""
    names = {id(clip): f"{name}[{i}]" if len(rate.clips) > 1 else name
             for name, rate in rates.items() for i, clip in enumerate(rate.clips)}
    decided = judge_together([
        (names[id(clip)], clip.diagnosis,
         -clip.rate_rad_s if clip.direction == "cw" else clip.rate_rad_s)
        for rate in rates.values() for clip in rate.clips])
    return {
        name: replace(rate, clips=tuple(
            replace(clip, diagnosis=decided.get(names[id(clip)], clip.diagnosis))
            for clip in rate.clips))
        for name, rate in rates.items()
    }


def stated_rate(name: str, rate: KnownRateSection) -> SettingRate:
    """The rate of a setting that was measured elsewhere."""
    way = "cw" if rate.rate_rad_s < 0 else None
    plate = PlateRate(name, np.array([abs(rate.rate_rad_s)]), np.array([rate.sd_rad_s]),
                      direction=way)
    return SettingRate(name, plate, (), ())


def clock(stated: TimebaseSection, clips: Sequence[Path] = ()) -> Timebase:
    """The time base of ``clips`` as :mod:`vision` expects it."""
    if stated.camera is not None:
        return camera_timebase(known_cameras()[stated.camera], clips)
    return Timebase(source=stated.source, fps=stated.fps, ppm=stated.relative_sd * 1e6)


def rim(stated: PlateSection) -> PlateOverride:
    """The ellipse as :mod:`vision` expects it: the longer radius first, angle in degrees."""
    first, second = stated.radii_px
    longer_first = first >= second
    return PlateOverride(
        centre_px=stated.centre_px,
        radius_px=max(first, second),
        minor_px=min(first, second),
        angle_deg=stated.angle_deg if longer_first else stated.angle_deg + 90.0,
    )
