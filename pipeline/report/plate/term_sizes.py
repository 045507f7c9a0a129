"""The sizes of the terms of a clip's phase, in the units that people state."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from calib.numbers import NO_LENGTH
from calib.poses.imu_log import FloatArray
from pipeline.text.formatting import with_minus_signs, with_sd
from vision.rate.terms import TERMS

if TYPE_CHECKING:  # a session without clips measures none
    from vision.rate.measure import RateMeasurement


def term_sizes(clip: "RateMeasurement") -> Iterator[tuple[str, str]]:
    """Name and size ± sd of every term that is in the model or that the verdict names."""
    diagnosis = clip.diagnosis
    named = (diagnosis.name,) if diagnosis.verdict == "effect" else diagnosis.group
    sizes = {c.name: (c.size, c.sd) for c in diagnosis.ranking if c.name in named}
    sizes |= {term.name: (term.value, term.sd) for term in clip.fit.terms}
    for name in TERMS:
        if name in sizes:
            words = " ".join(_worded(name, *sizes[name], clip.rate_rad_s))
            yield f"size of {name}", with_minus_signs(words)


def _worded(name: str, value: FloatArray, sd: FloatArray, rate: float) -> Iterator[str]:
    if name in ("once_per_rev", "twice_per_rev"):
        amplitude = math.hypot(*value)
        spread = math.sqrt(float(((value * sd) ** 2).sum())) / max(amplitude, NO_LENGTH)
        yield f"amplitude {with_sd(math.degrees(amplitude), math.degrees(spread))}°"
    elif name == "rate_drift":
        per_minute = 60e6 / rate
        yield f"{with_sd(float(value[0]) * per_minute, float(sd[0]) * per_minute)} ppm of the rate"
        yield "per minute"
    elif name == "frame_steps":
        yield f"{with_sd(float(value[0]), float(sd[0]))} times the frames counted as dropped"
    else:
        yield f"{with_sd(float(value[0]) * 1e6, float(sd[0]) * 1e6)} µs per row"
