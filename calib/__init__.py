"""From readings and poses to a calibration with honest uncertainties, and the effects it lacks.

Conventions, everywhere in this package
---------------------------------------
Axes
    x, y, z in this order; arrays of n vectors have shape (n, 3).
Units
    SI inside: m/s², rad/s, s, °C. Counts exist only in :mod:`calib.poses.data_sheet` and in the
    log itself.
Model of both triads
    Angrisano et al. eq. (1): ``s = T K (s_out - b)``, T unit upper triangular with (alpha_z,
    alpha_y; alpha_x) as in eq. (2), K diagonal. Misalignments are listed (x, y, z).
Uncertainty
    ``sd`` is one standard deviation, ``cov`` a covariance matrix.
Absent telemetry
    NaN, never None.

The way of the data
-------------------
::

    ImuLog ─ poses ─ PoseSet ─┬─ fit ─ Fit ─┬─ diagnosis ─ Diagnosis
                     effects ─┘             ├─ mounting, consistency, noise
                                            └─ planning

``poses``        a log's readings as pose means with their references (``pose_set``)
``effects``      errors of a reading: every effect is a set of columns; a model is their sum
``fit``          poses and a model to parameters with their uncertainty (``fit``)
``diagnosis``    a fit and its residuals to a verdict: what does the model lack? (``diagnose``)
``assess``       all of these for one triad: fit, comparison, verdict, prediction
``lot``          many sensors of one design side by side, and the effects that the lot lacks
``notebook``     the same in five lines of Python (``calib.calibrate``)
``mounting``     how the sensor is mounted in a vehicle (``mounting_from_logs``)
``consistency``  whether parts of a session, or the maker's certificate, contradict each other
``noise``        Allan deviation of a long log at rest
``planning``     expected results of poses before they are recorded (``prospect_of``)
``earth``        gravity and the Earth's rate at a latitude
``errors``       expected failures, by what the user can do about them
``rounding``     a value beside its sd, in digits
``threads``      the linear algebra on one thread
``numbers``      facts: of units, of the normal distribution, of floating point

This package knows nothing of video, YAML, file names or the screen.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from calib.notebook.calibration import Calibration
    from calib.notebook.calibration import parameter_differences as compare
    from calib.notebook.from_table import calibrate

__all__ = ["Calibration", "calibrate", "compare"]


def __dir__() -> list[str]:
    """Names for completion in a notebook."""
    return list(__all__)


def __getattr__(name: str) -> Any:
    """Load a name when a notebook first uses it: the command line imports this package too."""
    if name not in __all__:
        raise AttributeError(f"module 'calib' has no attribute {name!r}")
    from calib.notebook import calibration, from_table

    return {"calibrate": from_table.calibrate, "compare": calibration.parameter_differences,
            "Calibration": calibration.Calibration}[name]
