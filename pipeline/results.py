"""results.json: what a run has found, for programs. DESIGN of the keys: ``data/README.md``.

SI units, arrays in the order x, y, z, null for what was not determined. The same input gives the
same file, byte for byte: it holds no time of day and no absolute path.
"""

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from calib.imu_log import FloatArray
from calib.sensor import TriadSpec
from pipeline.config_sections import OwnEffect
from pipeline.files import write_whole
from pipeline.rates import SettingRate
from pipeline.runner import Outcome
from pipeline.stored import FORMAT, RESULTS_NAME
from pipeline.triads import TriadResult

if TYPE_CHECKING:
    from vision.diagnosis import PhaseDiagnosis
    from vision.rate import RateMeasurement

Json = dict[str, Any]


def config_sha256(outcome: Outcome) -> str:
    """What tells one configuration from another: the hash of its text."""
    return hashlib.sha256(outcome.config.source.text.encode()).hexdigest()


def results_of(outcome: Outcome) -> Json:
    """Everything a run has found, as plain values."""
    found: Json = {
        "format": FORMAT,
        "title": outcome.config.title,
        "sensor": outcome.config.sensor.name,
        "config_sha256": config_sha256(outcome),
        "session_start_s": outcome.recordings.origin_s if outcome.triads else None,
        "rate": {name: rate_json(rate) for name, rate in outcome.rates.items()},
        "accelerometer": None,
        "gyroscope": None,
        "installation": None,
        "warnings": list(outcome.warnings),
    }
    own = outcome.config.effects
    return found | {result.triad: triad_json(result, own) for result in outcome.triads}


def write_results(folder: Path, found: Json) -> Path:
    """Write ``results.json`` into ``folder``, whole or not at all."""
    path = folder / RESULTS_NAME
    write_whole(path, json.dumps(found, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    return path


def number(value: float) -> float | None:
    """A JSON number, null for what is not finite."""
    return float(value) if math.isfinite(value) else None


def numbers(values: Sequence[float] | FloatArray) -> list[float | None]:
    """A JSON array; null for what is not finite."""
    return [number(value) for value in np.asarray(values, float).ravel()]


# --- rates -------------------------------------------------------------------------------------


def rate_json(rate: SettingRate) -> Json:
    """One plate setting; what only a clip can tell is null for a stated rate."""
    filmed = bool(rate.clips)
    counted = [clip.frame_count for clip in rate.clips if clip.frame_count is not None]
    # One clip per pose: the setting's diagnosis is that of the clip its model fits worst.
    worst = max(rate.clips, key=lambda clip: clip.phase_rms_rad, default=None)
    square = [clip.phase_rms_rad**2 for clip in rate.clips]
    return {
        "rate_rad_s": rate.rate_rad_s,
        "sd_rad_s": rate.sd_rad_s,
        "direction": rate.plate.direction,
        "revolutions": sum(clip.revolutions for clip in rate.clips) if filmed else None,
        "frames": sum(clip.frames for clip in rate.clips) if filmed else None,
        "phase_rms_rad": math.sqrt(sum(square) / len(square)) if filmed else None,
        "frame_count": _mean_count([(c.rate_rad_s, c.sd_rad_s) for c in counted]),
        "sd_parts": {
            "image_rad_s": rate.image_sd_rad_s if filmed else None,
            "timebase_rad_s": rate.timebase_sd_rad_s if filmed else None,
        },
        "source": "video" if filmed else "stated",
        "diagnosis": None if worst is None else _phase_diagnosis(worst.diagnosis),
        "clips": [_clip(*each) for each in zip(rate.sources, rate.clips, strict=True)],
    }


def _mean_count(counts: Sequence[tuple[float, float]]) -> Json | None:
    if not counts:
        return None
    rate, sd = np.array(counts).T
    return {"rate_rad_s": float(rate.mean()), "sd_rad_s": float(np.linalg.norm(sd) / len(sd))}


def _clip(source: str, clip: "RateMeasurement") -> Json:
    count = clip.frame_count
    return {
        "clip": source,
        "rate_rad_s": clip.rate_rad_s,
        "sd_rad_s": clip.sd_rad_s,
        "direction": clip.direction,
        "revolutions": clip.revolutions,
        "frames": clip.frames,
        "phase_rms_rad": clip.phase_rms_rad,
        "frame_count": None if count is None else _mean_count([(count.rate_rad_s, count.sd_rad_s)]),
        "sd_parts": {
            "image_rad_s": clip.image_sd_rad_s,
            "timebase_rad_s": clip.timebase_sd_rad_s,
        },
        "model": list(clip.model),
        "terms": {
            term.name: {"values": numbers(term.value), "sd": numbers(term.sd), "unit": term.unit}
            for term in clip.terms
        },
        "aliases_rad_s": numbers(clip.aliases),
        "lost_frames": clip.lost_frames,
        "duplicate_frames": clip.duplicate_frames,
        "diagnosis": _phase_diagnosis(clip.diagnosis),
        "warnings": list(clip.warnings),
    }


def _phase_diagnosis(found: "PhaseDiagnosis") -> Json:
    return {
        "verdict": found.verdict,
        "name": found.name,
        "group": list(found.group),
        "says": found.says,
        "record_next": found.record_next,
        "ranking": [
            {
                "name": each.name,
                "log_evidence": number(each.log_evidence),
                "chi2_drop": number(each.chi2_drop),
                "size": numbers(each.size),
                "sd": numbers(each.sd),
                "rms_after": number(each.rms_after_rad),
                "loo_after": None,  # a turn left out says nothing that the turns beside it do not
                "blind": each.blind,
                "aliases": list(each.aliases),
            }
            for each in found.ranking
        ],
    }


# --- triads ------------------------------------------------------------------------------------


def triad_json(result: TriadResult, own: Mapping[str, OwnEffect]) -> Json:
    """One calibrated triad; ``own`` are the effects that the configuration defines."""
    calibration, comparison = result.calibration, result.comparison
    fit, parameters = calibration.fit, calibration.parameters
    misalignment_sd, bias_sd, scale_sd = parameters.sd
    found: Json = {
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
        "effects": _effects(result),
        "poses": _poses(result),
        "diagnosis": _diagnosis(result),
        "correction": correction_json(result, own),
    }
    if result.triad == "gyroscope":
        found["frame_to_accelerometer_rad"] = None
    if result.gravity is not None:
        found["gravity"] = {
            "value_m_s2": result.gravity.value_m_s2,
            "sd_m_s2": result.gravity.sd_m_s2,
            "source": result.gravity.source,
        }
    return found


def _effects(result: TriadResult) -> Json:
    """The added effects; a shape parameter stands last, with its unit after the others'."""
    model = result.calibration.fit.model
    units = {effect.name: effect.unit_for(result.triad) for effect in model.effects}
    shapes = {effect.name: effect.shape for effect in model.effects}
    found: Json = {}
    for name, (values, sd) in result.calibration.effect_values().items():
        shape = shapes[name]
        unit = units[name] if shape is None else f"{units[name]}; {shape.name}: {shape.unit}"
        found[name] = {"values": numbers(values), "sd": numbers(sd), "unit": unit}
    return found


def _poses(result: TriadResult) -> list[Json]:
    poses = result.calibration.fit.poses
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
            "force_m_s2": numbers(poses.force[i]),
            "columns": {name: number(values[i]) for name, values in poses.columns.items()},
        }
        for i, pose in enumerate(result.comparison.poses)
    ]


def _diagnosis(result: TriadResult) -> Json:
    found = result.diagnosis
    return {
        "verdict": found.verdict,
        "name": found.name,
        "group": list(found.group),
        "says": found.says,
        "record_next": found.record_next,
        "blind": list(found.blind),
        "ranking": [
            {
                "name": each.name,
                "log_evidence": number(each.log_evidence),
                "chi2_drop": number(each.chi2_drop),
                "size": numbers(each.size),
                "sd": numbers(each.sd),
                "rms_after": number(each.rms_after),
                "loo_after": number(each.loo_after),
                "blind": each.blind,
                "aliases": list(each.aliases),
            }
            for each in found.ranking
        ]
        + [_blind(name) for name in found.blind],
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


def correction_json(result: TriadResult, own: Mapping[str, OwnEffect]) -> Json:
    """What :mod:`pipeline.stored` needs to correct other logs: data sheet, model, parameters.

    Effects of the user's own are kept as they were defined; Python code by its file's name only.
    """
    correction = result.calibration.correction
    return {
        "sheet": _sheet(correction.spec),
        "model": list(correction.model.names),
        "theta": numbers(correction.theta),
        "shapes": {name: float(value) for name, value in correction.shapes.items()},
        "own_effects": {
            name: own[name].model_dump(include={"expression", "python", "per", "unit"})
            for name in correction.model.names
            if name in own
        },
    }


def _sheet(spec: TriadSpec) -> Json:
    return {
        "full_scale": number(spec.full_scale),
        "bits": spec.bits,
        "encoding": spec.encoding,
        "si_per_unit": spec.si_per_unit,
    }


def verdicts(found: Mapping[str, Any]) -> dict[str, str]:
    """Verdict of each triad in a results.json."""
    return {
        triad: found[triad]["diagnosis"]["verdict"]
        for triad in ("accelerometer", "gyroscope")
        if found[triad] is not None
    }
