"""The sections ``accelerometer`` and ``gyroscope`` of results.json."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from calib.diagnosis.verdict.explanation import Standing
from calib.poses.data_sheet import Encoding
from pipeline.results.schema.rate import CandidateResult, FittedPart
from pipeline.results.schema.types import (
    LARGEST,
    Count,
    MaybeNumber,
    MaybeSd,
    NotNegative,
    Number,
    Part,
    Positive,
    Probability,
    Text,
    Three,
    ThreeOrNull,
    ThreeSds,
    means,
)

SMALLEST_SCALE = 1e-12  #: counts per unit; a scale of nothing has no inverse


class Parameters(Part):
    """The nine parameters of Angrisano et al. eq. (3), or their sds."""

    misalignment_rad: Three = means("αx, αy, αz")
    bias_counts: Three = means("bias b")
    scale_counts_per_unit: Three = means("scale factors 1/k, counts per m/s² or rad/s")


class ParameterSds(Part):
    """Sds of the nine parameters; null for those that were not fitted."""

    misalignment_rad: ThreeSds = means("of the misalignment")
    bias_counts: ThreeSds = means("of the bias")
    scale_counts_per_unit: ThreeSds = means("of the scale factors")


class PoseResult(Part):
    """One pose."""

    label: Text = means("its log")
    run: Text = means("its plate setting")
    residual: Number = means(
        "corrected magnitude less the reference, SI; of a pose with several rows their length")
    sd: NotNegative = means("its sd")
    left_out: MaybeNumber = means("the same, predicted from all other poses")
    reference: Number = means("gravity or the rate of the plate, SI")
    time_s: MaybeNumber = means("time by the clock of the log")
    reading: ThreeOrNull = means("mean reading in SI units by the data sheet")
    reading_sd: ThreeSds = means("its sd")
    corrected: ThreeOrNull = means("the reading corrected by the calibration")
    force_m_s2: ThreeOrNull | None = means(
        "specific force of the pose by the accelerometer's calibration; null in its own section",
        default=None)
    spin_rad_s: MaybeNumber = means("rate of the plate, counter-clockwise positive", default=None)
    columns: dict[str, MaybeNumber] = means("mean of every further column of the log")


class ExcludedResult(Part):
    """A pose that the configuration excludes."""

    label: Text = means("its log")
    run: Text = means("its plate setting")
    residual: MaybeNumber = means("residual by the fit without it, SI; null where it is no pose")
    sd: MaybeSd = means("its sd")
    cut_off_counts: ThreeOrNull | None = means(
        "level at which each axis is cut off and beyond which no log goes; null where it is not",
        default=None)


class PredictionParts(Part):
    """What a prediction is made of: root mean squares over all directions, SI."""

    poses: MaybeSd = means("by what the poses determine")
    unseen: dict[str, MaybeSd] = means(
        "by each effect that the poses cannot see, if the sensor is typical")
    untold: dict[str, MaybeSd] = means(
        "by each effect of the model that the samples of another log do not tell",
        default_factory=dict)
    open: MaybeSd = means(
        "by what may be missing and what the model's effects stand for, weighed by their "
        "probabilities, by formulas that may be off between the values that the poses saw, and by "
        "noise from pose to pose")


class PredictionResult(Part):
    """What a corrected magnitude will err by on the next log, 1 sd, SI."""

    sd_median: MaybeSd = means("median over all directions")
    sd_worst: MaybeSd = means("in the worst direction")
    worst_direction: ThreeOrNull = means("that direction")
    parts: PredictionParts | None = means("what it is made of", default=None)


class EffectResult(FittedPart):
    """An effect that was added to the nine parameters."""

    stands_for: list[Text] = means(
        "effects that these poses do not tell from it", default_factory=list)


class InclusionResult(Part):
    """A class of effects with the same signature in these data."""

    class_: Text = means("its name", alias="class")
    members: list[Text] = means("its effects")
    probability: Probability = means("that one of them is there")


class TriadDiagnosis(Part):
    """What the model of a triad misses."""

    verdict: Text = means("code")
    name: Text | None = means("the effect that is missing")
    names: list[Text] = means("all effects that are named as missing")
    group: list[Text] = means("it, and those with the same signature")
    inclusion: list[InclusionResult] = means("probability of every class of effects")
    in_words: Text = means("the verdict in words", alias="says")
    standing: Standing | None = means("whether the calibration is good, open or to act on",
                                      default=None)
    short: Text | None = means("the verdict in a few words", default=None)
    record_next: Text | None = means("the measurement to record next")
    blind: list[Text] = means("effects that these data cannot determine")
    ranking: list[CandidateResult] = means("every candidate, the most likely first")


class Sheet(Part):
    """The data sheet that turns counts into nominal SI readings."""

    full_scale: Annotated[float, Field(gt=0, le=LARGEST)] | None = means(
        "largest reading, SI; null for logs in physical units")
    bits: Annotated[int, Field(ge=0, le=32)] = means(
        "width of the converter; 0 for logs in physical units")
    encoding: Encoding = means("encoding of the counts")
    si_per_unit: Annotated[float, Field(gt=0, le=LARGEST)] = means("SI units per logged unit")

    @model_validator(mode="after")
    def _fits_together(self) -> "Sheet":
        if (self.encoding == "si") != (self.bits == 0) or (self.bits and self.full_scale is None):
            raise ValueError(f"{self.bits} bits, full scale {self.full_scale} and {self.encoding} "
                             "do not fit together")
        return self


class UserEffect(Part):
    """A user-defined effect as the configuration had it."""

    expression: Text | None = means("expression")
    python: Text | None = means("FILE.py:FUNCTION", default=None)
    per: Literal["axis", "common", "matrix", "reference"] = means("one parameter per what")
    unit: Text = means("unit of the parameters")
    shapes: dict[str, Annotated[tuple[str, float, float], Field(strict=False)]] | None = means(
        "unit and bounds of its shape parameter", default=None)
    python_sha256: Text | None = means("hash of the Python file", default=None)


class CorrectionResult(Part):
    """What `apply` and `export` need."""

    sheet: Sheet = means("data sheet")
    model: list[Text] = means("effects of the model")
    theta: list[Number] = means("their parameters in SI units, in the order of the model")
    shapes: dict[str, Number] = means("shape parameters by effect")
    own_effects: dict[str, UserEffect] = means("user-defined effects of the model")


class GravityResult(Part):
    """The reference of the accelerometer."""

    value_m_s2: Annotated[float, Field(gt=0, le=LARGEST)] = means("gravity")
    sd_m_s2: NotNegative = means("its sd; 0 if it was stated without one")
    source: Text = means("where it comes from")


class CertificateGroup(Part):
    """A group of parameters beside the factory certificate."""

    unit: Text = means("unit")
    certificate: list[MaybeNumber] = means("values of the certificate")
    certificate_sd: list[MaybeNumber] = means("their sds, from their last digits")
    difference: list[MaybeNumber] = means("estimate less certificate")
    sigma: list[MaybeNumber] = means("difference over its sd")
    per_cent: list[MaybeNumber] = means("difference in per cent")


class TriadSection(Part):
    """A calibrated triad."""

    model: list[Text] = means("effects of the model", min_length=1)
    n_poses: Count = means("poses")
    chi2: NotNegative = means("chi² of the fit")
    dof: Positive = means("degrees of freedom")
    p_value: Probability = means("p-value of chi²")
    residual_rms: NotNegative = means("RMS residual, SI")
    loo_rms: NotNegative = means("RMS of predictions of each pose from all others, SI")
    iterations: Count = means("steps of the solver")
    parameters: Parameters = means("the nine parameters")
    sd: ParameterSds = means("their sds")
    sd_widened_by: NotNegative = means(
        "these sds over those of the noise alone: they are averaged over what may be missing")
    sd_parts: dict[str, ParameterSds] = means("contributions to the sds, by cause")
    sd_parts_if_typical: dict[str, ParameterSds] = means(
        "sds by effects that these poses cannot determine, if the sensor is typical; not in `sd`")
    effects: dict[str, EffectResult] = means("added effects")
    worst_poses: list[Text] = means("poses with the largest residuals")
    misfit_follows: Text | None = means("the quantity that the misfit follows")
    poses: list[PoseResult] = means("every pose", min_length=1)
    excluded: list[ExcludedResult] = means(
        "poses that the configuration excludes", default_factory=list)
    prediction: PredictionResult | None = means("error to expect of the next log")
    diagnosis: TriadDiagnosis = means("what the model misses")
    correction: CorrectionResult = means("what `apply` and `export` need")

    @property
    def error_parts(self) -> PredictionParts:
        """What the expected error is made of; nothing is known in results of earlier versions."""
        parts = None if self.prediction is None else self.prediction.parts
        return parts or PredictionParts(poses=None, unseen={}, open=None)

    @model_validator(mode="after")
    def _is_possible(self) -> "TriadSection":
        if min(map(abs, self.parameters.scale_counts_per_unit)) < SMALLEST_SCALE:
            raise ValueError("a scale factor is zero")
        if self.correction.model != self.model:
            raise ValueError("model and correction.model are not the same")
        if unknown := [name for name in self.effects if name not in self.model]:
            raise ValueError(f"effects.{unknown[0]} is not in the model")
        return self


class AccelerometerResult(TriadSection):
    """The accelerometer."""

    gravity: GravityResult = means("the reference")
    certificate: dict[str, CertificateGroup] | None = means(
        "the factory certificate beside the estimate", default=None)


class ReferenceResult(Part):
    """The magnitude that a further triad is calibrated against."""

    value: Annotated[float, Field(gt=0, le=LARGEST)] = means("magnitude, in the triad's unit")
    sd: NotNegative = means("its sd")
    unit: Text = means("that unit")


class FurtherResult(TriadSection):
    """A further triad."""

    reference: ReferenceResult = means("the reference")


class GyroscopeResult(TriadSection):
    """The gyroscope."""

    frame_to_accelerometer_rad: Three | None = means(
        "rotation vector to the accelerometer's frame; null where the poses do not show it",
        default=None)
    frame_sd_rad: ThreeSds | None = means("its sd", default=None)
    lever_m: ThreeOrNull | None = means("from the axis of the plate to the sensor", default=None)
    certificate: dict[str, CertificateGroup] | None = means(
        "the factory certificate beside the estimate", default=None)
