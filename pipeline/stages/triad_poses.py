"""What a triad is calibrated from: its poses, and the model as they can evaluate it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from calib.effects.effect import Effect
from calib.effects.needs import unavailable
from calib.effects.user_defined import fault_of_user_effect
from calib.errors import Remedy, Undetermined
from calib.fit.model import Model
from calib.poses.averaging import PoseMean
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_run import PoseRun
from calib.poses.pose_set import PoseSet, pose_set
from calib.poses.reference import PlateRate
from calib.poses.runs import gravity_run, stopped_run, turning_run
from pipeline.config.load import Config
from pipeline.config.types import STOPPED
from pipeline.stages.excluded_poses import Recorded
from pipeline.stages.poses import Recording, Recordings
from pipeline.stages.site import Gravity, latitude_of


@dataclass(frozen=True, eq=False)
class TriadPoses:
    """The recordings of a triad by run, and how poses of these runs become one set."""

    recorded: tuple[tuple[str, Recording], ...]
    poses_of: Callable[[Recorded], PoseSet]

    @property
    def used(self) -> PoseSet:
        """All poses that the configuration does not exclude."""
        return self.poses_of([(each.means, each.places) for _, each in self.recorded])


def accelerometer_poses(config: Config, recordings: Recordings, gravity: Gravity) -> TriadPoses:
    """The poses at rest, measured against ``gravity``."""
    assert config.accelerometer is not None

    def poses_of(recorded: Recorded) -> PoseSet:
        ((means, _),) = recorded
        run = gravity_run(STOPPED, means, gravity.value_m_s2, gravity.sd_m_s2)
        return pose_set("accelerometer", [run], recordings.origin_s)

    return TriadPoses(((STOPPED, recordings.of(config.accelerometer)),), poses_of)


def gyroscope_poses(
    config: Config,
    rates: Mapping[str, PlateRate],
    recordings: Recordings,
    correct_force: Callable[[Conditions], FloatArray] | None,
) -> TriadPoses:
    """The poses of all runs of the gyroscope.

    Parameters
    ----------
    rates : mapping of str to PlateRate
        The plate's rates by setting.
    recordings : Recordings
        The averaged poses.
    correct_force : callable or None
        The calibration of the accelerometer, see :func:`calib.poses.pose_set.pose_set`.
    """
    assert config.gyroscope is not None
    latitude = latitude_of(config.site)
    recorded = tuple((section.rate, recordings.of(section)) for section in config.gyroscope.runs)

    def run_of(name: str, means: Sequence[PoseMean], places: IntArray) -> PoseRun:
        if name == STOPPED:
            return stopped_run(name, means, latitude)
        return turning_run(means, rates[name].of_poses(places), latitude)

    def poses_of(each: Recorded) -> PoseSet:
        runs = [run_of(name, *one) for (name, _), one in zip(recorded, each, strict=True)]
        return pose_set("gyroscope", runs, recordings.origin_s, correct_force)

    return TriadPoses(recorded, poses_of)


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
        reason = unavailable(effect, poses.conditions(poses.reading))
        if reason is not None:
            raise Undetermined(
                f"{poses.triad}: '{effect.name}' cannot be evaluated in these poses: {reason}.",
                Remedy("remove_effect", poses.triad),
            )
    return model, usable, notes
