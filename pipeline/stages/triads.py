"""The two calibration stages: averaged poses to a calibrated, compared and diagnosed triad."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from calib.assess import AssessedTriad, assess, calibrate
from calib.consistency.data_sheet import (
    direction_against_clip,
    gain_off_the_sheet,
    turning_while_still,
)
from calib.diagnosis.unseen import unseen_budget
from calib.effects.catalogue import BASE, find_effect
from calib.effects.effect import Effect
from calib.fit.triad.calibration import TriadCalibration
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
from pipeline.stages.force_check import KNOWN_FORCE, check_force
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


@dataclass(frozen=True, eq=False)
class TriadInput:
    """What a triad is calibrated from.

    ``recorded`` are all its poses and ``poses`` those that the configuration uses; ``defined`` the
    user's effects; ``senses`` as :func:`calib.assess.assess` takes them; ``notes`` what is not
    known of the specific force in its poses.
    """

    section: AccelerometerSection | GyroscopeSection
    recorded: TriadPoses
    poses: PoseSet
    spec: TriadSpec
    defined: Mapping[str, Effect]
    gravity: Gravity | None = None
    senses: Mapping[str, float] | None = None
    notes: tuple[str, ...] = ()

    def refitted(self) -> TriadCalibration:
        """The calibration alone, as :func:`calibrate_accelerometer` and its like make it.

        What contradicts it in the files is not searched for.

        Raises
        ------
        CalibrationError
            As they do.
        """
        model, _, _ = model_on(self.section.model, self.defined, self.poses)
        return calibrate(self.poses, model, self.spec, solver=self.section.solver,
                         loss=self.section.loss, seek_mistakes=False)


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
    return _calibrated(accelerometer_input(config, context, recordings), config)


def accelerometer_input(
    config: Config, context: RunContext, recordings: Recordings
) -> TriadInput:
    """What the accelerometer is calibrated from; the configuration has such a section.

    Raises
    ------
    Undetermined
        Its poses make no set.
    """
    # The configuration's rules refuse an accelerometer without a site and a data sheet.
    assert config.accelerometer is not None
    assert config.site is not None
    assert config.sensor.accelerometer is not None
    gravity = gravity_of(config.site)
    recorded = leaning_poses(config, recordings, gravity)
    return TriadInput(
        config.accelerometer, recorded, recorded.used, triad_spec(config.sensor.accelerometer),
        user_effects(config, "accelerometer", context.allow_python), gravity)


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
    calibration = accelerometer.calibration if accelerometer else None
    from_poses = gyroscope_input(config, context, rates, recordings, calibration)
    result = _calibrated(from_poses, config)
    poses = from_poses.poses
    filmed = [rates[run].plate.direction if run in rates else None for run in poses.run]
    return replace(
        result,
        frame=rotation_between_frames(
            result.calibration.fit, calibration.fit if calibration else None),
        warnings=(*result.warnings, *from_poses.notes, *direction_against_clip(poses, filmed)),
    )


def gyroscope_input(
    config: Config,
    context: RunContext,
    rates: Mapping[str, SettingRate],
    recordings: Recordings,
    accelerometer: TriadCalibration | None,
) -> TriadInput:
    """What the gyroscope is calibrated from; the configuration has such a section.

    Raises
    ------
    Undetermined
        Its poses make no set.
    Contradiction
        The calibrated accelerometer does not read gravity in its poses.
    """
    assert config.gyroscope is not None
    assert config.sensor.gyroscope is not None
    plates = {name: rate.plate for name, rate in rates.items()}
    recorded = gyroscope_poses(config, plates, recordings, accelerometer)
    poses = recorded.used
    force = KNOWN_FORCE
    if accelerometer is not None and config.site is not None:
        force = check_force(poses, accelerometer, gravity_of(config.site).value_m_s2)
    return TriadInput(
        config.gyroscope, recorded, poses, triad_spec(config.sensor.gyroscope),
        user_effects(config, "gyroscope", context.allow_python),
        senses=senses_of(config, recordings) if accelerometer and force.is_known else None,
        notes=force.notes)


def _with_excluded(result: TriadResult, poses: TriadPoses) -> TriadResult:
    """The result with the poses that the configuration excludes, run by run."""
    return replace(result, excluded=predicted_poses(
        result.calibration.fit, [name for name, _ in poses.recorded],
        [(each.means, each.places) for _, each in poses.recorded],
        [each.excluded for _, each in poses.recorded], poses.poses_of))


def _calibrated(triad: TriadInput, config: Config) -> TriadResult:
    poses, section, spec = triad.poses, triad.section, triad.spec
    model, usable, notes = model_on(section.model, triad.defined, poses)
    assessed = assess(poses, model, spec, solver=section.solver, loss=section.loss,
                      candidates=tuple(usable.values()), covariates=config.covariates,
                      senses=triad.senses, part=part_of(config))
    result = TriadResult(
        **vars(assessed),
        unseen=unseen_budget(assessed.calibration, assessed.diagnosis.blind, part_of(config)),
        gravity=triad.gravity,
        warnings=(
            *notes,
            *doubts_of(assessed.calibration),
        ),
    )
    return _with_excluded(result, triad.recorded)


def doubts_of(calibration: TriadCalibration) -> tuple[str, ...]:
    """What is doubtful of a calibration by its own poses and its data sheet."""
    poses = calibration.fit.poses
    return (*poses.notes, *turning_while_still(poses),
            *gain_off_the_sheet(calibration.parameters, calibration.spec, poses.triad))
