"""Tables of a triad: its parameters, its poses, and the candidates of its diagnosis."""

import math
from collections.abc import Iterator

import numpy as np

from calib.diagnosis.verdict.ranking import Candidate
from calib.diagnosis.verdict.wording import odds_in_words, readable
from calib.effects.catalogue import EFFECTS
from calib.effects.typical import largest_for
from calib.effects.units import display_unit
from calib.fit.triad.calibration import NOISE, uncertainty_budget
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import AXES, Triad
from calib.rounding import in_digits
from pipeline.console.parameter_text import fitted_text, shown_effects
from pipeline.drawings.charts import tick_text
from pipeline.results.json_values import Json, logged_unit, unit_of
from pipeline.results.names import PARAMETERS
from pipeline.stages.triads import TriadResult
from pipeline.text.formatting import DISPLAY, relative, with_minus_signs, with_sd

NEGLIGIBLE = 1e-3  #: share of the total sd: smaller parts are written as 0

#: Meaning of each group of parameters, for the table.
MEANING = {
    "bias": "Reading of the axis for zero input.",
    "scale": "Logged number per unit of the input.",
    "misalignment": "Deviation of the angle between two axes from 90°: αx between y and z, αy "
    "between x and z, αz between x and y.",
}


Row = tuple[str, str, str, str, str, str]
"""One parameter: name, value ± sd, data sheet, difference, certificate, difference in sds."""
Group = tuple[str, str, str, list[Row]]
"""Parameters of one kind: their name, unit, meaning and rows."""


def parameter_groups(result: TriadResult) -> Iterator[Group]:
    """Bias, scale and misalignment, then every added effect, and the rotation of the frame."""
    yield from _base_groups(result)
    yield from _effect_groups(result)
    if (frame := result.frame) is not None:
        yield (
            "to the accelerometer", "rad",
            "Rotation of the axes of the gyroscope relative to those of the accelerometer. It can "
            "be determined only if both were logged together on the turning plate.",
            [(axis, with_sd(angle, sd), "0", f"{math.degrees(angle):+.3f}°", "", "")
             for axis, angle, sd in zip(AXES, frame.angles_rad, frame.sd_rad, strict=True)],
        )


def budget_rows(result: TriadResult) -> tuple[tuple[str, str, str, str], ...]:
    """Cause, and the sds it gives to misalignment, bias and scale: means over the axes."""
    scale = result.calibration.parameters.scale_counts_per_unit
    logged = logged_unit(result.triad, result.calibration.spec)
    budget = uncertainty_budget(result.calibration)
    unseen = {f"{name}, if your sensor is typical": sds for name, sds in result.unseen.items()}
    causes = {**budget, **unseen}
    means = np.array([
        np.sqrt(np.mean([sds[0] ** 2, sds[1] ** 2, (sds[2] / scale) ** 2], axis=1))
        for sds in causes.values()
    ])
    total = np.sqrt((means[: len(budget)] ** 2).sum(axis=0))
    means = np.where(means < NEGLIGIBLE * total, 0.0, means)
    rows = []
    for cause, (misalignment, bias, gain) in zip(causes, means, strict=True):
        widened = cause == NOISE and result.calibration.is_widened
        label = "noise and what may be missing" if widened else cause
        rows.append((
            label,
            _known(f"{math.degrees(misalignment):.2g}°"),
            _known(f"{bias:.2g} {logged}"),
            _known(relative(gain)),
        ))  # fmt: skip
    return tuple(rows)


def _known(text: str) -> str:
    """A dash for the sd of a parameter that was not fitted."""
    return "–" if "nan" in text else text


def _base_groups(result: TriadResult) -> Iterator[Group]:
    parameters, spec = result.calibration.parameters, result.calibration.spec
    unit, factor = DISPLAY[result.triad]
    k, sheet = parameters.scale_counts_per_unit, 1 / spec.nominal_scale
    zero = (parameters.bias_counts - spec.nominal_bias_counts) / k * factor
    sds = dict(zip(PARAMETERS, parameters.sd, strict=True))
    for name, key, mark, of_sheet, off in (
        ("bias", "bias_counts", "", f"{spec.nominal_bias_counts:g}",
         [f"{one:+.4g} {unit}" for one in zero]),
        ("scale", "scale_counts_per_unit", "", f"{sheet:.6g}",
         [f"{100 * one:+.2f} %" for one in k / sheet - 1]),
        ("misalignment", "misalignment_rad", "α", "0",
         [f"{one:+.3f}°" for one in np.degrees(parameters.misalignment_rad)]),
    ):
        values = zip(AXES, getattr(parameters, key), sds[key], off, strict=True)
        yield name, unit_of(key, result.triad, spec), MEANING[name], [
            (f"{mark}{axis}", fitted_text(value, sd), of_sheet,
             text if math.isfinite(sd) else "–", *_certified(result, name, j))
            for j, (axis, value, sd, text) in enumerate(values)]


def _effect_groups(result: TriadResult) -> Iterator[Group]:
    for shown in shown_effects(result.calibration):
        effect = shown.effect
        rows = [(name, value, "0", "", "", "")
                for name, value in zip(effect.parameters, shown.values, strict=True)]
        if effect.shape is not None and shown.shape is not None:
            label = f"{effect.shape.name} [{effect.shape.unit}]"
            rows.append((label, shown.shape, "", "", "", ""))
        yield effect.name, shown.unit, effect.physics, rows


def _certified(result: TriadResult, name: str, j: int) -> tuple[str, str]:
    """The certificate's value and the difference in sds; blank where it states none."""
    group = result.certificate.get(name) if result.certificate else None
    if group is None:
        return "", ""
    value = with_sd(float(group.certificate[j]), float(group.certificate_sd[j]))
    sigma = float(group.sigma[j])
    return value, f"{sigma:+.1f}" if np.isfinite(sigma) else ""


RANKED = 8  #: rows that are always shown; the others unfold
BEYOND_PARTS = "larger than any part has"
LEAST_SHARE = 1e-3  #: share of chi²: smaller drops are written as none


def candidate_rows(result: TriadResult) -> list[Json]:
    """Result of adding each hypothesis of the ranking alone, the most probable first."""
    return [_row(result, one) for one in result.diagnosis.ranking if one.kind != "noise"]


def _row(result: TriadResult, candidate: Candidate) -> Json:
    _, factor = DISPLAY[result.triad]
    rms, loo = (("–" if math.isnan(error) else in_digits(error * factor, 3))
                for error in (candidate.rms_after, candidate.loo_after))
    share = candidate.chi2_drop / max(result.calibration.fit.chi2, NO_LENGTH)
    name = candidate.name
    if candidate.kind != "listed":
        name = readable(name, candidate.follows)
    drop = tick_text(float(f"{candidate.chi2_drop:.3g}"))
    classes = (one.members for one in result.diagnosis.inclusion if name in one.members)
    shared = len(next(classes, ()))
    odds = odds_in_words(candidate.probability)
    return {
        "name": name, "probability": f"one of {shared}: {odds}" if shared > 1 else odds,
        "chi2_drop": f"{drop} ({100 * share:.0f} %)" if share > LEAST_SHARE else "–",
        "size": _size(candidate, result.triad), "rms": rms, "loo": loo,
        "worse": bool(candidate.loo_after > result.comparison.loo_rms),
        "aliases": ", ".join(candidate.aliases)}


def _size(candidate: Candidate, triad: Triad) -> str:
    """The largest parameter with its sd, in the units of a data sheet; words where no part has it.
    """
    if not candidate.size.size:
        return ""
    largest = int(np.abs(candidate.size).argmax())
    effect = EFFECTS.get(candidate.name)
    if effect is not None and abs(candidate.size[largest]) > largest_for(
            triad, effect.page.typical.values()):
        return BEYOND_PARTS
    unit, factor = display_unit(candidate.unit, candidate.size)
    value = with_sd(float(candidate.size[largest]) * factor, float(candidate.sd[largest]) * factor)
    return with_minus_signs(f"{value} {unit}")
