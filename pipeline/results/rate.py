"""A plate setting as it stands under ``rate`` in results.json."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pipeline.results.candidate import candidate_json
from pipeline.results.json_values import Json, number, numbers
from pipeline.stages.rate import SettingRate

if TYPE_CHECKING:
    from vision.phase_track import RateHistory
    from vision.rate.diagnosis import PhaseDiagnosis
    from vision.rate.measure import RateMeasurement


def rate_json(rate: SettingRate) -> Json:
    """One plate setting; what only a clip determines is null for a stated rate."""
    filmed = bool(rate.clips)
    counted = [count for clip in rate.clips if (count := clip.cross_checks.frame_count)]
    # One clip per pose: the setting's diagnosis is that of the clip its model fits worst.
    worst = max(rate.clips, key=lambda clip: clip.fit.rms_rad, default=None)
    square = [clip.fit.rms_rad**2 for clip in rate.clips]
    return {
        "rate_rad_s": rate.rate_rad_s,
        "sd_rad_s": rate.sd_rad_s,
        "direction": rate.plate.direction,
        "revolutions": sum(clip.revolutions for clip in rate.clips) if filmed else None,
        "frames": sum(clip.frames.used for clip in rate.clips) if filmed else None,
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


def rate_history_json(history: "RateHistory", refusal: str) -> Json:
    """What is known of a clip without a constant rate: rate against time, and every angle."""
    angle = history.angle
    return {
        "refused": refusal,
        "revolutions": history.revolutions,
        "phase_noise_rad": number(history.phase_noise_rad),
        "history": {
            "time_s": numbers(history.time_s),
            "rate_rad_s": numbers(history.rate_rad_s),
        },
        "angles": {
            "frame": angle.index.tolist(),
            "time_s": numbers(angle.time_s),
            "angle_rad": numbers(angle.angle_rad),
        },
    }


def _mean_count(counts: Sequence[tuple[float, float]]) -> Json | None:
    if not counts:
        return None
    rate, sd = np.array(counts).T
    return {"rate_rad_s": float(rate.mean()), "sd_rad_s": float(np.linalg.norm(sd) / len(sd))}


def _clip(source: str, clip: "RateMeasurement") -> Json:
    count = clip.cross_checks.frame_count
    return {
        "clip": source,
        "rate_rad_s": clip.rate_rad_s,
        "sd_rad_s": clip.sd_rad_s,
        "direction": clip.direction,
        "channel": clip.channel,
        "revolutions": clip.revolutions,
        "frames": clip.frames.used,
        "phase_rms_rad": clip.fit.rms_rad,
        "frame_count": None if count is None else _mean_count([(count.rate_rad_s, count.sd_rad_s)]),
        "sd_parts": {
            "image_rad_s": clip.uncertainty.image_rad_s,
            "timebase_rad_s": clip.uncertainty.timebase_rad_s,
        },
        "model": list(clip.fit.model),
        "terms": {
            term.name: {"values": numbers(term.value), "sd": numbers(term.sd), "unit": term.unit}
            for term in clip.fit.terms
        },
        "aliases_rad_s": numbers(clip.aliases.rates_rad_s),
        "lost_frames": clip.frames.dropped,
        "duplicate_frames": clip.frames.repeated,
        "diagnosis": _phase_diagnosis(clip.diagnosis),
        "warnings": list(clip.warnings),
    }


def _phase_diagnosis(diagnosis: "PhaseDiagnosis") -> Json:
    return {
        "verdict": diagnosis.verdict,
        "name": diagnosis.name,
        "group": list(diagnosis.group),
        "says": diagnosis.explanation,
        "record_next": diagnosis.record_next,
        "ranking": [
            # A revolution left out is no test: those beside it determine it.
            candidate_json(each, each.rms_after_rad, is_blind=each.blind)
            for each in diagnosis.ranking
        ],
    }
