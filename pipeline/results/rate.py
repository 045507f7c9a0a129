"""A plate setting under ``rate`` in results.json, and the angles of a clip as CSV."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pipeline.results.json_values import Json, number, numbers
from pipeline.results.schema import rate as schema
from pipeline.stages.rate import SettingRate

if TYPE_CHECKING:
    from vision.errors import RateRefused
    from vision.phase_track import RateHistory
    from vision.rate.cross_checks import FrameCount
    from vision.rate.diagnosis import PhaseDiagnosis
    from vision.rate.measure import RateMeasurement


def rate_section(rate: SettingRate) -> schema.RateResult:
    """One plate setting; null for quantities of a clip if the rate is stated."""
    filmed = bool(rate.clips)
    # One clip per pose: the setting's diagnosis is that of the clip its model fits worst.
    worst = max(rate.clips, key=lambda clip: clip.fit.rms_rad, default=None)
    square = [clip.fit.rms_rad**2 for clip in rate.clips]
    return schema.RateResult.of(
        rate,
        direction=rate.plate.direction,
        revolutions=sum(clip.revolutions for clip in rate.clips) if filmed else None,
        frames=sum(clip.frames.used for clip in rate.clips) if filmed else None,
        phase_rms_rad=math.sqrt(sum(square) / len(square)) if filmed else None,
        frame_count=_mean_count([clip.cross_checks.frame_count for clip in rate.clips]),
        sd_parts=schema.RateSds.of(
            image_rad_s=rate.image_sd_rad_s if filmed else None,
            timebase_rad_s=rate.timebase_sd_rad_s if filmed else None,
        ),
        clock=_clock(rate),
        source="video" if filmed else "stated",
        diagnosis=None if worst is None else _phase_diagnosis(worst.diagnosis),
        clips=[_clip(*one) for one in zip(rate.sources, rate.clips, strict=True)],
    )


def refusal_json(refused: "RateRefused") -> Json:
    """Every refused clip as the same object; null for quantities that it does not show.

    ``repeats`` is the period after which the picture repeats; ``history`` the rate against time,
    and ``angles`` all angles, of a plate that was tracked.
    """
    history, returns = refused.history, refused.returns
    return {
        "refused": str(refused),
        "repeats": None if returns is None else {
            "period_s": returns.period_s,
            "sd_s": returns.sd_s,
            "rate_rad_s": returns.rate_rad_s,
            "sd_rad_s": returns.rate_rad_s * returns.sd_s / returns.period_s,
        },
        "revolutions": None if history is None else history.revolutions,
        "phase_noise_rad": None if history is None else number(history.phase_noise_rad),
        "history": None if history is None else {
            "time_s": numbers(history.time_s),
            "rate_rad_s": numbers(history.rate_rad_s),
        },
        "angles": None if history is None else {
            "frame": history.angle.index.tolist(),
            "time_s": numbers(history.angle.time_s),
            "angle_rad": numbers(history.angle.angle_rad),
        },
    }


def _clock(rate: SettingRate) -> schema.ClockResult | None:
    """The measured clock of the camera, where the clips were filmed with one."""
    base = rate.timebase
    if base is None or not base.camera:
        return None
    return schema.ClockResult(camera=base.camera, fast_ppm=base.fast_ppm, sd_ppm=base.ppm)


def _mean_count(counts: "Sequence[FrameCount | None]") -> schema.CountedRate | None:
    counted = [(count.rate_rad_s, count.sd_rad_s) for count in counts if count is not None]
    if not counted:
        return None
    rate, sd = np.array(counted).T
    return schema.CountedRate.of(rate_rad_s=rate.mean(), sd_rad_s=np.linalg.norm(sd) / len(sd))


def _clip(source: str, clip: "RateMeasurement") -> schema.ClipRate:
    return schema.ClipRate.of(
        clip,
        clip=source,
        frames=clip.frames.used,
        phase_rms_rad=clip.fit.rms_rad,
        frame_count=_mean_count([clip.cross_checks.frame_count]),
        sd_parts=schema.RateSds.of(clip.uncertainty),
        model=clip.fit.model,
        terms={term.name: schema.FittedPart.of(term, values=term.value) for term in clip.fit.terms},
        aliases_rad_s=clip.aliases.rates_rad_s,
        alias_choice=clip.aliases.reason,
        lost_frames=clip.frames.dropped,
        duplicate_frames=clip.frames.repeated,
        diagnosis=_phase_diagnosis(clip.diagnosis),
    )


def _phase_diagnosis(diagnosis: "PhaseDiagnosis") -> schema.DiagnosisResult:
    ranking = [  # leaving a revolution out tests nothing: its neighbours determine it
        schema.CandidateResult.of(one, rms_after=one.rms_after_rad, loo_after=None)
        for one in diagnosis.ranking]
    whole = " ".join(filter(None, (diagnosis.explanation, diagnosis.together)))
    return schema.DiagnosisResult.of(diagnosis, says=whole, ranking=ranking)


ANGLES_HEAD = "frame,time_s,angle_rad,residual_rad,used"


def angles_csv(history: "RateHistory", rate: "RateMeasurement | None" = None) -> str:
    """A row for each frame that shows the plate.

    Columns are the number of the frame, its time stamp, the angle accumulated from turn to turn,
    its residual from the stated model, and whether the rate uses it. If no constant rate was found,
    ``rate`` is None, and the residual is empty.
    """
    angle = history.angle
    if rate is None:
        rest = [",0"] * len(angle.time_s)
    else:
        rest = [f"{residual:.9g},{int(used)}" for residual, used in zip(
            rate.fit.residual_rad, rate.fit.used, strict=True)]
    rows = [f"{frame},{time:.6f},{turned:.9g},{more}" for frame, time, turned, more in zip(
        np.asarray(angle.index), angle.time_s, angle.angle_rad, rest, strict=True)]
    return "\n".join([ANGLES_HEAD, *rows]) + "\n"
