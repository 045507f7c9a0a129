"""What ``--auto`` adds next: an effect that is named without doubt, or one that stands for a class.
"""

from collections.abc import Collection

import numpy as np
from scipy.spatial.transform import Rotation

from calib.effects.effect import EFFECTS
from calib.errors import CalibrationError
from pipeline.model_change import ModelChange, RunConfig, Target, change_model, result_of
from pipeline.stages.run import Outcome
from pipeline.stages.triads import TriadResult

MOST_CHANGES = 8
"""Changes of ``--auto`` before it stops: no sensor in the catalogue's sources needs as many."""

LARGEST_RISE = 0.02
"""Rise of the leave-one-out error that noise in the model may cost: its weights are others. A
judgement."""

TURN_RAD = 0.6
"""Turn about each axis to attitudes that the session has not: between the faces, edges and corners
of a box. Derived."""


def next_target(outcome: Outcome, refused: Collection[Target] = ()) -> Target | None:
    """What ``--auto`` adds next: the first effect that a diagnosis names without doubt.

    ``refused`` are those that were tried and did not lower the leave-one-out error.
    """
    for result in outcome.triads:
        for name in result.diagnosis.addable:
            target = Target((result.triad,), name)
            if target not in refused:
                return target
    return None


def stand_in(
    outcome: Outcome, run: RunConfig, refused: Collection[Target] = ()
) -> ModelChange | None:
    """What ``--auto`` adds for a named class: its likeliest member, if all correct alike.

    Where the members of a class correct readings in other attitudes alike, it does not matter for
    the correction which of them it is; the file says that the one stands for all.

    Raises
    ------
    ConfigError
        The configuration does not run with it.
    """
    for result in outcome.triads:
        for name in result.diagnosis.names:
            members = result.diagnosis.named_class(name)
            target = Target((result.triad,), name)
            if len(members) < 2 or target in refused:
                continue
            others = [other for other in members if other != name]
            remark = f"{name} stands for its class: {', '.join(others)}"
            try:
                changes = [
                    change_model(outcome.config, Target((result.triad,), member), run,
                                 before=outcome, remark=remark if member == name else "")
                    for member in (name, *others)
                ]
            except CalibrationError:
                continue
            first, *rest = (result_of(change.after, target) for change in changes)
            if first is not None and all(
                other is not None and correct_alike(first, other) for other in rest
            ):
                return changes[0]
    return None


def correct_alike(one: TriadResult, other: TriadResult) -> bool:
    """Whether two calibrations of one log correct the same readings in other attitudes alike.

    Their magnitudes differ by less, as a root mean square, than the one says that it errs by. The
    attitudes are those of the session turned, so that time and temperature are those of the log.
    """
    poses, prediction = one.calibration.fit.poses, one.prediction
    if prediction is None:
        return False
    differ = []
    for turn in Rotation.from_rotvec(TURN_RAD * np.eye(3)).as_matrix():
        at = poses.conditions(poses.reading @ turn.T)
        sizes = [np.linalg.norm(result.calibration.correct(at), axis=1) for result in (one, other)]
        differ.append((sizes[0] - sizes[1])[~poses.reference.is_null])
    return float(np.sqrt(np.mean(np.square(differ)))) <= prediction.sd_median


def predicts_better(change: ModelChange) -> bool:
    """Whether the leave-one-out error of the triad fell with the change.

    What is drawn predicts no pose: with it the misfit is explained, and the error does not rise.
    """
    before, after = (result_of(outcome, change.target) for outcome in (change.before, change.after))
    if before is None or after is None:
        return True
    effect = EFFECTS.get(change.target.name)
    if effect is not None and effect.acts_on == "noise":
        explained = after.calibration.fit.p_value > before.calibration.fit.p_value
        rise = after.comparison.loo_rms / before.comparison.loo_rms - 1
        return explained and rise < LARGEST_RISE
    return after.comparison.predicts_better_than(before.comparison)
