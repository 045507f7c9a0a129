"""From poses and a model to the calibration, its misfit, its diagnosis and its prediction.

The one way from a set of poses to a result, for the command, a notebook and a fleet.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from calib.consistency.mistakes import require_no_mistake, require_one_sensor
from calib.consistency.plate_axes import require_common_axes
from calib.consistency.repeats import require_no_repeated_means
from calib.diagnosis.diagnose import Diagnosis, diagnose
from calib.diagnosis.grounds import on_its_grounds
from calib.diagnosis.unseen import LOW_COST, with_unseen
from calib.diagnosis.verdict.decision import Code
from calib.effects.effect import Effect
from calib.errors import FitFailed, Remedy, Undetermined
from calib.fit.least_squares.angrisano import fit_paper
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from calib.fit.least_squares.unknown_sd import has_sds, tests_the_model, with_estimated_sds
from calib.fit.model import Model
from calib.fit.triad.calibration import TriadCalibration, calibrate_triad
from calib.fit.triad.within_poses import at_one_length
from calib.fit.validation.leave_one_out import Comparison, compare
from calib.fit.validation.prediction import Prediction, predict, with_sds_of
from calib.fit.validation.untold import untold_errors
from calib.fit.validation.wave_misfit import with_misfit_of_waves
from calib.poses.data_sheet import TriadSpec
from calib.poses.pose_set import PoseSet
from calib.threads import on_one_thread


@dataclass(frozen=True, eq=False)
class AssessedTriad:
    """A calibrated triad and its comparison with the measurements.

    ``prediction`` is its expected error on the next log, None if all poses were at rest.
    """

    calibration: TriadCalibration = field(repr=False)
    comparison: Comparison = field(repr=False)
    diagnosis: Diagnosis
    prediction: Prediction | None = field(repr=False)


@on_one_thread
def assess(
    poses: PoseSet,
    model: Model,
    spec: TriadSpec,
    *,
    solver: str = "default",
    loss: str = "squares",
    candidates: Sequence[Effect] = (),
    covariates: Sequence[str] | None = None,
    senses: Mapping[str, float] | None = None,
    part: str = LOW_COST,
) -> AssessedTriad:
    """Calibrate one triad and compare the model with the measurements.

    Parameters
    ----------
    poses : PoseSet
        n poses; where their means have no sds, these are estimated from the poses.
    model : Model
    spec : TriadSpec
        The data sheet that made the readings nominal.
    solver : str
        ``default``, or ``paper`` for Angrisano et al. eq. (4)-(11).
    loss : str
        ``squares`` or ``huber``.
    candidates : sequence of Effect
        Effects beside the catalogue's that the diagnosis considers.
    covariates : sequence of str or None
        Logged columns that may be causes; None for all that do not follow attitude or clock.
    senses : mapping of run to float, or None
        How the plate turns by the accelerometer alone, +1 ccw, -1 cw, 0 unknown; of a gyro whose
        poses have the calibrated specific force, so that the axes of both triads are compared.
    part : str
        Class of the sensor, as the pages of the catalogue call it: how large what these poses
        cannot see typically is.

    Raises
    ------
    Undetermined
        The poses do not determine the model.
    Contradiction
        A mistake in the files explains the misfit, or the axes of the triads contradict each other.
    FitFailed
        The fit does not converge, or fails its own check.
    CalibrationError
        ``solver="paper"`` with more than bias, scale and misalignment.
    """
    calibration = calibrate(poses, model, spec, solver=solver, loss=loss, senses=senses)
    fitted = calibration.fit
    prediction = predict(calibration)
    diagnosis = diagnose(fitted, candidates, spec.full_scale, covariates, prediction)
    averaged = diagnosis.averaged
    # What may be missing of the catalogue, where nothing is likely to be, has limits of its own.
    settled = diagnosis.verdict == Code.NOTHING_MISSING
    whole = calibration.averaged(averaged.factor, averaged.unlisted if settled else averaged.held)
    if prediction is not None:  # and else counts by what it does to the next log
        of_parameters = calibration.averaged(averaged.factor, averaged.unlisted)
        prediction = replace(
            with_unseen(with_sds_of(prediction, of_parameters), calibration, diagnosis, part),
            untold=untold_errors(calibration, prediction))
    return AssessedTriad(
        whole, compare(fitted),
        on_its_grounds(diagnosis, fitted, prediction, part, spec.full_scale), prediction)


def calibrate(
    poses: PoseSet,
    model: Model,
    spec: TriadSpec,
    *,
    solver: str = "default",
    loss: str = "squares",
    senses: Mapping[str, float] | None = None,
    seek_mistakes: bool = True,
) -> TriadCalibration:
    """The calibration of :func:`assess` alone, with all its refusals.

    ``seek_mistakes`` is False for a model that is tried and not kept: a misfit is then not traced
    to the files, and the axes are not compared.

    Raises
    ------
    CalibrationError
        As :func:`assess`.
    """
    drawn = model.acting_on("noise")
    if seek_mistakes:
        require_no_repeated_means(poses)
    if not has_sds(poses):
        means = Model(tuple(effect for effect in model.effects if not effect.drawn))
        poses = with_estimated_sds(poses, means)
    poses = at_one_length(poses, model)
    if drawn and not tests_the_model(poses):
        raise Undetermined(
            f"{poses.triad}: '{drawn[0].name}' cannot be told from the noise: the sds of the poses "
            f"were estimated from what the model leaves. State the sds of the means.",
            Remedy("remove_effect", poses.triad))
    fitted = _fitted(poses, model, spec, solver, loss, seek_mistakes)
    if seek_mistakes and senses is not None:
        require_common_axes(poses, fitted.rows.vector, senses)
    return calibrate_triad(fitted, spec)


def _fitted(
    poses: PoseSet, model: Model, spec: TriadSpec, solver: str, loss: str, seek_mistakes: bool
) -> Fit:
    """The fit; a mistake in the files that explains its misfit, or its refusal, is named first."""
    try:
        fitted = (fit_paper(replace(poses, ring=None), model, spec) if solver == "paper"
                  else fit(poses, model, robust=loss == "huber"))
        if (widened := with_misfit_of_waves(fitted)) is not None:
            poses, fitted = widened, fit(widened, model, robust=loss == "huber")
    except (FitFailed, Undetermined):
        if seek_mistakes:
            require_no_mistake(poses, model, None)
        raise
    if seek_mistakes:
        require_no_mistake(poses, model, fitted)
        require_one_sensor(poses, model, fitted)
    return fitted
