"""The section ``rate`` of results.json."""

from typing import Literal

from pydantic import Field

from pipeline.results.schema.types import (
    Count,
    Direction,
    MaybeNumber,
    MaybeSd,
    NotNegative,
    Part,
    Text,
    means,
)


class CandidateResult(Part):
    """A term that a phase track may lack, or an effect that a triad may lack."""

    name: Text = means("term or effect")
    log_evidence: MaybeNumber = means("log of its evidence against the present model")
    chi2_drop: MaybeNumber = means("reduction of chi² with it")
    size: list[MaybeNumber] = means(
        "its parameters, each in its unit; a shape parameter comes last")
    sd: list[MaybeSd] = means("their sds")
    rms_after: MaybeSd = means("RMS residual with it, rad; of a triad in SI units")
    loo_after: MaybeSd = means("leave-one-out error with it, in the same unit; null where none is")
    blind: bool = means("these data cannot determine it")
    aliases: list[Text] = means("terms or effects with the same signature in these data")


class DiagnosisResult(Part):
    """What the model of a phase track or of a triad misses."""

    verdict: Text = means("code")
    name: Text | None = means("the term or effect that is missing")
    group: list[Text] = means("it, and those with the same signature")
    in_words: Text = means("the verdict in words", alias="says")
    record_next: Text | None = means("the measurement to record next")
    ranking: list[CandidateResult] = means("every candidate, the most likely first")


class CountedRate(Part):
    """A rate by counting frames per turn (Angrisano et al.)."""

    rate_rad_s: NotNegative = means("rate")
    sd_rad_s: NotNegative = means("its sd")


class RateSds(Part):
    """Contributions to the sd of a rate."""

    image_rad_s: MaybeSd = means("noise of the images")
    timebase_rad_s: MaybeSd = means("clock of the camera")


class ClockResult(Part):
    """The measured clock of a camera."""

    camera: Text = means("its name")
    fast_ppm: MaybeNumber = means("it runs fast by so much; the rate is corrected for that")
    sd_ppm: MaybeSd = means("sd of that when the clips were filmed")


class FittedPart(Part):
    """A fitted term of a phase track, or an effect."""

    values: list[MaybeNumber] = means("parameters; a shape parameter comes last")
    sd: list[MaybeSd] = means("sds")
    unit: Text = means("unit; that of a shape parameter comes last")


class ClipRate(Part):
    """One clip of a plate setting."""

    clip: Text = means("the file")
    rate_rad_s: NotNegative = means("rate")
    sd_rad_s: NotNegative = means("its sd")
    direction: Direction = means("sense of rotation as filmed")
    channel: Text = means("luma, or the colour that was tracked")
    revolutions: NotNegative = means("turns in the clip")
    frames: Count = means("frames used")
    phase_rms_rad: NotNegative = means("residual of the phase")
    frame_count: CountedRate | None = means("the same by counting frames")
    sd_parts: RateSds = means("contributions to the sd")
    model: list[Text] = means("terms of the model")
    terms: dict[str, FittedPart] = means("fitted terms besides the rate")
    aliases_rad_s: list[MaybeNumber] = means(
        "rates that give the same frames, the chosen one first; negative is clockwise")
    alias_choice: Text = Field(default="", description="why that one is chosen")
    lost_frames: Count = means("dropped frames")
    duplicate_frames: Count = means("repeated frames")
    diagnosis: DiagnosisResult = means("what the model misses")
    warnings: list[Text] = means("warnings in words")


class RateResult(Part):
    """One plate setting."""

    rate_rad_s: NotNegative = means("rate of the plate")
    sd_rad_s: NotNegative = means("its sd, all parts together")
    direction: Direction | None = means(
        "sense of rotation as filmed; of a stated rate cw where it is negative, else null")
    revolutions: MaybeSd = means("turns in all clips")
    frames: Count | None = means("frames used")
    phase_rms_rad: MaybeSd = means("residual of the phase")
    frame_count: CountedRate | None = means("the same by counting frames")
    sd_parts: RateSds = means("contributions to the sd")
    clock: ClockResult | None = Field(
        default=None, description="the clock of the camera, where `pipeline clock` measured it")
    source: Literal["video", "stated"] = means("where the rate comes from")
    diagnosis: DiagnosisResult | None = means("of the clip that the model fits worst")
    clips: list[ClipRate] = means("every clip")
