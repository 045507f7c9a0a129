"""Input of a triad's calibration: its poses, and the model as far as they can evaluate it."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calib.effects.catalogue import BASE
from calib.effects.effect import Effect
from calib.effects.needs import unavailable
from calib.effects.user_defined import fault_of_user_effect
from calib.errors import CalibrationError, Remedy, Undetermined
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit as fitted
from calib.fit.model import Model
from calib.fit.triad.calibration import TriadCalibration
from calib.fit.triad.leaning import leaning_of, with_axes
from calib.fit.triad.other_poses import correct_other_poses
from calib.fit.validation.elsewhere import PredictedPose, predict_pose
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.imu_log import IntArray, Triad
from calib.poses.pose_set import PoseSet, pose_set
from calib.poses.reference import CommonError, PlateRate
from calib.poses.runs.ideal_ring import NOT_FITTED, Leaning, tilted_run
from calib.poses.runs.pose_run import PoseRun, laid_down
from calib.poses.runs.reference_runs import (
    gravity_run,
    still_run,
    stopped_run,
    turning_run,
)
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.config.load import Config
from pipeline.config.schema import RunSection
from pipeline.config.types import STOPPED
from pipeline.stages.excluded_poses import ExcludedMean, ExcludedPose
from pipeline.stages.recordings import Recording, Recordings
from pipeline.stages.references import Gravity, latitude_of

Recorded = Sequence[tuple[Sequence[PoseMean], IntArray]]
"""The poses of every run, and their indices among those recorded there."""


@dataclass(frozen=True, eq=False)
class TriadPoses:
    """The recordings of a triad by run, and the function that joins poses of these runs."""

    recorded: tuple[tuple[str, Recording], ...]
    poses_of: Callable[[Recorded], PoseSet]

    @cached_property
    def used(self) -> PoseSet:
        """All poses that the configuration does not exclude."""
        return self.poses_of([(one.means, one.places) for _, one in self.recorded])

    def excluded(self, fit: Fit) -> tuple[ExcludedPose, ...]:
        """The excluded poses, each with the prediction of a fit without them."""
        triad = fit.poses.triad
        return tuple(ExcludedPose(one.label, name, self._predicted(fit, run, one),
                                  one.cut_off.get(triad))
                     for run, (name, recording) in enumerate(self.recorded)
                     for one in recording.excluded)

    def _predicted(self, fit: Fit, run: int, excluded: ExcludedMean) -> PredictedPose | None:
        if excluded.mean is None:
            return None
        recorded = [(one.means, one.places) for _, one in self.recorded]
        means, places = recorded[run]
        recorded[run] = ((*means, excluded.mean), np.append(places, excluded.place))
        place = sum(len(one) for one, _ in recorded[: run + 1]) - 1
        try:
            return predict_pose(fit, self.poses_of(recorded), place)
        except CalibrationError:  # that it belongs to no run may be why it is excluded
            return None


TILT_ROUNDS = 2
"""Rounds of the tilt's fit. Derived: the first leaves the square of the nominal accelerometer's
error, a few 1e-4 of a radian, and the second its fourth power."""


def accelerometer_poses(config: Config, recordings: Recordings, gravity: Gravity) -> TriadPoses:
    """The poses at rest and those on plates that lean, measured against ``gravity``.

    The plates lean by the tilt that a fit of these poses gives.

    Raises
    ------
    Undetermined
        As they are used: an axis gives the very same value in all poses of a run, or a plate does
        not lean enough to show the accelerometer's parameters.
    """
    poses = _accelerometer_poses(config, recordings, gravity, NOT_FITTED)
    for _ in range(TILT_ROUNDS):
        if poses.used.ring is None:
            break
        try:
            leaning = leaning_of(fitted(poses.used, Model.of(BASE)))
        except CalibrationError:  # reported where the model of the configuration is fitted
            break
        poses = _accelerometer_poses(config, recordings, gravity, leaning)
    return poses


def _accelerometer_poses(
    config: Config, recordings: Recordings, gravity: Gravity, leaning: Leaning
) -> TriadPoses:
    assert config.accelerometer is not None
    sections = config.accelerometer.sections
    recorded = tuple((run.rate, recordings.of(run)) for run in sections)

    def poses_of(one: Recorded) -> PoseSet:
        runs = [run_in_gravity(section.rate, means, gravity, attitude_sd_rad(section), leaning)
                for section, (means, _) in zip(sections, one, strict=True)]
        return pose_set("accelerometer", runs, recordings.origin_s)

    return TriadPoses(recorded, poses_of)


def run_in_gravity(
    rate: str, means: Sequence[PoseMean], gravity: Gravity, attitude_sd: float | None,
    leaning: Leaning = NOT_FITTED,
) -> PoseRun:
    """Poses of the accelerometer at rest, or on a plate that leans, at the setting ``rate``.

    ``attitude_sd`` in rad is that of faces at rest, None where they are not known.

    Raises
    ------
    Undetermined
        An axis gives the very same value in all poses.
    """
    if rate == STOPPED:
        run = gravity_run(rate, means, gravity.value_m_s2, gravity.sd_m_s2)
        return laid_down(run, attitude_sd)
    return tilted_run(rate, means, gravity.value_m_s2, gravity.sd_m_s2, leaning)


def run_on_plate(
    rate: str, means: Sequence[PoseMean], plate: PlateRate | None, latitude: float | None,
    attitude_sd: float | None,
) -> PoseRun:
    """Poses of the gyroscope at the setting ``rate``; ``plate`` is None where the plate stood.

    ``latitude`` in degrees, ``attitude_sd`` in rad, each None where it is not known.

    Raises
    ------
    Undetermined
        An axis gives the very same value in all poses.
    """
    if plate is None:
        return stopped_run(rate, means, latitude)
    return laid_down(turning_run(means, plate, latitude), attitude_sd)


def attitude_sd_rad(section: RunSection) -> float | None:
    """Sd of the attitude of a case on a face or an edge; None where the attitude is unknown."""
    sd = section.attitude_sd_deg
    return None if sd is None else math.radians(sd)


def resting_poses(triad: Triad, config: Config, recordings: Recordings) -> TriadPoses:
    """The poses at rest of a further triad, measured against the magnitude that its section states.

    Raises
    ------
    Undetermined
        As they are used: an axis gives the very same value in all poses.
    """
    kind, section = TRIAD_KINDS[triad], config.triads[triad]
    magnitude, sd = getattr(section, kind.magnitude_key), getattr(section, kind.sd_key)
    recorded = tuple((run.rate, recordings.of(run)) for run in section.sections)

    def poses_of(one: Recorded) -> PoseSet:
        runs = [still_run(triad, name, means, magnitude, CommonError(kind.reference, sd))
                for (name, _), (means, _) in zip(recorded, one, strict=True)]
        return pose_set(triad, runs, recordings.origin_s)

    return TriadPoses(recorded, poses_of)


def gyroscope_poses(
    config: Config,
    rates: Mapping[str, PlateRate],
    recordings: Recordings,
    accelerometer: TriadCalibration | None,
) -> TriadPoses:
    """The poses of all runs of the gyroscope.

    Parameters
    ----------
    rates : mapping of str to PlateRate
        The plate's rates by setting.
    recordings : Recordings
        The averaged poses.
    accelerometer : TriadCalibration or None
        Corrects the specific force of the poses, and shows the axes of a plate that leans.

    Raises
    ------
    Undetermined
        As they are used: an axis gives the very same value in all poses of a run.
    """
    assert config.gyroscope is not None
    latitude = latitude_of(config.site)
    correct = correct_other_poses(accelerometer) if accelerometer else None
    sections = config.gyroscope.runs
    recorded = tuple((section.rate, recordings.of(section)) for section in sections)
    doubts = {name: ratio.doubt for name, ratio in recordings.clocks.items()}

    def poses_of(item: Recorded) -> PoseSet:
        runs = []
        for section, (means, places) in zip(sections, item, strict=True):
            plate = None if section.rate == STOPPED else (
                rates[section.rate].of_poses(places).doubted(doubts.get(section.rate, 0.0)))
            runs.append(run_on_plate(
                section.rate, means, plate, latitude, attitude_sd_rad(section)))
        poses = pose_set("gyroscope", runs, recordings.origin_s, correct)
        if accelerometer is None or config.accelerometer is None or not config.accelerometer.runs:
            return poses  # means and waves suffice beside a calibration at rest
        return with_axes(poses, accelerometer.fit)

    return TriadPoses(recorded, poses_of)


def model_on(
    names: Sequence[str], defined: Mapping[str, Effect], poses: PoseSet
) -> tuple[Model, dict[str, Effect], list[str]]:
    """The model of a section as far as these poses can evaluate it.

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
    at = poses.conditions(poses.reading)
    for effect in model.effects:
        reason = unavailable(effect, at)
        if reason is not None:
            complete = np.isfinite(effect.evaluate(at)).reshape(len(poses), -1).all(axis=1)
            raise Undetermined(
                f"{poses.triad}: '{effect.name}' cannot be evaluated in these poses: {reason}, "
                f"first in {poses.label[int(np.argmin(complete))]}.",
                Remedy("remove_effect", poses.triad),
            )
    return model, usable, notes
