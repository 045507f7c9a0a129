"""Numbers that are facts: of units, of the normal distribution, of floating point."""

import math

RPM = 2 * math.pi / 60  #: rad/s; definition
SECONDS_PER_HOUR = 3600.0  #: definition

MEDIAN_OF_NORMAL = 0.6745
"""Median of the absolute value of a standard normal number: a median over it is an sd.
Definition."""

NO_LENGTH = 1e-300
"""Divisor used in place of zero: below any square of a length, and no division overflows.
Numerical."""
