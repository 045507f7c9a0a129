"""Results that the poses of a configuration can determine, before and after recording.

The noise is that of the recorded poses, if there are any; else the typical noise of the sensor's
preset; else no sds are stated.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from calib.diagnosis.next_measurement.ideal_poses import (
    PlannedRun,
    expected_widening,
    ideal_poses,
    one_second_sd,
)
from calib.diagnosis.next_measurement.pose_blocks import HEADROOM
from calib.earth import EARTH_RATE_RAD_S, STANDARD_GRAVITY_M_S2, earth_rate_horizontal
from calib.errors import CalibrationError
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.unknown_sd import has_sds, with_estimated_sds
from calib.fit.model import Model
from calib.fit.triad.leaning import with_axes
from calib.planning.prospect import BestPose, Prospect, best_pose, prospect_of
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.conditions import OTHER_TRIAD
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import TRIADS, FloatArray, Triad
from calib.poses.pose_set import PoseSet, pose_set
from calib.poses.reference import FRAME_NAMES, CommonError, PlateRate, room_names, tilt_name
from calib.poses.runs.pose_run import PoseRun
from calib.poses.runs.reference_runs import GRAVITY, RATE_OF, TIME_BASE
from calib.poses.runs.ring import DIRECTION_SD_RAD
from pipeline.config.load import Config
from pipeline.config.sensor import triad_spec
from pipeline.plan.settings import PAUSE_S, PlannedSetting, planned_setting
from pipeline.stages.references import gravity_of, latitude_of
from pipeline.stages.triad_poses import run_in_gravity, run_on_plate
from pipeline.stages.user_effects import user_effects

#: Sd of a mean over one second, SI, correlation included: the median axis of still stretches in
#: public logs of these sensors (33 poses of an MTi, 53 stretches of an MPU-6050; see data/README).
TYPICAL_SD: Mapping[str, Mapping[Triad, float]] = {
    "Xsens MTi": {"accelerometer": 1.2e-3, "gyroscope": 2.5e-4},
    "InvenSense MPU-6050": {"accelerometer": 3.2e-3, "gyroscope": 2.0e-4},
}

NoiseSource = Literal["measured", "typical", "unknown"]


@dataclass(frozen=True, eq=False)
class TriadPlan:
    """The outlook of one triad.

    Parameters
    ----------
    triad : str
    settings : tuple of PlannedSetting
    noise : str
        Where its size comes from: ``measured``, ``typical`` or ``unknown``.
    at_hand, complete : Prospect, str or None
        Judged on the recorded poses, and with the missing ones added: the words of a refusal where
        poses do not determine the model, None where there are none.
    next_pose : BestPose
        The best one beside all that are planned.
    next_planned : BestPose or None
        The missing one that is worth most per minute, beside those recorded; None where none is
        missing.
    saturates : tuple of str
        Warnings of settings at which the converter would saturate.
    not_planned : mapping of str to str
        Effects of the model that the plan leaves out, and why.
    """

    triad: Triad
    settings: tuple[PlannedSetting, ...]
    noise: NoiseSource
    at_hand: Prospect | str | None
    complete: Prospect | str
    next_pose: BestPose
    next_planned: BestPose | None
    saturates: tuple[str, ...]
    not_planned: Mapping[str, str]

    @property
    def recorded(self) -> int:
        """Usable poses on disk."""
        return sum(len(setting.means) for setting in self.settings)


def plan_of(config: Config, allow_python: bool = False) -> Iterator[TriadPlan]:
    """The outlook of accelerometer and gyroscope, user-defined effects included.

    Raises
    ------
    ConfigError, UnreadableInput
        A log, a table of means or a user-defined effect cannot be read.
    UnusableLog
        A table contains a mean that no sensor reads.
    Undetermined
        By the recorded poses: too short, saturated, or moved.
    """
    accelerometer: TriadPlan | None = None
    for triad, section in config.triads.items():
        if triad not in TRIADS:  # it is read in the poses of these two
            continue
        settings = [planned_setting(config, run) for run in section.sections]
        plan = _triad_plan(config, triad, settings, allow_python, accelerometer)
        accelerometer = plan if triad == "accelerometer" else accelerometer
        yield plan


def _triad_plan(
    config: Config, triad: Triad, settings: list[PlannedSetting], allow_python: bool,
    accelerometer: TriadPlan | None,
) -> TriadPlan:
    spec, section = triad_spec(getattr(config.sensor, triad)), config.triads[triad]
    user_defined = user_effects(config, triad, allow_python)
    every = Model.of(section.model, user_defined)
    means = [mean for setting in settings for mean in setting.means]
    logged = set.intersection(*(set(mean.columns) for mean in means)) if means else set()
    logged |= set(OTHER_TRIAD)
    lacks = {effect.name: name for effect in every.effects for name in effect.logged
             if name not in logged}
    model = Model(tuple(effect for effect in every.effects if effect.name not in lacks))
    judged = tuple(effect for effect in user_defined.values() if set(effect.logged) <= logged)
    recorded = [setting.means for setting in settings if setting.means]
    of_logs = [means for means in recorded if not means[0].stated]
    noise: NoiseSource = "unknown"
    noise_sd = np.ones(3) * spec.nominal_scale if math.isfinite(spec.full_scale) else np.ones(3)
    if recorded:
        noise, noise_sd = "measured", one_second_sd(of_logs, triad) if of_logs else noise_sd
    elif config.sensor.name in TYPICAL_SD:
        noise, noise_sd = "typical", np.full(3, TYPICAL_SD[config.sensor.name][triad])
        noise_sd = noise_sd * expected_widening(sum(len(each.missing) for each in settings))
    at_hand: Prospect | str | None = None
    real: Fit | None = None
    if recorded:
        try:
            poses = _with_axes(_recorded_poses(config, triad, settings), accelerometer)
            if not has_sds(poses):
                poses = with_estimated_sds(poses, model)
            at_hand = prospect_of(poses, model, spec, judged, config.covariates)
            real = at_hand.fit
        except CalibrationError as error:
            at_hand = str(error)
    planned = [(run, setting) for setting in settings
               for run in _runs(config, triad, setting, noise_sd, real)]
    runs = [run for run, _ in planned]
    try:
        start = real.equations.start if real is not None else None
        complete: Prospect | str = prospect_of(
            _with_axes(ideal_poses(triad, runs, start), accelerometer), model, spec, judged,
            config.covariates)
    except CalibrationError as error:
        complete = str(error)
    beside_all = best_pose(triad, runs, model)
    assert beside_all is not None  # any direction may be repeated
    at_hand_of_run = [len(setting.means) for _, setting in planned]
    minutes = [(setting.seconds + PAUSE_S) / 60 for _, setting in planned]
    return TriadPlan(triad, tuple(settings), noise, at_hand, complete,
                     beside_all, best_pose(triad, runs, model, at_hand_of_run, minutes),
                     tuple(_saturating(triad, settings, spec)),
                     {effect: f"the column {name} is not in the logs that are there"
                      for effect, name in lacks.items()})


def _with_axes(poses: PoseSet, accelerometer: TriadPlan | None) -> PoseSet:
    """Poses of the gyroscope with the axes from the accelerometer's plan on a leaning plate."""
    outlook = accelerometer and accelerometer.complete
    if poses.ring is None or not isinstance(outlook, Prospect):
        return poses
    ring = outlook.fit.poses.ring
    if ring is None:
        return poses
    sd = poses.ring.force_sd
    known = replace(poses.ring, force_sd=np.where(np.isfinite(sd), sd, np.median(ring.sd[:, 0])))
    return with_axes(replace(poses, ring=known), outlook.fit)


def _runs(
    config: Config, triad: Triad, setting: PlannedSetting, noise_sd: FloatArray, real: Fit | None
) -> Iterator[PlannedRun]:
    """The setting's poses as a plan: recorded ones, in their true directions, and missing ones."""
    recorded = [_recorded_up(triad, setting, real)] if setting.means else []
    up: FloatArray = np.concatenate([*recorded, setting.missing])
    if setting.means and not setting.means[0].stated:
        noise_sd = one_second_sd([setting.means], triad)  # on the plate it may differ
    elif setting.means and real is not None:  # a table states sds of means, or the fit shows them
        noise_sd = np.median(real.poses.sd, axis=0) * math.sqrt(setting.seconds)
    gravity = gravity_of(config.site) if config.site else None
    force = gravity.value_m_s2 if gravity else STANDARD_GRAVITY_M_S2
    latitude = latitude_of(config.site)
    common: tuple[CommonError, ...] = ()
    reference_sd, magnitude = 0.0, setting.rate_rad_s
    cosine, sine = math.cos(setting.tilt_rad), math.sin(setting.tilt_rad)
    if triad == "accelerometer":
        magnitude = force * cosine
        common = (CommonError(GRAVITY, cosine * (gravity.sd_m_s2 if gravity else 0.0)),)
        if sine:
            common += (CommonError(tilt_name(setting.name), -force * sine * DIRECTION_SD_RAD),)
    elif setting.rate_rad_s:
        common = (CommonError(TIME_BASE, setting.relative_sd * setting.rate_rad_s),
                  CommonError(RATE_OF + setting.name, setting.rate_sd_rad_s, of_setting=True))
        if sine:
            along, across = room_names(setting.name)
            horizontal = EARTH_RATE_RAD_S / math.sqrt(2)
            common += (CommonError(along, -sine * horizontal), CommonError(across, 0.0))
    else:
        reference_sd = (
            EARTH_RATE_RAD_S / math.sqrt(3) if latitude is None
            else earth_rate_horizontal(latitude) / math.sqrt(2)
        )
    if setting.attitude_sd_rad is not None:
        common += tuple(CommonError(name, 0.0) for name in FRAME_NAMES)
    if len(up):
        yield PlannedRun(
            setting.name, up, magnitude, setting.rate_rad_s,
            noise_sd / math.sqrt(setting.seconds), reference_sd, common, force,
            (setting.seconds + PAUSE_S) * np.arange(len(up), dtype=float),
            *_course(setting.means, len(up)), tilt_rad=setting.tilt_rad,
            attitude_sd_rad=setting.attitude_sd_rad)


def _course(
    means: tuple[PoseMean, ...], n: int
) -> tuple[FloatArray | None, dict[str, FloatArray]]:
    """Vibration (n, 3) and logged columns of n poses: the recorded ones, then repetitions of them.
    """
    if not means:
        return None, {}
    names = set.intersection(*(set(mean.columns) for mean in means))
    vibration = np.array([mean.accelerometer.scatter for mean in means])
    return np.resize(vibration, (n, 3)), {
        name: np.resize([mean.columns[name] for mean in means], n) for name in names}


def _recorded_up(triad: Triad, setting: PlannedSetting, real: Fit | None) -> FloatArray:
    """Sides (n, 3) that face up in recorded poses, corrected if the poses determine the model."""
    force = np.array([mean.accelerometer.mean for mean in setting.means])
    if triad == "accelerometer" and real is not None:
        force = real.rows.vector
    if not np.isfinite(force).all():
        force = np.array([mean.gyroscope.mean for mean in setting.means])
    return np.asarray(force / np.linalg.norm(force, axis=1, keepdims=True))


def _recorded_poses(config: Config, triad: Triad, settings: list[PlannedSetting]) -> PoseSet:
    """The recorded poses as in the calibration; filmed rates at their nominal value."""
    latitude = latitude_of(config.site)
    runs: list[PoseRun] = []
    for setting in (setting for setting in settings if setting.means):
        if triad == "accelerometer":
            assert config.site is not None
            runs.append(run_in_gravity(setting.name, setting.means, gravity_of(config.site),
                                       setting.attitude_sd_rad))
            continue
        plate = PlateRate(setting.name, np.array([setting.rate_rad_s]),
                          np.array([setting.rate_sd_rad_s]), setting.relative_sd)
        runs.append(run_on_plate(setting.name, setting.means, plate if setting.rate_rad_s else None,
                                 latitude, setting.attitude_sd_rad))
    means = [mean for run in runs for mean in run.means]
    return pose_set(triad, runs, min(mean.time_s for mean in means))


def _saturating(triad: Triad, settings: list[PlannedSetting], spec: TriadSpec) -> Iterator[str]:
    """Settings at which the sensor would saturate."""
    if triad == "accelerometer":
        if spec.full_scale < STANDARD_GRAVITY_M_S2:
            yield (f"gravity exceeds the accelerometer's ±{spec.full_scale:.3g} m/s². Choose a "
                   f"larger range.")
        return
    full = math.degrees(spec.full_scale)
    for setting in settings:
        rate = math.degrees(setting.rate_rad_s)
        if rate >= full:
            yield (f"{setting.name}: the plate turns at {rate:.0f} °/s and the gyroscope reads up "
                   f"to ±{full:.0f} °/s: it saturates. Choose a slower plate or a larger range.")
        elif rate > HEADROOM * full:
            yield (f"{setting.name}: the plate turns at {rate:.0f} °/s, within "
                   f"{100 * (1 - HEADROOM):.0f} % of the gyroscope's ±{full:.0f} °/s: its gain "
                   f"and offset may saturate it.")
