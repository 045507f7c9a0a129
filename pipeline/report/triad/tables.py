"""The parameters of a triad, and the budget of their uncertainties, as tables."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from calib.consistency.certificate import CertificateComparison
from calib.fit.triad.calibration import NOISE, uncertainty_budget
from calib.poses.imu_log import AXES, SI_UNIT
from pipeline.console.parameter_text import fitted_text, shown_effects
from pipeline.stages.triads import TriadResult
from pipeline.text.formatting import DISPLAY, relative, with_sd

NEGLIGIBLE = 1e-3  #: share of the total sd: less of it is written as 0

#: What each group of parameters means, for the table.
MEANING = {
    "bias": "Reading of the axis for zero input.",
    "scale": "Counts per unit of the input.",
    "misalignment": "Deviation of the angle between two axes from 90°: αx between y and z, αy "
    "between x and z, αz between x and y.",
}


@dataclass(frozen=True)
class Row:
    """One parameter: value ± sd, data sheet, difference, certificate, difference in sds."""

    name: str
    value: str
    sheet: str
    off: str
    certificate: str
    sigma: str


@dataclass(frozen=True)
class Group:
    """Parameters of one kind with their unit and meaning."""

    name: str
    unit: str
    meaning: str
    rows: tuple[Row, ...]


def parameter_groups(
    result: TriadResult, certificate: CertificateComparison | None
) -> tuple[Group, ...]:
    """Bias, scale and misalignment, then every added effect."""
    return (*_base_groups(result, certificate), *_effect_groups(result), *_frame(result))


def budget_rows(result: TriadResult) -> tuple[tuple[str, str, str, str], ...]:
    """Cause, and the sds it gives to misalignment, bias and scale: means over the axes."""
    scale = result.calibration.parameters.scale_counts_per_unit
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
            _known(f"{bias:.2g} counts"),
            _known(relative(gain)),
        ))  # fmt: skip
    return tuple(rows)


def _known(text: str) -> str:
    """A dash for the sd of a parameter that was not fitted."""
    return "–" if "nan" in text else text


def _base_groups(
    result: TriadResult, certificate: CertificateComparison | None
) -> Iterator[Group]:
    parameters, spec = result.calibration.parameters, result.calibration.spec
    unit, factor = DISPLAY[result.triad]
    sd_misalignment, sd_bias, sd_scale = parameters.sd
    k = parameters.scale_counts_per_unit
    off = (parameters.bias_counts - spec.nominal_bias_counts) / k * factor
    yield Group("bias", "counts", MEANING["bias"], tuple(
        Row(axis, fitted_text(parameters.bias_counts[j], sd_bias[j]),
            f"{spec.nominal_bias_counts:g}", f"{off[j]:+.4g} {unit}",
            *_certified(certificate, "bias", j))
        for j, axis in enumerate(AXES)))  # fmt: skip
    sheet = 1 / spec.nominal_scale
    yield Group("scale", f"counts per {SI_UNIT[result.triad]}", MEANING["scale"], tuple(
        Row(axis, fitted_text(k[j], sd_scale[j]), f"{sheet:.6g}",
            f"{100 * (k[j] / sheet - 1):+.2f} %", *_certified(certificate, "scale", j))
        for j, axis in enumerate(AXES)))  # fmt: skip
    alpha = parameters.misalignment_rad
    yield Group("misalignment", "rad", MEANING["misalignment"], tuple(
        Row(f"α{axis}", fitted_text(alpha[j], sd_misalignment[j]), "0",
            f"{math.degrees(alpha[j]):+.3f}°", *_certified(certificate, "misalignment", j))
        for j, axis in enumerate(AXES)))  # fmt: skip


def _effect_groups(result: TriadResult) -> Iterator[Group]:
    for shown in shown_effects(result):
        effect = shown.effect
        rows = [Row(name, value, "0", "", "", "")
                for name, value in zip(effect.parameters, shown.values, strict=True)]
        if effect.shape is not None and shown.shape is not None:
            label = f"{effect.shape.name} [{effect.shape.unit}]"
            rows.append(Row(label, shown.shape, "", "", "", ""))
        yield Group(effect.name, shown.unit, effect.physics, tuple(rows))


def _frame(result: TriadResult) -> Iterator[Group]:
    frame = result.frame
    if frame is None:
        return
    yield Group(
        "to the accelerometer", "rad",
        "Rotation of the axes of the gyroscope relative to those of the accelerometer. It can be "
        "determined only if both were logged together on the turning plate.",
        tuple(
            Row(axis, with_sd(angle, sd), "0", f"{math.degrees(angle):+.3f}°", "", "")
            for axis, angle, sd in zip(AXES, frame.angles_rad, frame.sd_rad, strict=True)
        ),
    )


def _certified(
    certificate: CertificateComparison | None, name: str, j: int
) -> tuple[str, str]:
    """The certificate's value and the difference in sds; blank where it states none."""
    group = next((g for g in certificate.groups if g.name == name), None) if certificate else None
    if group is None:
        return "", ""
    value = with_sd(float(group.certificate[j]), float(group.certificate_sd[j]))
    sigma = float(group.sigma[j])
    return value, f"{sigma:+.1f}" if np.isfinite(sigma) else ""
