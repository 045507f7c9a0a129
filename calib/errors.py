"""What can go wrong in a calibration, by what the user can do about it.

Every message is one paragraph: where, what was found, what was expected, what to do next.
"""


class CalibrationError(Exception):
    """Base of all expected failures of this package."""


class UnusableLog(CalibrationError):
    """The log cannot be read as measurements: not-a-number, time backwards, a stuck axis."""


class Undetermined(CalibrationError):
    """The measurements are readable but do not determine what was asked for."""


class FitFailed(CalibrationError):
    """The fit ended without passing its own check (no convergence, non-finite parameters)."""
