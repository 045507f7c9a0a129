"""What a triad is calibrated from: its poses, and the model as they can evaluate it."""

from collections.abc import Callable, Mapping, Sequence

from calib.effects.effect import Effect
from calib.effects.needs import unavailable
from calib.effects.user_defined import fault_of_user_effect
from calib.errors import Remedy, Undetermined
from calib.fit.model import Model
from calib.poses.averaging import PoseMean
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseRun, PoseSet, pose_set
from calib.poses.reference import PlateRate
from calib.poses.runs import gravity_run, stopped_run, turning_run
from pipeline.config.load import Config
from pipeline.config.types import STOPPED
from pipeline.stages.excluded_poses import Recorded
from pipeline.stages.poses import Recordings
from pipeline.stages.site import Gravity, latitude_of


def accelerometer_poses(
    means: Sequence[PoseMean], gravity: Gravity, origin_s: float
) -> PoseSet:
    """The poses at rest against gravity; ``origin_s`` is when the session began.

    Raises
    ------
    Undetermined
        The readings are nowhere near gravity, or an axis is stuck.
    """
    run = gravity_run(STOPPED, means, gravity.value_m_s2, gravity.sd_m_s2)
    return pose_set("accelerometer", [run], origin_s)


def gyroscope_poses(
    config: Config,
    rates: Mapping[str, PlateRate],
    recorded: Recorded,
    origin_s: float,
    correct: Callable[[Conditions], FloatArray] | None,
) -> PoseSet:
    """The poses of all runs of the gyroscope.

    Parameters
    ----------
    rates : mapping of str to PlateRate
        The plate's rates by setting.
    recorded : sequence of (means, places)
        The averaged poses of each run, in the order of the runs, and their places among those that
        were recorded.
    origin_s : float
        When the session began.
    correct : callable or None
        Corrects the specific force of the poses, (n, 3).

    Raises
    ------
    Undetermined
        The gyroscope does not turn where the plate does, or turns where it stands.
    """
    assert config.gyroscope is not None
    latitude = latitude_of(config.site)

    def run_of(name: str, means: Sequence[PoseMean], places: IntArray) -> PoseRun:
        if name == STOPPED:
            return stopped_run(name, means, latitude)
        return turning_run(means, rates[name].of_poses(places), latitude)

    runs = [run_of(section.rate, *each)
            for section, each in zip(config.gyroscope.runs, recorded, strict=True)]
    return pose_set("gyroscope", runs, origin_s, correct)


def senses_of(config: Config, recordings: Recordings) -> dict[str, float]:
    """How the plate turns in each run by the accelerometer, see :class:`Recording`."""
    sections = config.gyroscope.runs if config.gyroscope else ()
    return {run.rate: recordings.of(run).sense for run in sections}


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
