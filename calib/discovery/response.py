"""Functions φ of an axis's own reading: a limit, a bend, a wave.

    φ(s) = s within ±w and ±w beyond,    |s − s₀|,    sin(2π s / p + φ₀)

In addition to the scale, the first is a dead band as well as a saturation, the second a different
gain in part of the range, the last the error of a converter.
"""

from collections.abc import Iterator

import numpy as np

from calib.diagnosis.hypotheses.unlisted import LIMITS
from calib.discovery.functions import PHASES, Function

READING = "s"  #: an axis's own reading, in an expression
BENDS = (-0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75)
"""Readings at which the gain of an axis changes, over its largest. Numerical: any other is within
an eighth of one."""
READING_WAVES = (1, 2, 3, 4, 6, 8)
"""Half waves between zero and the largest reading: the error of a converter. A judgement."""


def response_functions(largest: float, unit: str) -> Iterator[Function]:
    """Functions of an axis's own reading, of which ``largest`` is the largest, in ``unit``.

    Within a limit the response may differ from that beyond: in addition to the scale that is a dead
    band as well as a saturation.
    """
    for share in LIMITS:
        yield Function("(abs(s + {0}) - abs(s - {0})) / 2",
                       f"its reading as far as {{0}} {unit} from zero and no further",
                       "with_s_up_to_{0}", 3, READING,
                       numbers=(share * largest,), steps=(2.0,))
    for share in BENDS:
        yield Function("abs(s - {0})", f"the distance of its reading from {{0}} {unit}",
                       "with_s_from_{0}", 3, READING,
                       numbers=(share * largest,), steps=(-largest / 8,))
    for halves in READING_WAVES:
        for phase in PHASES:
            yield Function("sin(2 * pi * s / {0} + {1})",
                           f"a wave in its reading of period {{0}} {unit}",
                           "with_wave_in_s_{0}_{1}", 4, READING,
                           numbers=(2 * largest / halves, phase),
                           steps=((halves + 1) / halves, -np.pi / 4))
