"""Parameters for the terminal: fitted, with a certificate, and of the mounting."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from calib.consistency.certificate import Compared
from calib.effects.effect import Effect
from calib.effects.units import display_unit
from calib.fit.triad.calibration import TriadCalibration
from calib.mounting.mounting import Mounting
from calib.poses.attitudes import direction_name
from calib.poses.imu_log import AXES
from calib.rounding import two_digits
from pipeline.results.json_values import unit_of
from pipeline.results.names import PARAMETERS
from pipeline.stages.triads import TriadResult
from pipeline.text.formatting import DISPLAY, not_measured, with_sd
from pipeline.text.tables import table_lines

SINCE_FIRST_SAMPLE = "s after the first sample"  #: unit of a time that is searched, not fitted


@dataclass(frozen=True)
class ShownEffect:
    """An added effect in its usual units.

    Parameters
    ----------
    effect : Effect
    unit : str
        Of its linear parameters.
    values : tuple of str
        Each linear parameter ± sd, in the order of ``effect.parameters``.
    shape : str or None
        Its shape parameter ± sd, in the unit of ``effect.shape``; None where it has none.
    """

    effect: Effect
    unit: str
    values: tuple[str, ...]
    shape: str | None


def shown_effects(calibration: TriadCalibration) -> Iterator[ShownEffect]:
    """The effects added to bias, scale and misalignment."""
    model = {effect.name: effect for effect in calibration.fit.model.effects}
    for name, (values, sds) in calibration.effect_values().items():
        effect = model[name]
        linear = len(effect.parameters)
        unit, factor = display_unit(effect.unit_for(calibration.triad), values[:linear])
        texts = tuple(_size(value * factor, sd * factor)
                      for value, sd in zip(values[:linear], sds[:linear], strict=True))
        shape = None
        if effect.shape is not None:
            shape = (_size if effect.shape.is_fitted else with_sd)(values[-1], sds[-1])
        yield ShownEffect(effect, unit, texts, shape)


def _size(value: float, sd: float) -> str:
    return with_sd(value, sd) if math.isfinite(sd) else f"{value:.3g} (not determined alone)"


def fitted_text(value: float, sd: float) -> str:
    """One of the nine parameters ± sd; the data sheet's value where it was not fitted."""
    return with_sd(value, sd) if math.isfinite(sd) else f"{value + 0.0:.6g} (not fitted)"


def parameter_lines(result: TriadResult) -> list[str]:
    """The parameters ± sd of a triad as an aligned table."""
    rows = [[result.triad, *AXES]]
    nine, spec = result.calibration.parameters, result.calibration.spec
    rows += [[f"  {key.split('_')[0]} [{unit_of(key, result.triad, spec)}]",
              *(fitted_text(v, s) for v, s in zip(getattr(nine, key), sd, strict=True))]
             for key, sd in zip(PARAMETERS, nine.sd, strict=True)]
    rows += [row for shown in shown_effects(result.calibration) for row in effect_rows(shown)]
    if result.frame is not None:
        angles = zip(result.frame.angles_rad, result.frame.sd_rad, strict=True)
        rows.append(["  to accelerometer [rad]", *(with_sd(v, s) for v, s in angles)])
    lines = table_lines(rows, indent="")
    if result.prediction is not None:
        lines.append(f"  {prediction_text(result)}")
    if result.calibration.is_widened:
        lines.append(
            f"  the sds contain what may be missing, which makes them "
            f"{two_digits(result.calibration.widening)} times as large"
        )
    return lines


def effect_rows(shown: ShownEffect) -> list[list[str]]:
    """Name with unit and values of an added effect, three in a row; a shape parameter alone."""
    effect, linear = shown.effect, len(shown.values)
    rows: list[list[str]] = []
    for i in range(0, linear, len(AXES)):
        axis = f" {effect.parameters[i][0]}" if linear > len(AXES) else ""
        rows.append([f"  {effect.name}{axis} [{shown.unit}]", *shown.values[i : i + len(AXES)]])
    if effect.shape is not None and shown.shape is not None:
        searched = not effect.shape.is_fitted and effect.shape.unit == "s"
        unit = SINCE_FIRST_SAMPLE if searched else effect.shape.unit
        rows.append([f"  {effect.name} {effect.shape.name} [{unit}]", shown.shape])
    return rows


def prediction_text(result: TriadResult) -> str:
    """Expected error of the calibration on the next log, in one clause."""
    prediction = result.prediction
    assert prediction is not None
    unit, factor = DISPLAY[result.triad]
    return (
        f"corrected magnitudes err by {two_digits(prediction.sd_median * factor)} {unit} (1 sd, "
        f"median over all directions), by {two_digits(prediction.sd_worst * factor)} {unit} at "
        f"worst ({direction_name(prediction.worst_direction, result.triad)})"
        + not_measured(result.triad, prediction.by_poses, prediction.by_unseen,
                       prediction.by_untold)
    )


def certificate_lines(comparison: Mapping[str, Compared]) -> list[str]:
    """An aligned table: estimate, certificate, difference in sds and per cent."""
    rows = [["", "", "estimate", "certificate", "difference", "in sd", "%"]]
    for group in comparison.values():
        for j, axis in enumerate(AXES):
            rows.append(
                [
                    f"{group.name} [{group.unit}]" if j == 0 else "",
                    axis,
                    with_sd(float(group.estimate[j]), float(group.sd[j])),
                    with_sd(float(group.certificate[j]), float(group.certificate_sd[j])),
                    f"{group.difference[j]:+.4g}",
                    f"{group.sigma[j]:+.1f}",
                    "" if np.isnan(group.per_cent[j]) else f"{group.per_cent[j]:+.3f}",
                ]
            )
    return table_lines(rows)


def mounting_parts(mounting: Mounting) -> Iterator[str]:
    """``roll 30.65 ± 0.01°`` and so on, for each measured angle."""
    roll_sd, pitch_sd = mounting.sd_rad
    yield f"roll {_degrees(mounting.roll_rad, roll_sd)}"
    yield f"pitch {_degrees(mounting.pitch_rad, pitch_sd)}"
    if mounting.yaw:
        yield f"yaw {_degrees(mounting.yaw.yaw_rad, mounting.yaw.sd_rad)}"
    if mounting.slope:
        slope = mounting.slope
        for axis, rise, sd in zip("xy", slope.rise_rad, slope.sd_rad, strict=True):
            yield f"floor rises along {axis} by {_degrees(float(rise), float(sd))}"


def mounting_text(mounting: Mounting) -> str:
    """One line for the terminal and the report."""
    return f"{', '.join(mounting_parts(mounting))} (order {mounting.order})"


def _degrees(angle_rad: float, sd_rad: float) -> str:
    return f"{with_sd(math.degrees(angle_rad), math.degrees(sd_rad))}°"
