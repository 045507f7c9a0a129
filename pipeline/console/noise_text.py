"""The noise of a sensor in words."""

import math
from collections.abc import Iterator, Mapping, Sequence

from calib.noise.coefficients import AxisNoise, NoiseCoefficient
from calib.poses.imu_log import AXES
from calib.rounding import duration, two_digits, with_sd
from pipeline.text.tables import table_lines

#: Coefficient -> words, unit and factor from SI, by triad: as data sheets state them.
ROWS = {
    "gyroscope": (("noise_density", "noise density [°/s/√Hz]", math.degrees(1.0)),
                  ("bias_instability", "bias instability [°/h]", math.degrees(3600.0)),
                  ("random_walk", "random walk [°/s/√h]", math.degrees(60.0)),
                  ("rate_ramp", "ramp [°/s/h]", math.degrees(3600.0))),
    "accelerometer": (("noise_density", "noise density [mm/s²/√Hz]", 1000.0),
                      ("bias_instability", "bias instability [mm/s²]", 1000.0),
                      ("random_walk", "random walk [mm/s²/√h]", 60_000.0),
                      ("rate_ramp", "ramp [mm/s²/h]", 3_600_000.0)),
}


def noise_lines(
    log: str, rate_hz: float, length_s: float, triads: Mapping[str, Sequence[AxisNoise]]
) -> Iterator[str]:
    """A table for each triad, and what a longer log would show."""
    yield f"{log}: {duration(length_s)} at {rate_hz:.5g} Hz"
    for triad, axes in triads.items():
        yield ""
        yield from table_lines([[triad, *AXES], *(
            [f"  {words}", *(_cell(axis.coefficients[name], factor) for axis in axes)]
            for name, words, factor in ROWS[triad]
            if name != "rate_ramp" or any(axis.coefficients[name].value for axis in axes))], "")
    for triad, axes in triads.items():
        yield from _needs(triad, axes)


def _cell(noise: NoiseCoefficient, factor: float) -> str:
    if noise.value is None or noise.sd is None:
        return f"< {two_digits(factor * noise.limit)}"
    return with_sd(factor * noise.value, factor * noise.sd)


def _needs(triad: str, axes: Sequence[AxisNoise]) -> Iterator[str]:
    for name, words in (("bias_instability", "bias instability"), ("random_walk", "random walk")):
        hidden = [axis.coefficients[name] for axis in axes
                  if axis.coefficients[name].value is None]
        lengths = [noise.needed_s for noise in hidden if noise.needed_s is not None]
        if hidden and lengths:
            on = ["", " on one axis", " on two axes"][len(hidden) % len(axes)]
            yield ""
            yield (f"The log does not show the {triad}'s {words}{on}: < is an upper limit (95 %). "
                   f"If it is half as large, a log of {duration(max(lengths))} shows it.")
