"""What a verdict rests on: noise, what the poses have in common, cannot see, the turning plate.

Gravity turns in the axes of a sensor on a leaning plate, and so does everything fixed in the room:
the magnet of a motor makes the waves of a g-sensitivity in every pose. If the player leans the
other way, gravity's waves change sign relative to the room, and those of a field do not.
"""

from dataclasses import replace

import numpy as np

from calib.diagnosis.diagnose import Diagnosis
from calib.diagnosis.formula_error import formulas_of_readings
from calib.diagnosis.hypotheses.listed import ATTITUDE
from calib.diagnosis.next_measurement.advice import showing_blocks
from calib.diagnosis.unseen import HARDLY_SEEN, typical_size
from calib.diagnosis.verdict.decision import Code
from calib.diagnosis.verdict.explanation import Explanation
from calib.diagnosis.verdict.wording import (
    NOTHING_MISSING,
    curves,
    enumeration,
    minutes_of,
    what_separates,
)
from calib.effects.effect import EFFECTS, Effect
from calib.effects.units import display_unit
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.unknown_sd import tests_the_model
from calib.fit.triad.within_poses import courses_within
from calib.fit.validation.prediction import Prediction
from calib.poses.imu_log import Triad

ALSO_NAMED = 3  #: other measurements that a verdict prices: it chooses words only

GRAVITY_SENSED = "g_sensitivity"
OR_A_FIELD = (
    " It rests on waves that keep step with the plate, and a field that stays in the room, as of a "
    "motor's magnet, makes the same ones: the same poses with the other side of the record player "
    "raised, or with the plate stopped, tell them apart."
)
UNTESTED = (
    "Whether something is missing cannot be determined: the poses have no sds, and no attitude was "
    "repeated often enough to estimate their noise, so that whatever the model misses counts as "
    "noise. The ranking shows which effect would lower the leave-one-out error. State the sds of "
    "the means, use the logs that they come from, or record every pose twice."
)
BY_THE_REST = (
    " The poses have no sds: what the named effect leaves in the residual is taken for their noise."
)


def on_its_grounds(
    diagnosis: Diagnosis, fit: Fit, prediction: Prediction | None, part: str, full_scale: float
) -> Diagnosis:
    """``diagnosis`` of ``fit`` with what it rests on.

    Parameters
    ----------
    diagnosis : Diagnosis
    fit : Fit
    prediction : Prediction or None
        :func:`calib.diagnosis.unseen.with_unseen`.
    part : str
        Class of the sensor, as the pages of the catalogue call it.
    full_scale : float
        Of the triad, SI; keeps what to record next to what the sensor can measure.
    """
    poses = fit.poses
    if (poses.ring is not None and GRAVITY_SENSED in diagnosis.names
            and len({poses.run[place] for place in poses.ring.place}) == 1
            and not poses.reference.is_null.any()):
        diagnosis = diagnosis.saying(OR_A_FIELD)
    diagnosis = _as_far_as_it_settled(diagnosis, fit)
    if tests_the_model(poses):
        if (diagnosis.verdict == Code.NOTHING_MISSING and prediction is not None
                and prediction.by_open > prediction.by_poses and formulas_of_readings(fit)):
            diagnosis = diagnosis.saying(f" {curves([ATTITUDE])}".rstrip())
        return _among_what_is_seen(diagnosis, fit, prediction, part, full_scale)
    if diagnosis.verdict == Code.EFFECT:  # the residual shows it whatever its noise
        return diagnosis.saying(BY_THE_REST)
    return replace(
        diagnosis, verdict=Code.REFUSED, name=None, names=(), group=(), inclusion=(), advice=None,
        explanation=Explanation("open", "its model cannot be tested", UNTESTED, "record",
                                "State the sds of the means, or record every pose twice"))


def _as_far_as_it_settled(diagnosis: Diagnosis, fit: Fit) -> Diagnosis:
    """``diagnosis`` with the courses that all poses have in common.

    They are told where a parameter may be off by more than by all else. Then the session is not
    complete, and a misfit without a name may be theirs: poses of two lengths settle differently.
    """
    for course in courses_within(fit):
        if (2 * np.diag(course.cov) <= np.diag(fit.cov)).all():
            continue
        diagnosis = diagnosis.saying(f" {course.text}")
        said = diagnosis.explanation
        if said.standing == "good" or diagnosis.verdict in (Code.UNKNOWN, Code.AMBIGUOUS):
            diagnosis = replace(diagnosis, explanation=Explanation(
                "open", "its readings change alike within every pose", said.text, "record",
                course.remedy))
    return diagnosis


def _among_what_is_seen(
    diagnosis: Diagnosis, fit: Fit, prediction: Prediction | None, part: str, full_scale: float
) -> Diagnosis:
    """``diagnosis`` with the effects that "nothing is missing" says nothing of.

    Where a typical size says more of what corrected readings err by than the poses do, the session
    is not complete, and what to record next makes the effect visible.
    """
    if diagnosis.verdict != Code.NOTHING_MISSING or prediction is None or not prediction.unseen:
        return diagnosis
    turned = _on_the_plate(diagnosis, fit, prediction)
    if turned is not None:
        return turned
    said = diagnosis.explanation
    largest_first = sorted(prediction.by_unseen, key=lambda name: -prediction.by_unseen[name])
    near = "" if set(largest_first) <= set(diagnosis.blind) else "nearly "
    words = enumeration([_sized(EFFECTS[name], part, fit.poses.triad) for name in largest_first],
                        "and")
    text = said.text.replace(NOTHING_MISSING, f"{NOTHING_MISSING} among what these poses can see",
                             1) + f" They are {near}blind to {words}."
    if said.standing != "good" or not prediction.is_mostly_unseen:
        return replace(diagnosis, explanation=replace(said, text=text))
    name = largest_first[0]
    size = typical_size(EFFECTS[name], part, fit.poses.triad)
    assert size is not None  # otherwise it would not be listed
    whole, more = showing_blocks(fit, EFFECTS[name], size, 1 / HARDLY_SEEN - 1, full_scale)
    advice = next(iter(whole or more), None)
    if advice is None:
        following = f"What shows {name}: {what_separates(name, fit.poses.triad)} "
        following += f"({minutes_of(len(fit.poses))} for as many poses as now)"
        text += f" {following}."
    else:
        following = f"Record {advice.timed}"
        text += f" Record next: {advice.timed}."
        for words, others in (("As good", whole[1:]), ("In part", more if whole else more[1:])):
            if others:
                timed = [each.timed for each in others[:ALSO_NAMED]]
                text += f" {words}: {enumeration(timed, 'or')}."
    short = f"its poses are blind to {enumeration(largest_first, 'and')}"
    return replace(diagnosis, advice=advice,
                   explanation=Explanation("open", short, text, "record", following))


def _on_the_plate(
    diagnosis: Diagnosis, fit: Fit, prediction: Prediction
) -> Diagnosis | None:
    """The verdict where a lever of the turning plate may outweigh everything that the poses leave.

    A plate that turns has one, and only its size is open.
    """
    lever = prediction.by_unseen.get("lever_arm", 0.0)
    if lever <= prediction.by_poses:
        return None
    turned = np.abs(fit.poses.spin_rad_s)
    again = ("Take these poses with the plate stopped, or some of them at another speed and add "
             "accelerometer.lever_arm")
    text = (
        f"{np.count_nonzero(turned)} of the {len(fit.poses)} poses were taken on the turning "
        f"plate, where every centimetre off the spindle adds up to "
        f"{0.01 * float(turned.max()) ** 2:.2g} m/s² across gravity, which these poses do not tell "
        f"from gain and misalignment: corrected readings err by {lever:.2g} m/s² where the sensor "
        f"stood as far off as one usually does. Beside that nothing is missing "
        f"(p = {diagnosis.p_value:.2g}). {again}."
    )
    return replace(
        diagnosis, verdict=Code.AMBIGUOUS, group=("lever_arm",),
        explanation=Explanation("open", "its poses were taken on the turning plate", text,
                                "record", again))


def _sized(effect: Effect, part: str, triad: Triad) -> str:
    """``g_sensitivity, typically 0.1 °/s per g``."""
    size = typical_size(effect, part, triad)
    assert size is not None  # otherwise it would not be listed
    unit, factor = display_unit(effect.unit_for(triad), [size])
    return f"{effect.name}, typically {size * factor:.2g} {unit}"
