"""A calibrated triad for results.json."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from calib.fit.triad.calibration import uncertainty_budget
from calib.fit.validation.prediction import Prediction
from calib.poses.imu_log import SI_UNIT, FloatArray
from pipeline.config.schema import EffectSection
from pipeline.results.json_values import Json
from pipeline.results.names import PARAMETERS
from pipeline.results.schema import triad as schema
from pipeline.results.schema.rate import CandidateResult
from pipeline.stages.excluded_poses import ExcludedPose
from pipeline.stages.triads import TriadResult
from pipeline.stages.user_effects import python_sha256

WORST_POSES = 3  #: in results.json, and named by `pipeline diagnose`: chosen


def triad_section(
    result: TriadResult, user_effects: Mapping[str, EffectSection], folder: Path
) -> schema.TriadSection:
    """One calibrated triad; ``user_effects`` are defined by the configuration in ``folder``."""
    calibration, comparison = result.calibration, result.comparison
    fit = calibration.fit
    section = {
        "model": fit.model.names,
        "n_poses": len(fit.poses),
        "chi2": fit.chi2,
        "dof": fit.dof,
        "p_value": calibration.fit.p_value,
        "residual_rms": comparison.residual_rms,
        "loo_rms": comparison.loo_rms,
        "iterations": fit.iterations,
        "parameters": schema.Parameters.of(calibration.parameters),
        "sd": _sds(calibration.parameters.sd),
        "sd_widened_by": calibration.widening,
        "sd_parts": {cause: _sds(sds) for cause, sds in uncertainty_budget(calibration).items()},
        "sd_parts_if_typical": {name: _sds(sds) for name, sds in result.unseen.items()},
        "effects": _effects(result),
        "worst_poses": [pose.label for pose in comparison.worst(WORST_POSES)],
        "misfit_follows": result.diagnosis.follows,
        "poses": _poses(result),
        "excluded": [_excluded(one) for one in result.excluded],
        "prediction": result.prediction and _prediction(result.prediction),
        "diagnosis": _diagnosis(result),
        "correction": _correction(result, user_effects, folder),
        "certificate": None if result.certificate is None else {
            name: schema.CertificateGroup.of(group) for name, group in result.certificate.items()},
    }
    if result.triad == "accelerometer":
        gravity = schema.GravityResult.of(result.gravity)
        return schema.AccelerometerResult.of(**section, gravity=gravity)
    if result.triad != "gyroscope":
        reference = fit.poses.reference
        return schema.FurtherResult.of(**section, reference=schema.ReferenceResult.of(
            value=reference.magnitude[0], sd=reference.common[0, 0], unit=SI_UNIT[result.triad]))
    frame = result.frame
    return schema.GyroscopeResult.of(
        **section,
        frame_to_accelerometer_rad=None if frame is None else frame.angles_rad,
        frame_sd_rad=None if frame is None else frame.sd_rad,
        lever_m=None if frame is None else frame.lever_m,
    )


def _sds(sds: Iterable[FloatArray]) -> schema.ParameterSds:
    return schema.ParameterSds.of(**dict(zip(PARAMETERS, sds, strict=True)))


def _effects(result: TriadResult) -> dict[str, schema.EffectResult]:
    """The added effects; a shape parameter is last, with its unit after the others'."""
    added = {effect.name: effect for effect in result.calibration.fit.model.effects}
    stands_for, parts = result.diagnosis.stands_for, {}
    for name, (values, sd) in result.calibration.effect_values().items():
        shape, unit = added[name].shape, added[name].unit_for(result.triad)
        unit = unit if shape is None else f"{unit}; {shape.name}: {shape.unit}"
        alike = stands_for[name].names if name in stands_for else ()
        parts[name] = schema.EffectResult.of(values=values, sd=sd, unit=unit, stands_for=alike)
    return parts


def _poses(result: TriadResult) -> list[schema.PoseResult]:
    """Every pose: its reading, the corrected vector, and the residual."""
    poses, corrected = result.calibration.fit.poses, result.calibration.fit.rows.vector
    return [
        schema.PoseResult.of(
            pose,
            reference=poses.reference.magnitude[i],
            time_s=poses.time_s[i],
            reading=poses.reading[i],
            reading_sd=poses.sd[i],
            corrected=corrected[i],
            force_m_s2=poses.force[i] if result.triad == "gyroscope" else None,
            spin_rad_s=poses.spin_rad_s[i],
            columns={name: values[i] for name, values in poses.columns.items()},
        )
        for i, pose in enumerate(result.comparison.poses)
    ]


def _excluded(pose: ExcludedPose) -> schema.ExcludedResult:
    """A pose that the configuration excludes, with the prediction of the fit."""
    known: Json = {"label": pose.label, "run": pose.run}
    if pose.cut_off is not None:
        known["cut_off_counts"] = pose.cut_off
    if pose.predicted is None:
        return schema.ExcludedResult.of(**known, residual=None, sd=None)
    return schema.ExcludedResult.of(pose.predicted.residual, **known)


def _prediction(prediction: Prediction) -> schema.PredictionResult:
    """Expected error of a corrected magnitude, 1 sd, over all directions, and its parts."""
    parts = schema.PredictionParts.of(
        poses=prediction.by_poses, unseen=prediction.by_unseen, untold=prediction.by_untold,
        open=prediction.by_open)
    return schema.PredictionResult.of(prediction, parts=parts)


def _diagnosis(result: TriadResult) -> schema.TriadDiagnosis:
    diagnosis = result.diagnosis
    ranking = [CandidateResult.of(one, blind=False) for one in diagnosis.ranking]
    # Effects that these data cannot see come last, without numbers.
    blind = [CandidateResult(
        name=name, log_evidence=None, chi2_drop=None, size=[], sd=[], rms_after=None,
        loo_after=None, blind=True, aliases=[]) for name in diagnosis.blind]
    return schema.TriadDiagnosis.of(
        diagnosis,
        inclusion=[schema.InclusionResult.of(one, **{"class": one.name})
                   for one in diagnosis.inclusion],
        says=diagnosis.text,
        standing=diagnosis.explanation.standing,
        short=diagnosis.explanation.short,
        ranking=[*ranking, *blind],
    )


def _correction(
    result: TriadResult, user_effects: Mapping[str, EffectSection], folder: Path
) -> schema.CorrectionResult:
    """Data for :mod:`pipeline.results.read` to correct other logs: data sheet, model, parameters.

    User-defined effects are kept as they were defined; Python code by its file's name and hash.
    """
    correction = result.calibration.correction
    return schema.CorrectionResult.of(
        correction,
        sheet=schema.Sheet.of(correction.spec),
        model=correction.model.names,
        own_effects={name: _definition(user_effects[name], folder)
                     for name in correction.model.names if name in user_effects},
    )


def _definition(section: EffectSection, folder: Path) -> schema.UserEffect:
    """A user-defined effect as defined in the configuration."""
    more: Json = {"shapes": dict(section.shapes)} if section.shapes else {}
    if section.python is not None:
        more["python_sha256"] = python_sha256(folder, section.python)
    return schema.UserEffect.of(
        expression=section.expression, python=section.python, per=section.per, unit=section.unit,
        **more)
