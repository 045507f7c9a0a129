"""Test whether a stored calibration is good enough to be used by other programs."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from calib.diagnosis.verdict.decision import Code
from calib.diagnosis.verdict.wording import enumeration
from calib.fit.triad.determined import undetermined
from calib.poses.imu_log import SI_UNIT
from pipeline.errors import UnfitCalibration
from pipeline.results.read import Stored, StoredTriad
from pipeline.results.schema.triad import TriadSection
from pipeline.text.formatting import DISPLAY

LARGEST_ERROR = 0.03
"""Share of the reference: the tolerance of an uncalibrated sensor's gain by its data sheet
(MPU-6050: ±3 %). A calibration that may err by more makes readings worse."""


def require_fit(stored: Stored, anyway: bool) -> tuple[str, ...]:
    """Refuse a calibration whose data do not determine it.

    Parameters
    ----------
    stored : Stored
    anyway : bool
        Warn instead.

    Returns
    -------
    tuple of str
        Warnings.

    Raises
    ------
    UnfitCalibration
        With the parameter or direction, its sd, and what is accepted.
    """
    faults = [fault for triad in stored.triads for fault in _faults(triad)]
    if faults and not anyway:
        raise UnfitCalibration(
            f"{stored.path}: {faults[0]} Record what `pipeline diagnose` names and run again, or "
            f"add --anyway to use these results as they are."
        )
    return (*faults, *(note for triad in stored.triads for note in _notes(triad)))


def _faults(triad: StoredTriad) -> Iterator[str]:
    section = triad.section
    reference = max((abs(pose.reference) for pose in section.poses), default=0.0)
    # The sds by the noise alone: accepted here as in a run.
    nine = replace(triad.parameters, cov=triad.parameters.cov / section.sd_widened_by**2)
    lost = undetermined(nine, reference or np.nan)
    if lost:
        yield f"the poses do not determine the {triad.name}'s {', '.join(lost)}."
        return
    prediction = section.prediction
    if "scale" not in section.model:
        return
    if prediction is None or prediction.sd_worst is None or reference == 0:
        yield (f"the gain of the {triad.name} was not measured: at rest, as in all its poses, a "
               f"gyroscope shows its bias only.")
    elif prediction.sd_worst > LARGEST_ERROR * reference:
        unit = SI_UNIT[triad.name]
        yield (f"a corrected {triad.name} errs by up to {prediction.sd_worst:.2g} {unit} "
               f"(1 sd) of {reference:.3g} {unit} in its worst direction, which is more than the "
               f"{100 * LARGEST_ERROR:.0f} % of an uncalibrated sensor.")


def _notes(triad: StoredTriad) -> Iterator[str]:
    verdict = triad.section.diagnosis
    if verdict.verdict == Code.NOISE and verdict.name in triad.section.model:
        yield f"{triad.name}: {verdict.in_words}"
    elif verdict.verdict not in (Code.NOTHING_MISSING, Code.NOISE):
        yield f"{triad.name}: the calibration is incomplete. {verdict.in_words}"
    if "scale" not in triad.correction.model.names:
        yield f"{triad.name}: the gain was not fitted; it is that of the data sheet."
    by_poses, unseen = parts_of_error(triad.section)
    by_them, (unit, factor) = math.hypot(*unseen.values()), DISPLAY[triad.name]
    if unseen and by_them > by_poses:
        yield (f"{triad.name}: its poses are blind to {enumeration(list(unseen), 'and')}: if the "
               f"sensor is typical, corrected magnitudes err by {by_them * factor:.2g} {unit} "
               f"(1 sd) by that alone.")


def parts_of_error(section: TriadSection) -> tuple[float, dict[str, float]]:
    """Parts of the error of a corrected magnitude, root mean squares, SI.

    Returns
    -------
    by_poses : float
        By what the poses determine; 0 where that is not known.
    unseen : dict of str to float
        By each effect that the poses cannot see, the largest first; empty in results of earlier
        versions.
    """
    parts = section.error_parts
    known = {name: rms for name, rms in parts.unseen.items() if rms is not None}
    return parts.poses or 0.0, dict(sorted(known.items(), key=lambda one: -one[1]))
