"""Checks of ``pipeline check``: all refusals of a run that do not depend on a clip.

The poses are averaged, the models fitted and the mounting measured as in a run, without the
diagnosis and without a user's Python. Where the rate of a run comes from a clip, the gyroscope's
own reading stands in for it: this shows whether its poses can evaluate and determine the model, but
not the effect of a wrong rate.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from calib.consistency.data_sheet import SHEET_TOLERANCE
from calib.fit.least_squares.stack_fits import require_determinable
from calib.fit.triad.calibration import TriadCalibration
from calib.numbers import RPM
from calib.poses.averaging.average_pose import average_pose
from calib.poses.data_sheet import Specs
from calib.poses.imu_log import TRIADS
from calib.poses.reference import PlateRate
from calib.poses.runs.reference_runs import TURNING_RAD_S
from pipeline.config.load import Config
from pipeline.config.schema import KnownRateSection, RunSection
from pipeline.config.sensor import sensor_specs
from pipeline.config.types import STOPPED
from pipeline.stages.mounting import measure_mounting, reading_at_rest
from pipeline.stages.plate_settings import stated_rate
from pipeline.stages.poses import average_recordings
from pipeline.stages.rate import SettingRate
from pipeline.stages.recordings import Recording, Recordings
from pipeline.stages.references import gravity_of
from pipeline.stages.run import check_session
from pipeline.stages.session_logs import SessionLogs
from pipeline.stages.triad_poses import gyroscope_poses, model_on
from pipeline.stages.triads import doubts_of, triad_input
from pipeline.stages.user_effects import user_effects

READ_SD = 0.01  #: relative sd of a rate that the gyroscope reads; it weighs rows, no result has it
UNLIMITED: Mapping[str, float] = {"accelerometer": np.inf, "gyroscope": np.inf}


@dataclass(frozen=True, eq=False)
class Rehearsal:
    """Input that was read, and doubts about it.

    ``poses`` are their numbers by setting; ``warnings`` those of a run, as far as no clip decides
    them.
    """

    poses: Mapping[RunSection, int]
    warnings: tuple[str, ...]


def rehearse(config: Config) -> Rehearsal:
    """Raise the refusals of :func:`pipeline.stages.run.run_stages` that do not depend on a clip.

    Raises
    ------
    PipelineError, CalibrationError
        The first stage that refuses.
    """
    logs = check_session(config)
    stated = {name: stated_rate(name, rate) for name, rate in config.rate.items()
              if isinstance(rate, KnownRateSection)}
    recordings = average_recordings(config, logs, stated)
    config = _without_python(config)
    gravity = gravity_of(config.site) if config.site is not None else None
    accelerometer = _accelerometer(config, recordings)
    gyroscope, notes = _gyroscope(config, logs, stated, recordings, accelerometer)
    if accelerometer is not None:
        measure_mounting(config, accelerometer, gravity, reading_at_rest(config, recordings))
    further = [triad_input(triad, config, {}, recordings).calibrated()
               for triad in config.triads if triad not in TRIADS]
    of_triads = tuple(
        note for one in (accelerometer, gyroscope, *further) if one is not None
        for note in doubts_of(one))
    return Rehearsal({setting: len(recording.means) for setting, recording in
                      recordings.by_setting.items()},
                     (*recordings.warnings, *of_triads, *notes))


def _without_python(config: Config) -> Config:
    """The configuration without effects in Python, and without the triads that need one."""
    effects = {name: effect for name, effect in config.effects.items() if effect.python is None}
    python = config.effects.keys() - effects.keys()
    changes: dict[str, Any] = {
        triad: None for triad in config.triads
        if (section := config.triads.get(triad)) is not None and python & {*section.model}}
    return config.model_copy(update={"effects": effects, **changes})


def _accelerometer(config: Config, recordings: Recordings) -> TriadCalibration | None:
    """The calibration; None where the waves need the rate from the clip."""
    section = config.accelerometer
    if section is None or not all(
            run.recorded in recordings.by_setting for run in section.sections):
        return None
    return triad_input("accelerometer", config, {}, recordings).calibrated()


def _gyroscope(
    config: Config,
    logs: SessionLogs,
    stated: Mapping[str, SettingRate],
    recordings: Recordings,
    accelerometer: TriadCalibration | None,
) -> tuple[TriadCalibration | None, tuple[str, ...]]:
    """The calibration where it needs no clip, and doubts about the readings."""
    section = config.gyroscope
    if section is None:
        return None, ()
    rates = {name: rate.plate for name, rate in stated.items()}
    filmed = [run for run in section.runs if run.rate not in (STOPPED, *stated)]
    if not filmed:
        read_in = triad_input("gyroscope", config, rates, recordings, accelerometer)
        return read_in.calibrated(), read_in.notes
    sensed = _sensed_rates(logs, [run.recorded for run in filmed], sensor_specs(config.sensor))
    if sensed is None:
        return None, ()
    recordings = Recordings({**recordings.by_setting, **sensed[0]})
    rates |= sensed[1]
    poses = gyroscope_poses(config, rates, recordings, accelerometer).used
    model, _, _ = model_on(section.model, user_effects(config, "gyroscope", False), poses)
    if not (config.accelerometer and config.accelerometer.runs):  # whose waves count too
        require_determinable(poses, model)
    return None, tuple(_off_the_nominal(config, rates))


def _off_the_nominal(config: Config, rates: Mapping[str, PlateRate]) -> Iterator[str]:
    """Filmed settings at which the gyroscope's rate differs from the nominal one."""
    for name, rate in config.rate.items():
        nominal = getattr(rate, "nominal_rpm", None)
        if nominal is None or name not in rates or isinstance(rate, KnownRateSection):
            continue
        ratio = float(rates[name].rate_rad_s[0]) / (abs(nominal) * RPM)
        if abs(ratio - 1) > SHEET_TOLERANCE:
            yield (f"run {name}: by its data sheet the gyroscope reads {ratio:.2f} times the "
                   f"nominal {abs(nominal):g} rpm. Either its range is not the stated one, or the "
                   f"plate did not turn at this speed. Check the gyroscope's full scale, and "
                   f"nominal_rpm.")


def _sensed_rates(
    logs: SessionLogs, settings: list[RunSection], specs: Specs
) -> tuple[dict[RunSection, Recording], dict[str, PlateRate]] | None:
    """Averages of whole logs, and the rates of the gyroscope in them by its data sheet.

    None if poses are parts of long logs, which are found by the plate's rate, or are in a table;
    and if the gyroscope shows no rotation, which is reported with the rate.
    """
    recordings, rates = {}, {}
    for setting in settings:
        one, choice = logs[setting].logs, logs[setting].choice
        if choice is None:
            return None
        means = tuple(average_pose(log, specs, 0.0, UNLIMITED) for log in one)
        turning = np.linalg.norm([mean.gyroscope.mean for mean in means], axis=1)
        if not (turning > TURNING_RAD_S).all():
            return None
        rate = float(np.median(turning))
        recordings[setting] = Recording(
            means, tuple(float(log.time_s[0]) for log in one), choice.kept)
        rates[setting.rate] = PlateRate(setting.rate, np.array([rate]), np.array([READ_SD * rate]))
    return recordings, rates
