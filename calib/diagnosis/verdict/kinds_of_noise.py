"""Kind of noise of a residual without any shape, by the evidence of each."""

from collections.abc import Sequence

import numpy as np
from scipy.special import fdtrc

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.courses import (
    FROM_RUN_TO_RUN,
    WANDER_SPANS,
    scattering_rates,
    scatters_too_much,
)
from calib.diagnosis.search.posterior import Posterior
from calib.effects.catalogue import find_effect
from calib.fit.least_squares.drawn_sizes import log_evidences, times_stated
from calib.fit.least_squares.result import MISFIT_P_VALUE, Fit
from calib.fit.least_squares.unknown_sd import tests_the_model
from calib.fit.least_squares.widened import times_apart

SHAPELESS = ("extra_noise", "pose_scatter")
"""Effects that noise without any shape can be, the first where these poses tell none apart. Fact:
the sds of the poses are too small by a factor, or by what differs between the poses."""

WANDER = "bias_wander"  #: noise that poses near in time have in common
RATES = "rate_scatter"  #: noise of the reference of a pose on the plate


def kinds_of_noise(fit: Fit) -> tuple[str, ...]:
    """The likeliest kind of noise and what looks the same in these poses; none in a model twice.

    That of one run stands alone, where it is told from those of all.

    Parameters
    ----------
    fit : Fit

    Returns
    -------
    tuple of str
        Empty where the sds of the poses say nothing of the model, or all are in it.
    """
    apart = times_apart(fit.poses)
    in_time = (WANDER,) if apart[np.isfinite(apart)].any() else ()
    of_plate = (RATES,) if fit.poses.reference.is_null.any() and scattering_rates(fit) else ()
    kinds = [each for each in (*SHAPELESS, *in_time, *of_plate) if each not in fit.model.names]
    if not kinds or not tests_the_model(fit.poses):
        return ()
    runs = tuple(dict.fromkeys(fit.poses.run))
    of_runs = [f"{SHAPELESS[0]}:{run}" for run in runs] if len(runs) > 1 else []
    of_runs = [each for each in of_runs if each not in fit.model.names]
    evidence = dict(zip((*kinds, *of_runs), log_evidences(
        fit, [find_effect(each) for each in (*kinds, *of_runs)], WANDER_SPANS), strict=True))
    likeliest = max(of_runs, key=lambda each: evidence[each], default=kinds[0])
    first = max(kinds, key=lambda each: evidence[each])
    if evidence[likeliest] > evidence[first] + CONSTANTS.told_apart:
        return (likeliest,)
    alike = [each for each in kinds if evidence[each] > evidence[first] - CONSTANTS.told_apart]
    if first in (*SHAPELESS, RATES):  # between these a small difference says nothing
        first = next((each for each in alike if each in SHAPELESS), first)
    return tuple(dict.fromkeys((first, *alike)))


def unexplained_noise(fit: Fit) -> str | None:
    """The noise without a shape in the model, where it is more than the samples show; else None.

    It makes the sds contain a misfit, and explains none.
    """
    names = [each.name for each in fit.model.acting_on("noise")
             if each.name.partition(":")[0] in SHAPELESS]
    if not names:
        return None
    p_value = fdtrc(fit.dof, fit.poses.noise_dof, times_stated(fit) ** 2)
    return names[0] if p_value < MISFIT_P_VALUE else None


def as_no_plate_scatters(fit: Fit, details: Sequence[str]) -> str:
    """Words for rates that scatter from pose to pose as those of no plate do; "" where they do not.

    ``details`` are those of the verdict. A rate of its own for every pose makes up most of any
    large error of the sensor.
    """
    if FROM_RUN_TO_RUN in details or not scatters_too_much(fit):
        return ""
    return (f"as if that scattered by {100 * fit.relative_misfit:.2g} % from pose to pose, which "
            f"no plate that turns evenly does")


def kinds_in_a_class(posterior: Posterior) -> tuple[str, ...]:
    """The members of a likely class that is drawn, or of a step that a wander replaces.

    What is drawn comes first: the step could be named, if poses without it were predicted worse.
    Rates that contradict each other come before all else, as a wrong one is no noise.
    """
    stated = {each: (course := posterior.first[each.name].course) is not None and course.on_common
              for each in posterior.classes}
    for each in sorted(posterior.classes, key=lambda each: not stated[each]):
        first = posterior.first[each.name]
        members = sorted(each.members, key=lambda name: posterior.first[name].kind != "drawn")
        if (each.probability >= CONSTANTS.sure and (first.kind == "drawn" or first.is_placed)
                and posterior.first[members[0]].kind == "drawn"):
            return tuple(members)
    return ()


def told_apart(fit: Fit, group: tuple[str, ...], detail: str) -> tuple[str, ...]:
    """The kinds of ``group``, behind the kind of noise that is likelier than what is drawn in it.

    ``detail`` is how the first of them is drawn: rates of whole runs are no noise of poses.
    """
    is_of_poses = detail != FROM_RUN_TO_RUN
    kinds = kinds_of_noise(fit) if is_of_poses and {WANDER, RATES} & {*group} else ()
    return group if not kinds or kinds[0] in group else tuple(dict.fromkeys((*kinds, *group)))
