"""Expected failures of a calibration, by what the user can do about them.

Every message is one paragraph: where, what was found, what was expected, what to do next. This
package does not know its user interface (commands, keys of a file): the caller derives what to type
from ``remedy``.
"""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Remedy:
    """Remedy of a failure, for the caller to translate into commands or keys.

    Attributes
    ----------
    kind : str
        ``remove_effect`` (take an effect out of the model), ``data_sheet`` (correct the data
        sheet's values of ``triad``), ``default_solver``, ``smaller_model`` (these poses carry
        ``model``), or ``exclude_pose`` (leave out the poses that the message names).
    triad : str or None
    model : tuple of str
        Names of effects.
    """

    kind: Literal["remove_effect", "data_sheet", "default_solver", "smaller_model", "exclude_pose"]
    triad: str | None = None
    model: tuple[str, ...] = ()


class CalibrationError(Exception):
    """Base of all expected failures of this package."""

    def __init__(self, message: str, remedy: Remedy | None = None) -> None:
        super().__init__(message)
        self.remedy = remedy


class UnusableLog(CalibrationError):
    """The log cannot be read as measurements: not-a-number, time backwards, a stuck axis."""


class Undetermined(CalibrationError):
    """The measurements are readable but do not determine what was asked for."""


class Contradiction(CalibrationError):
    """Two parts of the session state one quantity differently; the message names both."""


class FitFailed(CalibrationError):
    """The fit ended without passing its own check (no convergence, non-finite parameters)."""
