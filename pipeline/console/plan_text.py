"""The outlook of a session in words and tables."""

import math
from collections.abc import Iterator, Sequence

from calib.diagnosis.next_measurement import Rival, best_block
from calib.effects.effect import Effect
from calib.planning.prospect import Prospect
from calib.poses.attitudes import direction_name
from pipeline.formatting import aligned, relative
from pipeline.plan.outlook import TriadPlan

NOISE = {
    "measured": "noise measured in the recorded poses",
    "typical": "typical noise of this sensor; yours may differ by a factor of two",
    "unknown": "noise not known: no sds are stated until a pose is recorded",
}
MEANS = {
    "d": "information per pose, 1 is that of the 18 wedge poses",
    "condition": "1.4 is that of the 18 wedge poses, 25 the limit",
}


def plan_lines(plan: TriadPlan, effects: Sequence[Effect], full_scale: float) -> Iterator[str]:
    """What ``pipeline plan`` prints of one triad.

    Parameters
    ----------
    plan : TriadPlan
    effects : sequence of Effect
        Effects asked about by name; none asks about all that these poses leave open.
    full_scale : float
        Of the triad, SI.
    """
    missing = sum(len(setting.missing) for setting in plan.settings)
    yield f"{plan.triad}: {plan.recorded} poses recorded, {missing} to come"
    for setting in plan.settings:
        at = "at rest" if not setting.rate_rad_s else (
            f"at {setting.rate_rad_s * 30 / math.pi:.4g} rpm")
        yield (f"  {setting.name}: {len(setting.means)} recorded, {len(setting.missing)} to come, "
               f"{setting.seconds:.3g} s each, {at}")
        yield from (f"  not counted: {says}" for says in setting.unusable)
    yield from (f"  range: {says}" for says in plan.saturates)
    yield from (f"  planned without {name}: {says}" for name, says in plan.not_planned.items())
    if isinstance(plan.at_hand, str):
        yield f"  at hand: {plan.at_hand}"
    judged = {"at hand": plan.at_hand, "complete": plan.complete if missing else None}
    outlooks = {name: each for name, each in judged.items() if isinstance(each, Prospect)}
    if isinstance(plan.complete, str) and missing:
        yield f"  complete: {plan.complete}"
    if outlooks:
        yield from aligned(_figures(plan, outlooks))
        yield f"  ({NOISE[plan.noise]})"
        yield from _seen(list(outlooks.values())[-1], effects, full_scale)
    best = plan.next_pose
    yield (f"  next best pose: {direction_name(best.up)}, plate {best.run}; all sds shrink by "
           f"{100 * (1 - best.shrinks):.1f} % on average")


def _figures(plan: TriadPlan, outlooks: dict[str, Prospect]) -> list[list[str]]:
    unit = "m/s²" if plan.triad == "accelerometer" else "°/s"
    factor = 1.0 if plan.triad == "accelerometer" else math.degrees(1)
    rows = [["", *outlooks]]
    rows += [
        ["degrees of freedom", *(str(each.dof) for each in outlooks.values())],
        [f"condition ({MEANS['condition']})",
         *(f"{each.condition:.2f}" for each in outlooks.values())],
        [f"D-efficiency ({MEANS['d']})",
         *(f"{each.d_efficiency:.2f}" for each in outlooks.values())],
    ]
    if plan.noise == "unknown":
        return rows
    rows += [
        ["sd of misalignment x y z [rad]",
         *("  ".join(f"{x:.2g}" for x in each.sd[0]) for each in outlooks.values())],
        [f"sd of bias x y z [{unit}]",
         *("  ".join(f"{x * factor:.2g}" for x in each.sd[1]) for each in outlooks.values())],
        ["sd of scale x y z",
         *("  ".join(relative(x) for x in each.sd[2]) for each in outlooks.values())],
    ]
    return rows


def _seen(
    prospect: Prospect, asked: Sequence[Effect], full_scale: float
) -> Iterator[str]:
    """What these poses cannot see or tell apart, and the block to record for it."""
    if prospect.blind:
        yield f"  cannot see: {', '.join(prospect.blind)}"
    for name, (seen, of) in prospect.partly.items():
        yield f"  sees {seen} of the {of} parameters of {name}"
    for group in prospect.aliases:
        yield f"  cannot tell apart: {', '.join(group)}"
    for name, reason in prospect.absent.items():
        yield f"  cannot judge {name}: {reason}"
    for effect in asked:
        rivals = [group for group in prospect.aliases if effect.name in group]
        if effect.name in prospect.absent:
            continue
        if effect.name not in prospect.blind and not rivals:
            yield f"  {effect.name}: these poses show it, and nothing listed looks like it"
            continue
        advice = best_block(prospect.fit, [Rival(effect, None)], full_scale)
        yield (f"  for {effect.name} record: {advice.says}" if advice else
               f"  for {effect.name} no further poses help: {effect.page.separates}")
