"""Whether a stored calibration is good enough to be used by other programs."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from calib.diagnosis.verdict.decision import Code
from calib.diagnosis.verdict.wording import enumeration
from calib.fit.parameters import TriadParameters
from calib.fit.triad.determined import undetermined
from calib.poses.imu_log import SI_UNIT
from pipeline.errors import UnfitCalibration
from pipeline.results.read import Stored, StoredTriad
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
    faults = [fault for triad in stored.triads for fault in _faults(stored, triad)]
    if faults and not anyway:
        raise UnfitCalibration(
            f"{stored.path}: {faults[0]} Record what `pipeline diagnose` names and run again, or "
            f"add --anyway to use these results as they are."
        )
    return (*faults, *(note for triad in stored.triads for note in _notes(stored, triad)))


def _faults(stored: Stored, triad: StoredTriad) -> Iterator[str]:
    section = stored.contents[triad.name]
    reference = max((abs(pose["reference"]) for pose in section["poses"]), default=0.0)
    # The sds by the noise alone: what a run accepts is accepted here.
    widened = section["sd_widened_by"]
    sd = np.concatenate([triad.misalignment_sd, triad.bias_sd, triad.scale_sd]) / widened
    nine = TriadParameters(
        triad.misalignment_rad, triad.bias_counts, triad.scale_counts_per_unit, np.diag(sd**2))
    lost = undetermined(nine, reference or np.nan)
    if lost:
        yield f"the poses do not determine the {triad.name}'s {', '.join(lost)}."
        return
    prediction = section["prediction"]
    if "scale" not in section["model"]:
        return
    if prediction is None or prediction["sd_worst"] is None or reference == 0:
        yield (f"the gain of the {triad.name} was not measured: at rest, as in all its poses, a "
               f"gyroscope shows its bias only.")
    elif prediction["sd_worst"] > LARGEST_ERROR * reference:
        unit = SI_UNIT[triad.name]
        yield (f"a corrected {triad.name} errs by up to {prediction['sd_worst']:.2g} {unit} "
               f"(1 sd) of {reference:.3g} {unit} in its worst direction, which is more than the "
               f"{100 * LARGEST_ERROR:.0f} % of an uncalibrated sensor.")


def _notes(stored: Stored, triad: StoredTriad) -> Iterator[str]:
    verdict = stored.contents[triad.name]["diagnosis"]
    if verdict["verdict"] not in (Code.NOTHING_MISSING, Code.NOISE):
        yield f"{triad.name}: the calibration is incomplete. {verdict['says']}"
    if "scale" not in triad.correction.model.names:
        yield f"{triad.name}: the gain was not fitted; it is that of the data sheet."
    section = stored.contents[triad.name]
    unseen, (unit, factor) = unseen_of(section), DISPLAY[triad.name]
    by_them = math.hypot(*unseen.values())
    if unseen and by_them > (section["prediction"]["parts"]["poses"] or 0.0):
        yield (f"{triad.name}: its poses are blind to {enumeration(list(unseen), 'and')}: if the "
               f"sensor is typical, corrected magnitudes err by {by_them * factor:.2g} {unit} "
               f"(1 sd) by that alone.")


def unseen_of(section: Mapping[str, Any]) -> dict[str, float]:
    """What each effect that the poses cannot see adds to the error of a corrected magnitude.

    Parameters
    ----------
    section : mapping
        Of a triad in results.json.

    Returns
    -------
    dict of str to float
        Root mean square by effect, SI, the largest first; empty in results of earlier versions.
    """
    parts = (section["prediction"] or {}).get("parts") or {"unseen": {}}
    known = {name: rms for name, rms in parts["unseen"].items() if rms is not None}
    return dict(sorted(known.items(), key=lambda one: -one[1]))
