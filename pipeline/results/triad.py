"""A calibrated triad as it stands in results.json."""

from collections.abc import Mapping
from pathlib import Path

from calib.fit.triad.calibration import uncertainty_budget
from calib.poses.data_sheet import TriadSpec
from pipeline.config.schema import EffectSection
from pipeline.results.candidate import candidate_json
from pipeline.results.json_values import Json, number, numbers
from pipeline.results.names import PARAMETERS
from pipeline.stages.triads import TriadResult
from pipeline.stages.user_effects import python_sha256

WORST_POSES = 3  #: in results.json, and named by `pipeline diagnose`: chosen


def triad_json(
    result: TriadResult, user_effects: Mapping[str, EffectSection], folder: Path
) -> Json:
    """One calibrated triad; ``user_effects`` are defined by the configuration in ``folder``."""
    calibration, comparison = result.calibration, result.comparison
    fit, parameters = calibration.fit, calibration.parameters
    misalignment_sd, bias_sd, scale_sd = parameters.sd
    section: Json = {
        "model": list(fit.model.names),
        "n_poses": len(fit.poses),
        "chi2": fit.chi2,
        "dof": fit.dof,
        "p_value": calibration.p_value,
        "residual_rms": comparison.residual_rms,
        "loo_rms": comparison.loo_rms,
        "iterations": fit.iterations,
        "parameters": {
            "misalignment_rad": numbers(parameters.misalignment_rad),
            "bias_counts": numbers(parameters.bias_counts),
            "scale_counts_per_unit": numbers(parameters.scale_counts_per_unit),
        },
        "sd": {
            "misalignment_rad": numbers(misalignment_sd),
            "bias_counts": numbers(bias_sd),
            "scale_counts_per_unit": numbers(scale_sd),
        },
        "sd_widened_by": calibration.widening,
        "sd_parts": _sd_parts(result),
        "sd_parts_if_typical": _unseen(result),
        "effects": _effects(result),
        "worst_poses": [pose.label for pose in comparison.worst(WORST_POSES)],
        "misfit_follows": result.diagnosis.follows,
        "poses": _poses(result),
        "excluded": _excluded(result),
        "prediction": _prediction(result),
        "diagnosis": _diagnosis(result),
        "correction": correction_json(result, user_effects, folder),
    }
    if result.triad == "gyroscope":
        frame = result.frame
        section["frame_to_accelerometer_rad"] = None if frame is None else numbers(frame.angles_rad)
        section["frame_sd_rad"] = None if frame is None else numbers(frame.sd_rad)
        section["lever_m"] = None if frame is None else numbers(frame.lever_m)
    if result.gravity is not None:
        section["gravity"] = {
            "value_m_s2": result.gravity.value_m_s2,
            "sd_m_s2": result.gravity.sd_m_s2,
            "source": result.gravity.source,
        }
    return section


def _unseen(result: TriadResult) -> Json:
    """What these poses cannot see, at its typical size; not part of the sds."""
    return {
        name: dict(zip(PARAMETERS, map(numbers, sds), strict=True))
        for name, sds in result.unseen.items()
    }


def _sd_parts(result: TriadResult) -> Json:
    """What each sd is made of, by cause; the squares add up."""
    return {
        cause: dict(zip(PARAMETERS, map(numbers, sds), strict=True))
        for cause, sds in uncertainty_budget(result.calibration).items()
    }


def _effects(result: TriadResult) -> Json:
    """The added effects; a shape parameter stands last, with its unit after the others'."""
    model = result.calibration.fit.model
    units = {effect.name: effect.unit_for(result.triad) for effect in model.effects}
    shapes = {effect.name: effect.shape for effect in model.effects}
    section: Json = {}
    for name, (values, sd) in result.calibration.effect_values().items():
        shape = shapes[name]
        unit = units[name] if shape is None else f"{units[name]}; {shape.name}: {shape.unit}"
        section[name] = {"values": numbers(values), "sd": numbers(sd), "unit": unit}
    return section


def _poses(result: TriadResult) -> list[Json]:
    """Every pose: what was read, what the calibration makes of it, and what is left."""
    poses, corrected = result.calibration.fit.poses, result.calibration.fit.rows.vector
    return [
        {
            "label": pose.label,
            "run": pose.run,
            "residual": pose.residual,
            "sd": pose.sd,
            "left_out": pose.left_out,
            "reference": float(poses.reference.magnitude[i]),
            "time_s": number(poses.time_s[i]),
            "reading": numbers(poses.reading[i]),
            "reading_sd": numbers(poses.sd[i]),
            "corrected": numbers(corrected[i]),
            "columns": {name: number(values[i]) for name, values in poses.columns.items()},
        }
        for i, pose in enumerate(result.comparison.poses)
    ]


def _excluded(result: TriadResult) -> list[Json]:
    """The poses that the configuration leaves out, with what the fit makes of them."""
    return [
        {
            "label": each.label,
            "run": each.run,
            "residual": number(each.predicted.residual.residual) if each.predicted else None,
            "sd": number(each.predicted.residual.sd) if each.predicted else None,
        }
        for each in result.excluded
    ]


def _prediction(result: TriadResult) -> Json | None:
    """What a corrected magnitude will err by, 1 sd, over all directions; SI."""
    prediction = result.prediction
    if prediction is None:
        return None
    return {
        "sd_median": number(prediction.sd_median),
        "sd_worst": number(prediction.sd_worst),
        "worst_direction": numbers(prediction.worst_direction),
        "parts": {
            "poses": number(prediction.by_poses),
            "unseen": {name: number(rms) for name, rms in prediction.by_unseen.items()},
            "open": number(prediction.by_open),
        },
    }


def _diagnosis(result: TriadResult) -> Json:
    diagnosis = result.diagnosis
    return {
        "verdict": str(diagnosis.verdict),
        "name": diagnosis.name,
        "names": list(diagnosis.names),
        "group": list(diagnosis.group),
        "inclusion": [
            {"class": each.name, "members": list(each.members), "probability": each.probability}
            for each in diagnosis.inclusion
        ],
        "says": diagnosis.text,
        "record_next": diagnosis.record_next,
        "blind": list(diagnosis.blind),
        "ranking": [
            candidate_json(each, each.rms_after, each.loo_after)
            for each in diagnosis.ranking
        ]
        + [_blind(name) for name in diagnosis.blind],
    }


def _blind(name: str) -> Json:
    """The entry of an effect that these data cannot see: last in the ranking, without numbers."""
    return {
        "name": name,
        "log_evidence": None,
        "chi2_drop": None,
        "size": [],
        "sd": [],
        "rms_after": None,
        "loo_after": None,
        "blind": True,
        "aliases": [],
    }


def correction_json(
    result: TriadResult, user_effects: Mapping[str, EffectSection], folder: Path
) -> Json:
    """What :mod:`pipeline.results.read` needs to correct other logs: data sheet, model, parameters.

    User-defined effects are kept as they were defined; Python code by its file's name and hash.
    """
    correction = result.calibration.correction
    return {
        "sheet": _sheet(correction.spec),
        "model": list(correction.model.names),
        "theta": numbers(correction.theta),
        "shapes": {name: float(value) for name, value in correction.shapes.items()},
        "own_effects": {
            name: _definition(user_effects[name], folder)
            for name in correction.model.names
            if name in user_effects
        },
    }


def _definition(section: EffectSection, folder: Path) -> Json:
    """A user-defined effect as it stands in the configuration."""
    kept = section.model_dump(mode="json", include={"expression", "python", "per", "unit"})
    if section.shapes:
        kept["shapes"] = {name: list(each) for name, each in section.shapes.items()}
    if section.python is not None:
        kept["python_sha256"] = python_sha256(folder, section.python)
    return kept


def _sheet(spec: TriadSpec) -> Json:
    return {
        "full_scale": number(spec.full_scale),
        "bits": spec.bits,
        "encoding": spec.encoding,
        "si_per_unit": spec.si_per_unit,
    }
