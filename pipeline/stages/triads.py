"""The calibration stage: from averaged poses to a calibrated, compared and diagnosed triad."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from calib.assess import AssessedTriad, assess, calibrate
from calib.consistency.certificate import (
    Compared,
    FactoryCertificate,
    compare_certificate,
)
from calib.consistency.data_sheet import (
    direction_against_clip,
    gain_off_the_sheet,
    sds_too_large,
    turning_while_still,
)
from calib.consistency.force import force_notes, require_gravity
from calib.diagnosis.unseen import unseen_budget
from calib.effects.effect import Effect
from calib.fit.triad.calibration import TriadCalibration
from calib.fit.triad.frame_alignment import FrameRotation, rotation_between_frames
from calib.fit.triad.other_poses import missing_in, with_typical_columns
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.past import with_pasts
from calib.poses.pose_set import PoseSet
from calib.poses.reference import PlateRate
from pipeline.config.load import Config
from pipeline.config.schema import TriadFitSection
from pipeline.config.sensor import triad_spec
from pipeline.stages.excluded_poses import ExcludedPose
from pipeline.stages.recordings import Recordings
from pipeline.stages.references import Gravity, certificate_of, gravity_of
from pipeline.stages.triad_poses import (
    TriadPoses,
    accelerometer_poses,
    gyroscope_poses,
    model_on,
    resting_poses,
)
from pipeline.stages.user_effects import user_effects

FRAME = "frame_rotation"  #: the effect for which direction rows make a parameter


@dataclass(frozen=True, eq=False)
class TriadResult(AssessedTriad):
    """An assessed triad with further results of the session.

    ``made_from`` is its input, ``unseen`` the sds due to effects that these poses cannot see, if
    the sensor is typical of its class; ``frame`` the rotation of a gyroscope against the
    accelerometer, None for others and where the poses do not show it; ``warnings`` list
    contradictions between two stages; ``excluded`` the poses that the configuration leaves out.
    """

    made_from: "TriadInput" = field(repr=False)
    unseen: Mapping[str, FloatArray]
    frame: FrameRotation | None = None
    warnings: tuple[str, ...] = ()
    excluded: tuple[ExcludedPose, ...] = ()

    @property
    def gravity(self) -> Gravity | None:
        """The reference of an accelerometer; None for others."""
        return self.made_from.gravity

    @cached_property
    def certificate(self) -> dict[str, Compared] | None:
        """The factory certificate beside the calibration; None where none is stated."""
        stated, calibration = self.made_from.certificate, self.calibration
        return None if stated is None else compare_certificate(
            calibration.parameters, stated, calibration.spec)

    @property
    def triad(self) -> Triad:
        """The name of the triad."""
        return self.calibration.triad

    @property
    def undetermined(self) -> tuple[str, ...]:
        """The effects that these poses cannot see; a rotation that is a parameter is none."""
        return tuple(name for name in self.diagnosis.blind
                     if name != FRAME or self.frame is None)


@dataclass(frozen=True, eq=False)
class TriadInput:
    """Input of a triad's calibration.

    ``recorded`` are its poses; ``defined`` the user's effects; ``covariates``, ``part`` and
    ``senses`` as in :func:`calib.assess.assess`; ``notes`` the unknowns of the specific force in
    its poses. ``accelerometer`` corrects that force, and is the frame that the rotation of a
    gyroscope is measured against; ``filmed`` are the directions of the plate, pose by pose, None
    where no clip shows one.
    """

    section: TriadFitSection
    recorded: TriadPoses
    spec: TriadSpec
    defined: Mapping[str, Effect]
    covariates: tuple[str, ...] | None
    part: str
    certificate: FactoryCertificate | None
    gravity: Gravity | None = None
    senses: Mapping[str, float] | None = None
    notes: tuple[str, ...] = ()
    accelerometer: TriadCalibration | None = None
    filmed: Sequence[str | None] = ()

    @cached_property
    def with_pasts(self) -> PoseSet:
        """The used poses with the past columns that the user's effects read."""
        return with_pasts(
            self.recorded.used, [past for each in self.defined.values() for past in each.pasts])

    @property
    def options(self) -> Mapping[str, Any]:
        """Arguments of :func:`calib.assess.assess` besides poses, model and candidates."""
        return {"spec": self.spec, "solver": self.section.solver, "loss": self.section.loss,
                "covariates": self.covariates, "senses": self.senses, "part": self.part}

    def calibrated(self, seek_mistakes: bool = True) -> TriadCalibration:
        """The calibration alone, without comparison and diagnosis.

        ``seek_mistakes`` as in :func:`calib.assess.calibrate`.

        Raises
        ------
        CalibrationError
            As :meth:`result`.
        """
        model, _, _ = model_on(self.section.model, self.defined, self.with_pasts)
        return calibrate(self.with_pasts, model, self.spec, solver=self.section.solver,
                         loss=self.section.loss, senses=self.senses, seek_mistakes=seek_mistakes)

    def result(self) -> TriadResult:
        """The triad calibrated, all its runs jointly, compared and diagnosed.

        Raises
        ------
        Undetermined
            The poses do not determine the model.
        """
        poses = self.with_pasts
        model, usable, notes = model_on(self.section.model, self.defined, poses)
        assessed = assess(poses, model, candidates=tuple(usable.values()), **self.options)
        fitted = assessed.calibration.fit
        warnings = [*notes, *doubts_of(assessed.calibration)]
        if any(mean.stated for _, one in self.recorded.recorded for mean in one.means):
            warnings += sds_too_large(fitted)
        frame = None
        if poses.triad == "gyroscope":
            frame = rotation_between_frames(
                fitted, self.accelerometer.fit if self.accelerometer else None)
            warnings += [*self.notes, *direction_against_clip(poses, self.filmed)]
        return TriadResult(
            **vars(assessed), made_from=self,
            unseen=unseen_budget(assessed.calibration, assessed.diagnosis.blind, self.part),
            frame=frame, warnings=tuple(warnings), excluded=self.recorded.excluded(fitted))


def triad_input(
    triad: Triad,
    config: Config,
    rates: Mapping[str, PlateRate],
    recordings: Recordings,
    accelerometer: TriadCalibration | None = None,
    *,
    allow_python: bool = False,
) -> TriadInput:
    """Input of a triad's calibration: against gravity, or against the plate's rates.

    Parameters
    ----------
    triad : str
    config : Config
        With a section of this triad.
    rates : mapping of str to PlateRate
        The plate's rates by setting.
    recordings : Recordings
        The averaged poses.
    accelerometer : TriadCalibration, optional
        Corrects the specific force in the poses of another triad.
    allow_python : bool
        Whether Python files of user-defined effects may run.

    Raises
    ------
    Undetermined
        Its poses make no set.
    Contradiction
        The calibrated accelerometer does not read gravity in the poses of another triad.
    """
    # The configuration's rules refuse a triad without a data sheet, and gravity without a site.
    section, spec = config.triads[triad], triad_spec(config.sensor.sheets[triad])
    gravity = gravity_of(config.site) if config.site is not None else None
    # The class of parts of the sensor: factory-calibrated or not.
    part = "MTi" if "mti" in config.sensor.name.lower() else "MPU-6050"

    def read_in(recorded: TriadPoses, **more: Any) -> TriadInput:
        return TriadInput(
            section, recorded, spec, user_effects(config, triad, allow_python),
            config.covariates, part, certificate_of(config, triad), **more)

    if triad == "accelerometer":
        assert gravity is not None
        return read_in(accelerometer_poses(config, recordings, gravity), gravity=gravity)
    if triad != "gyroscope":
        return read_in(resting_poses(triad, config, recordings))
    recorded = gyroscope_poses(config, rates, recordings, accelerometer)
    is_known, notes = (
        (True, ()) if accelerometer is None or gravity is None
        else _check_force(recorded.used, accelerometer, gravity.value_m_s2))
    return read_in(
        recorded, notes=notes, accelerometer=accelerometer,
        senses=({name: one.sense for name, one in recorded.recorded}
                if accelerometer and is_known else None),
        filmed=[rates[run].direction if run in rates else None for run in recorded.used.run])


def _check_force(
    poses: PoseSet, accelerometer: TriadCalibration, gravity_m_s2: float
) -> tuple[bool, tuple[str, ...]]:
    """Whether the calibrated force in a gyroscope's poses is good enough for comparing axes.

    Returns
    -------
    bool
    tuple of str
        Sentences on what is not known of it.

    Raises
    ------
    Contradiction
        The calibrated accelerometer does not read gravity in them.
    """
    whole = with_typical_columns(accelerometer, poses)
    missing = missing_in(accelerometer, poses)
    if still := missing_in(accelerometer, whole):
        reasons = "; ".join(f"{name}: {reason}" for name, reason in still.items())
        return False, (
            f"the poses of the gyroscope cannot evaluate all effects of the accelerometer "
            f"({reasons}). The specific force there is corrected without them, and the axes of "
            f"the triads were not compared.",)
    require_gravity(whole, accelerometer, gravity_m_s2)
    hardly, off = force_notes(whole, accelerometer, gravity_m_s2)
    notes = tuple(note for note in (hardly, off) if note)
    if missing and np.isfinite(poses.force).all():
        reasons = "; ".join(f"{name}: {reason}" for name, reason in missing.items())
        notes += (f"in the poses of the gyroscope the accelerometer is corrected as in its own "
                  f"poses on average, because they cannot evaluate all of its effects "
                  f"({reasons}).",)
    return hardly is None, notes


def doubts_of(calibration: TriadCalibration) -> tuple[str, ...]:
    """Doubts about a calibration from its own poses and its data sheet."""
    poses = calibration.fit.poses
    return (*poses.notes, *turning_while_still(poses),
            *gain_off_the_sheet(calibration.parameters, calibration.spec, poses.triad))
