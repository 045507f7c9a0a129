"""One trial of the diagnosis: hide something, calibrate, ask what is missing, add what was named.

What is counted here is what a user would see: the verdict, the ranking in its order, the errors
before and after following the advice, and whether the stated size holds the truth.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.diagnosis.diagnose import Diagnosis, diagnose
from calib.effects.catalogue import BASE, find_effect
from calib.effects.effect import EFFECTS
from calib.errors import CalibrationError
from calib.fit.least_squares.solver import Fit, fit
from calib.fit.model import Model
from calib.fit.triad.calibration import calibrate_triad
from calib.fit.validation.leave_one_out import left_out_residual
from calib.numbers import SECONDS_PER_HOUR
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from tests.fitting import pose_sets, spec_of
from tests.world.bench import Design
from tests.world.designs import paper_design, rich_design, soak_design
from tests.world.hidden import GYROSCOPE_ONLY, Hidden, TriadName
from tests.world.physics import triad_of
from tests.world.session import Session, simulate
from tests.world.sizes import draw_effect, pose_equations, without_effects
from tests.world.truth import g_sensitivity_seen

LISTED = (
    "frame_rotation",
    "quadratic",
    "cubic",
    "asymmetry",
    "cross_quadratic",
    "temperature_bias",
    "temperature_scale",
    "bias_drift",
    "scale_drift",
    "warm_up",
    "hysteresis",
    "vibration_rectification",
    "g_sensitivity",
    "g_squared_sensitivity",
    "earth_rate",
    "reference_offset",
    "reference_scale",
    "reference_drift",
    "direction_dependent_rate",
)

DESIGNS = {"paper": paper_design, "rich": rich_design, "soak": soak_design}

BIAS_LIKE = frozenset({"temperature_bias", "bias_drift", "warm_up", "column"})
SAME_AXIS_POWER = {
    "temperature_scale": 1,
    "scale_drift": 1,
    "quadratic": 2,
    "cubic": 3,
    "asymmetry": 1,
    "hysteresis": 0,
    "g_squared_sensitivity": 0,
}
"""Power of its own axis that an effect follows: how the lean of the axes changes its size."""

CONSTANT_PART = {
    "temperature_bias": "bias",
    "bias_drift": "bias",
    "warm_up": "bias",
    "vibration_rectification": "bias",
    "temperature_scale": "scale",
    "scale_drift": "scale",
    "reference_drift": "reference_scale",
}
"""What is left of an effect where its covariate does not vary."""

COMMON_PARTS = {
    "reference_drift": {"scale_drift"},
    "earth_rate": set[str](),
}
"""Finding an effect that holds all of another one, as its common part, is finding it: a drift of
the plate is a drift of all gains alike."""


@dataclass(frozen=True)
class Outcome:
    """One trial, errors in noise units.

    ``first``: of the listed effects in the ranking, the hidden one or an alias stood first.
    ``held`` and ``stated`` count the parameters of the hidden effects whose 2-sigma interval held
    the truth, and all that had one; ``top`` is what the ranking shows first.
    """

    seed: int
    hidden: tuple[str, ...]
    visible: bool
    first: bool
    named: bool
    named_wrong: bool
    verdict: str
    says: tuple[str, ...]
    top: str
    rms_before: float
    rms_after: float
    loo_after: float
    held: int
    stated: int


def poses_of(design: Design, seed: int, triad: str, hidden: Sequence[Hidden]) -> PoseSet:
    """The poses of ``triad`` of one evening."""
    return pose_sets(simulate(design, seed, tuple(hidden)), triad=triad)[1]


def calibrates(name: str, triad: str) -> bool:
    """Whether the bench can hide ``name`` in ``triad``."""
    return triad == "gyroscope" or name not in GYROSCOPE_ONLY


def drawn(name: str, triad: TriadName, size: float, design: Design, seed: int) -> Hidden | None:
    """An effect of that size, None where it does not reach the pose equations of the design.

    The size is the root mean square over the pose equations in noise units. What follows a
    covariate counts from the covariate's mean: the rest is a constant bias, gain or plate rate,
    and no calibration tells it from one.
    """
    try:
        hidden = draw_effect(name, triad, size, design, seed)
    except ValueError:
        return None
    if name not in CONSTANT_PART:
        return hidden
    nothing = without_effects(design, seed, triad)
    moved = pose_equations(design, seed, triad, (hidden,)) - nothing
    constant = Hidden(CONSTANT_PART[name], triad, hidden.size)
    alike = pose_equations(design, seed, triad, (constant,)) - nothing
    left = moved - alike * (alike @ moved) / (alike @ alike)
    return replace(hidden, size=hidden.size * size / float(np.sqrt(np.mean(left**2))))


def whitened_rms(found: Fit) -> float:
    """Root mean square residual of the data rows in their own sds."""
    return float(np.sqrt(np.mean(found.rows.residual[: found.equations.data_count] ** 2)))


def whitened_loo(found: Fit) -> float:
    """The same when each pose is left out of the fit that predicts it."""
    rows, pose = found.rows, found.equations.row_pose
    return float(np.sqrt(np.mean(left_out_residual(rows.residual, rows.jacobian, pose) ** 2)))


def said_names(found: Diagnosis) -> tuple[str, ...]:
    """What an `effect` verdict speaks of: the group, and all names where there are several."""
    if found.verdict != "effect":
        return ()
    return tuple(dict.fromkeys((*found.group, *found.names)))


def true_size(hidden: Hidden, session: Session) -> Mapping[str, FloatArray] | None:
    """What a perfect calibration reports of ``hidden``; None where the two speak differently.

    The bench errs along sensitive axes, the calibration along its orthogonal ones.
    """
    name = hidden.name.partition(":")[0]
    onto = getattr(session, hidden.triad).reading_to_orthogonal
    size = hidden.size
    per_hour = SECONDS_PER_HOUR if name.endswith("drift") else 1.0
    if name in BIAS_LIKE:
        value = onto @ size * per_hour
        return {"value": np.append(value, hidden.detail["tau_s"]) if name == "warm_up" else value}
    if name in SAME_AXIS_POWER:
        own = np.diag(np.linalg.inv(onto)) ** SAME_AXIS_POWER[name]
        return {"value": np.diag(onto) * size * own * per_hour}
    if name == "g_sensitivity":
        return {"value": g_sensitivity_seen(session.design.sensor, size).ravel()}
    if name in ("reference_offset", "reference_drift", "direction_dependent_rate", "earth_rate"):
        return {"value": np.atleast_1d(size) * per_hour}
    return None


def intervals_held(poses: PoseSet, session: Session, hidden: Sequence[Hidden]) -> tuple[int, int]:
    """How many 2-sigma intervals of the hidden effects' parameters hold the truth, and of how many.

    The right model is fitted whatever the verdict was: intervals of named effects alone would be
    those of lucky draws.
    """
    model = Model.of((*BASE, *(h.name for h in hidden)))
    triad = triad_of(session.design, poses.triad)
    try:
        found = calibrate_triad(fit(poses, model), spec_of(triad, triad.full_scale))
    except CalibrationError:
        return 0, 0
    held = stated = 0
    for h in hidden:
        truth = true_size(h, session)
        if truth is None:
            continue
        known = len(truth["value"])  # a shape parameter comes last, and not all have a truth
        value, sd = (each[:known] for each in found.effect_values()[h.name])
        held += int((np.abs(value - truth["value"]) <= 2 * sd).sum())
        stated += len(value)
    return held, stated


def run_trial(design: Design, seed: int, triad: str, hidden: Sequence[Hidden]) -> Outcome:
    """Hide, calibrate, diagnose, add what was named."""
    session = simulate(design, seed, tuple(hidden))
    _, poses, _ = pose_sets(session, triad=triad)
    base = fit(poses, Model.of(BASE))
    found = diagnose(base)
    names = {h.name for h in hidden}
    right = names.union(*(COMMON_PARTS.get(n, set()) for n in names)) if names else set()
    top = next(c for c in found.ranking if c.kind == "listed")
    said = set(said_names(found))
    after = base
    if found.verdict == "effect" and found.name is not None:
        try:
            after = fit(poses, Model.of((*BASE, *found.names)))
        except CalibrationError:
            after = base  # named, but these poses cannot carry it
    known = [h for h in hidden if is_listed(h.name) and h.name not in found.blind]
    held, stated = intervals_held(poses, session, known) if known else (0, 0)
    return Outcome(
        seed=seed,
        hidden=tuple(sorted(names)),
        visible=not names & set(found.blind),
        first=bool({top.name, *top.aliases} & right),
        named=bool(said & right),
        named_wrong=bool(said) and not said & right,
        verdict=found.verdict,
        says=said_names(found) or ((found.name,) if found.name else found.group),
        top=found.ranking[0].name,
        rms_before=whitened_rms(base),
        rms_after=whitened_rms(after),
        loo_after=whitened_loo(after),
        held=held,
        stated=stated,
    )


def is_listed(name: str) -> bool:
    """Whether the catalogue has ``name``; a plain ``column:NAME`` counts."""
    return name in EFFECTS or name.startswith("column:")


@dataclass(frozen=True)
class Loop:
    """Effects added one after the other until the diagnosis names no more.

    ``groups`` are all that could not be told from one that was added, itself included.
    """

    added: tuple[str, ...]
    groups: tuple[str, ...]
    fit: Fit
    last: Diagnosis


def follow_to_the_end(poses: PoseSet, most: int = 4) -> Loop:
    """The loop without files: add what is named, ask again.

    Of effects that look the same here the first is taken, as ``--anyway`` does.
    """
    model = Model.of(BASE)
    added: list[str] = []
    found = fit(poses, model)
    said = diagnose(found)
    groups: list[str] = []
    while said.verdict == "effect" and said.name is not None and len(added) < most:
        try:
            found = fit(poses, model + find_effect(said.name))
        except CalibrationError:
            break  # named, but these poses cannot carry it
        model = found.model
        added.append(said.name)
        groups += said.group
        said = diagnose(found)
    return Loop(tuple(added), tuple(groups), found, said)


def hidden_of(names: Sequence[str], triad: str, size: float, design: Design, seed: int) -> (
    list[Hidden] | None
):
    """Each of ``names`` at ``size``; None where one does not reach these pose equations."""
    found = [drawn(name, triad, size, design, seed) for name in names]
    return None if None in found else [h for h in found if h is not None]
