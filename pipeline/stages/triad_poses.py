"""What a triad is calibrated from: its poses, and the model as they can evaluate it."""

from collections.abc import Mapping, Sequence

from calib.effects.effect import Effect
from calib.effects.needs import unavailable
from calib.effects.user_defined import fault_of_user_effect
from calib.errors import Remedy, Undetermined
from calib.fit.calibration import TriadCalibration
from calib.fit.model import Model
from calib.poses.pose_set import PoseSet, pose_set
from calib.poses.runs import PlateRate, gravity_run, stopped_run, turning_run
from pipeline.config.load import Config
from pipeline.config.types import STOPPED
from pipeline.stages.poses import Recordings
from pipeline.stages.site import Gravity, gravity_of, latitude_of


def accelerometer_poses(config: Config, recordings: Recordings) -> tuple[PoseSet, Gravity]:
    """The poses at rest, and the gravity that they are measured against.

    Raises
    ------
    Undetermined
        The readings are nowhere near gravity, or an axis is stuck.
    """
    # The configuration's rules refuse an accelerometer without a site.
    assert config.accelerometer is not None
    assert config.site is not None
    gravity = gravity_of(config.site)
    means = recordings.of(config.accelerometer.poses).means
    run = gravity_run(STOPPED, means, gravity.value_m_s2, gravity.sd_m_s2)
    return pose_set("accelerometer", [run], recordings.origin_s), gravity


def gyroscope_poses(
    config: Config,
    rates: Mapping[str, PlateRate],
    recordings: Recordings,
    accelerometer: TriadCalibration | None,
) -> PoseSet:
    """The poses of all runs of the gyroscope.

    Parameters
    ----------
    rates : mapping of str to PlateRate
        The plate's rates by setting.
    recordings : Recordings
        The averaged poses.
    accelerometer : TriadCalibration or None
        Corrects the specific force of the poses.

    Raises
    ------
    Undetermined
        The gyroscope does not turn where the plate does, or turns where it stands.
    """
    assert config.gyroscope is not None
    latitude = latitude_of(config.site)
    runs = []
    for section in config.gyroscope.runs:
        means = recordings.of(section.poses, section.rate).means
        runs.append(
            stopped_run(section.rate, means, latitude)
            if section.rate == STOPPED
            else turning_run(means, rates[section.rate], latitude)
        )
    return pose_set("gyroscope", runs, recordings.origin_s,
                    accelerometer.correct if accelerometer else None)


def senses_of(config: Config, recordings: Recordings) -> dict[str, float]:
    """How the plate turns in each run by the accelerometer, see :class:`Recording`."""
    sections = config.gyroscope.runs if config.gyroscope else ()
    return {run.rate: recordings.of(run.poses, run.rate).sense for run in sections}


def model_on(
    names: Sequence[str], defined: Mapping[str, Effect], poses: PoseSet
) -> tuple[Model, dict[str, Effect], list[str]]:
    """The model of a section as these poses can evaluate it.

    Parameters
    ----------
    names : sequence of str
        Its effects.
    defined : mapping of str to Effect
        The user's effects for this triad.
    poses : PoseSet

    Returns
    -------
    model : Model
    usable : dict of str to Effect
        The user's effects that can be evaluated.
    notes : list of str
        On those that cannot, and that the model does not have.

    Raises
    ------
    Undetermined
        An effect of the model cannot be evaluated.
    """
    usable: dict[str, Effect] = {}
    notes = []
    for name, effect in defined.items():
        try:
            fault = fault_of_user_effect(effect, poses.conditions(poses.reading))
            problem = None if fault is None else f"effects.{name}: the effect {fault}."
        except Undetermined as error:  # its Python function raised
            problem = str(error)
        if problem is None:
            usable[name] = effect
        elif name in names:
            raise Undetermined(problem)
        else:
            notes.append(f"{problem} No model has it; the diagnosis of the {poses.triad} leaves "
                         f"it out.")
    model = Model.of(names, usable)
    for effect in model.effects:
        reason = unavailable(effect, poses)
        if reason is not None:
            raise Undetermined(
                f"{poses.triad}: '{effect.name}' cannot be evaluated in these poses: {reason}.",
                Remedy("remove_effect", poses.triad),
            )
    return model, usable, notes
