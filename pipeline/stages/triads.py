"""The two calibration stages: averaged poses to a calibrated, compared and diagnosed triad."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from calib.assess import AssessedTriad, assess
from calib.consistency.data_sheet import (
    direction_against_clip,
    gain_off_the_sheet,
    turning_while_still,
)
from calib.consistency.force import require_gravity, unknown_force
from calib.diagnosis.unseen import unseen_budget
from calib.effects.catalogue import BASE, find_effect
from calib.effects.effect import Effect
from calib.fit.triad.calibration import TriadCalibration
from calib.fit.triad.evaluable import missing_in, with_typical_columns
from calib.fit.triad.frame_alignment import FrameRotation, rotation_between_frames
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.pose_set import PoseSet
from pipeline.config.load import Config
from pipeline.config.problems import ConfigProblem, config_error
from pipeline.config.schema import AccelerometerSection, GyroscopeSection
from pipeline.config.sensor import triad_spec
from pipeline.stages.context import RunContext
from pipeline.stages.excluded_poses import ExcludedPose, predicted_poses
from pipeline.stages.leaning_poses import leaning_poses
from pipeline.stages.logged_columns import check_covariates
from pipeline.stages.poses import Recordings
from pipeline.stages.rate import SettingRate
from pipeline.stages.site import Gravity, gravity_of
from pipeline.stages.triad_poses import (
    TriadPoses,
    gyroscope_poses,
    model_on,
    senses_of,
)
from pipeline.stages.user_effects import check_user_effects, user_effects


@dataclass(frozen=True, eq=False)
class TriadResult(AssessedTriad):
    """An assessed triad with what else a session knows of it.

    ``unseen`` the sds by what these poses cannot see, if the sensor is typical of its class;
    ``gravity`` is the reference of an accelerometer, None for a gyroscope; ``frame`` its rotation
    against the accelerometer, None for an accelerometer and where the poses do not show it;
    ``warnings`` where two stages contradict each other; ``excluded`` the poses that the
    configuration leaves out.
    """

    unseen: Mapping[str, FloatArray]
    gravity: Gravity | None = None
    frame: FrameRotation | None = None
    warnings: tuple[str, ...] = ()
    excluded: tuple[ExcludedPose, ...] = ()

    @property
    def triad(self) -> Triad:
        """Which one."""
        return self.calibration.triad


def require_fittable(config: Config) -> None:
    """Refuse, before anything slow, a model that its triad or its solver does not have.

    Raises
    ------
    ConfigError
        With the line of every such model.
    """
    problems = []
    sections: tuple[tuple[Triad, AccelerometerSection | GyroscopeSection | None], ...] = (
        ("accelerometer", config.accelerometer), ("gyroscope", config.gyroscope)
    )
    for triad, section in sections:
        if section is None:
            continue
        where = (triad, "model")
        for name in section.model:
            if name in config.effects:
                if config.effects[name].triad not in (None, triad):
                    problems.append(ConfigProblem(where, (
                        f"'{name}' is defined for the {config.effects[name].triad}. Take it out "
                        f"of this model")))
                continue
            if triad not in find_effect(name).triads:
                problems.append(ConfigProblem(where, (
                    f"'{name}' is no effect of the {triad}; `pipeline effects {name}` says what "
                    f"it acts on. Take it out of this model")))
        if section.solver == "paper" and section.loss != "squares":
            problems.append(ConfigProblem((triad, "loss"), (
                "'paper' knows plain least squares only. Use `solver: default` with another loss")))
        if section.solver == "paper" and set(section.model) != set(BASE):
            problems.append(ConfigProblem((triad, "solver"), (
                f"'paper' knows bias, scale and misalignment only, the model is "
                f"[{', '.join(section.model)}]. Use `solver: default` with any other model")))
    if problems:
        raise config_error(config.source, problems)
    check_user_effects(config)
    check_covariates(config)


def part_of(config: Config) -> str:
    """The class of parts that the sensor is taken for, by its name: factory-calibrated or not."""
    return "MTi" if "mti" in config.sensor.name.lower() else "MPU-6050"


def calibrate_accelerometer(
    config: Config, context: RunContext, recordings: Recordings
) -> TriadResult | None:
    """Calibrate the accelerometer against gravity.

    Returns
    -------
    TriadResult or None
        None where the configuration has no such section.

    Raises
    ------
    Undetermined
        The poses do not determine the model.
    """
    if config.accelerometer is None:
        return None
    # The configuration's rules refuse an accelerometer without a site and a data sheet.
    assert config.site is not None
    assert config.sensor.accelerometer is not None
    gravity = gravity_of(config.site)
    poses = leaning_poses(config, recordings, gravity)
    spec = triad_spec(config.sensor.accelerometer)
    defined = user_effects(config, "accelerometer", context.allow_python)
    result = _calibrated(poses.used, config.accelerometer, spec, defined, config, gravity)
    return _with_excluded(result, poses)


def calibrate_gyroscope(
    config: Config,
    context: RunContext,
    rates: Mapping[str, SettingRate],
    recordings: Recordings,
    accelerometer: TriadResult | None,
) -> TriadResult | None:
    """Calibrate the gyroscope against the plate's rates, all runs jointly.

    Parameters
    ----------
    rates : mapping of str to SettingRate
        The plate's rates by setting.
    recordings : Recordings
        The averaged poses.
    accelerometer : TriadResult or None
        Corrects the specific force of the poses, and is the frame that the gyroscope's rotation is
        measured against.

    Returns
    -------
    TriadResult or None
        None where the configuration has no such section.

    Raises
    ------
    Undetermined
        The poses do not determine the model.
    """
    if config.gyroscope is None:
        return None
    assert config.sensor.gyroscope is not None
    plates = {name: rate.plate for name, rate in rates.items()}
    of_runs = gyroscope_poses(config, plates, recordings,
                              accelerometer.calibration if accelerometer else None)
    poses = of_runs.used
    force = KNOWN_FORCE
    if accelerometer is not None and accelerometer.gravity is not None:
        force = check_force(poses, accelerometer.calibration, accelerometer.gravity.value_m_s2)
    defined = user_effects(config, "gyroscope", context.allow_python)
    spec = triad_spec(config.sensor.gyroscope)
    result = _calibrated(poses, config.gyroscope, spec, defined, config,
                         senses=senses_of(config, recordings)
                         if accelerometer and force.is_known else None)
    beside = accelerometer.calibration.fit if accelerometer else None
    filmed = [rates[run].plate.direction if run in rates else None for run in poses.run]
    result = _with_excluded(result, of_runs)
    return replace(
        result,
        frame=rotation_between_frames(result.calibration.fit, beside),
        warnings=(*result.warnings, *force.notes, *direction_against_clip(poses, filmed)),
    )


@dataclass(frozen=True)
class ForceCheck:
    """Whether the calibrated force in the gyroscope's poses is good enough to compare axes by.

    ``notes`` are sentences on what is not known of it.
    """

    is_known: bool
    notes: tuple[str, ...]


KNOWN_FORCE = ForceCheck(True, ())


def check_force(
    poses: PoseSet, accelerometer: TriadCalibration, gravity_m_s2: float
) -> ForceCheck:
    """Check the specific force in the poses of the gyroscope by the calibrated accelerometer.

    Raises
    ------
    Contradiction
        The calibrated accelerometer does not read gravity in them.
    """
    whole = with_typical_columns(accelerometer, poses)
    missing = missing_in(accelerometer, poses)
    if still := missing_in(accelerometer, whole):
        reasons = "; ".join(f"{name}: {reason}" for name, reason in still.items())
        return ForceCheck(False, (
            f"the poses of the gyroscope cannot evaluate all effects of the accelerometer "
            f"({reasons}). The specific force there is corrected without them, and the axes of "
            f"the triads were not compared.",))
    require_gravity(whole, accelerometer, gravity_m_s2)
    notes = unknown_force(whole, accelerometer)
    is_known = not notes
    if missing and np.isfinite(poses.force).all():
        reasons = "; ".join(f"{name}: {reason}" for name, reason in missing.items())
        notes += (f"in the poses of the gyroscope the accelerometer is corrected as in its own "
                  f"poses on average, because they cannot evaluate all of its effects "
                  f"({reasons}).",)
    return ForceCheck(is_known, notes)


def _with_excluded(result: TriadResult, poses: TriadPoses) -> TriadResult:
    """The result with the poses that the configuration excludes, run by run."""
    return replace(result, excluded=predicted_poses(
        result.calibration.fit, [name for name, _ in poses.recorded],
        [(each.means, each.places) for _, each in poses.recorded],
        [each.excluded for _, each in poses.recorded], poses.poses_of))


def _calibrated(
    poses: PoseSet,
    section: AccelerometerSection | GyroscopeSection,
    spec: TriadSpec,
    defined: Mapping[str, Effect],
    config: Config,
    gravity: Gravity | None = None,
    senses: Mapping[str, float] | None = None,
) -> TriadResult:
    model, usable, notes = model_on(section.model, defined, poses)
    assessed = assess(poses, model, spec, solver=section.solver, loss=section.loss,
                      candidates=tuple(usable.values()), covariates=config.covariates,
                      senses=senses, part=part_of(config))
    return TriadResult(
        **vars(assessed),
        unseen=unseen_budget(assessed.calibration, assessed.diagnosis.blind, part_of(config)),
        gravity=gravity,
        warnings=(
            *notes,
            *doubts_of(assessed.calibration),
        ),
    )


def doubts_of(calibration: TriadCalibration) -> tuple[str, ...]:
    """What is doubtful of a calibration by its own poses and its data sheet."""
    poses = calibration.fit.poses
    return (*poses.notes, *turning_while_still(poses),
            *gain_off_the_sheet(calibration.parameters, calibration.spec, poses.triad))
