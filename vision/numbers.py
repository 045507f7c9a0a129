"""Numbers that are facts: of units and of the normal distribution."""

import math

RPM = 2 * math.pi / 60  #: rad/s

FASTEST_USUAL = 100 * RPM
"""Rad/s, of record players; what looks faster may be light that flickers."""

SD_PER_MAD = 1.4826
"""Sd of a normal distribution over its median absolute deviation."""
