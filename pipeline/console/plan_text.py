"""Output of ``pipeline plan``: expected results of a session's poses, for people and programs."""

from collections.abc import Iterator, Sequence
from functools import partial
from math import degrees
from typing import Any

from calib.diagnosis.next_measurement.advice import settling_block
from calib.diagnosis.next_measurement.chance import Rival, chance_of_a_name
from calib.effects.catalogue import find_effect
from calib.effects.effect import EFFECTS, OF_COLUMN, Effect
from calib.numbers import RPM
from calib.planning.prospect import Prospect
from calib.poses.attitudes import direction_name
from calib.poses.runs.ideal_ring import ADVISED_TILT
from pipeline.plan.outlook import TriadPlan
from pipeline.plan.settings import PlannedSetting
from pipeline.text.formatting import DISPLAY, relative
from pipeline.text.tables import table_lines

NOISE = {
    "measured": "noise of the recorded poses",
    "typical": "typical noise of this sensor; that of your sensor may differ by a factor of two",
    "unknown": "unknown noise: the sds need at least one recorded pose",
}
MEANING = ("condition: the 18 wedge poses have 1.4, the limit is 25; D-efficiency: information per "
           "pose, the 18 wedge poses have 1")


def plan_lines(plan: TriadPlan, effects: Sequence[Effect], full_scale: float) -> Iterator[str]:
    """Output of ``pipeline plan`` for one triad.

    Parameters
    ----------
    plan : TriadPlan
    effects : sequence of Effect
        Effects for which to print the measurement that determines them.
    full_scale : float
        Of the triad, SI.
    """
    missing = sum(len(setting.missing) for setting in plan.settings)
    yield f"{plan.triad}: {plan.recorded} poses recorded, {missing} missing"
    for setting in plan.settings:
        motion = "at rest" if not setting.rate_rad_s else (
            f"at {setting.rate_rad_s / RPM:.4g} rpm")
        yield (f"  {setting.name}: {len(setting.means)} recorded, {len(setting.missing)} missing, "
               f"{setting.seconds:.3g} s each, {motion}{_leaning(setting)}")
        yield from (f"  ignored: {reason}" for reason in setting.unusable)
    yield from (f"  range: {warning}" for warning in plan.saturates)
    yield from (f"  planned without {name}: {reason}" for name, reason in plan.not_planned.items())
    if isinstance(plan.at_hand, str):
        yield f"  recorded: {plan.at_hand}"
    prospects = {"recorded": plan.at_hand, "complete": plan.complete if missing else None}
    outlooks = {name: outlook for name, outlook in prospects.items()
                if isinstance(outlook, Prospect)}
    if isinstance(plan.complete, str) and missing:
        yield f"  complete: {plan.complete}"
    if outlooks:
        yield from table_lines(_figures(plan, outlooks))
        yield f"  ({MEANING})"
        yield f"  ({NOISE[plan.noise]})"
        yield from _determined(list(outlooks.values())[-1], effects, full_scale)
    best = plan.next_pose
    yield (f"  best next pose: {direction_name(best.up)}, plate {best.run}; it reduces all sds by "
           f"{100 * (1 - best.shrinks):.1f} % on average")


def _leaning(setting: PlannedSetting) -> str:
    if not setting.tilt_rad:
        return ""
    if setting.means:
        return f", plate tilted by {degrees(setting.tilt_rad):.1f}°"
    return f"; put {ADVISED_TILT}"


def _figures(plan: TriadPlan, outlooks: dict[str, Prospect]) -> list[list[str]]:
    unit, factor = DISPLAY[plan.triad]
    titles = ["", "degrees of freedom", "condition", "D-efficiency",
              "sd of misalignment x y z [rad]", f"sd of bias x y z [{unit}]", "sd of scale x y z"]
    columns = [titles, *(
        [name, str(outlook.dof), f"{outlook.condition:.2f}", f"{outlook.d_efficiency:.2f}",
         "  ".join(f"{x:.2g}" for x in outlook.sd[0]),
         "  ".join(f"{x * factor:.2g}" for x in outlook.sd[1]),
         "  ".join(relative(x) for x in outlook.sd[2])]
        for name, outlook in outlooks.items())]
    rows = [list(row) for row in zip(*columns, strict=True)]
    return rows[:4] if plan.noise == "unknown" else rows


def _determined(
    prospect: Prospect, effects: Sequence[Effect], full_scale: float
) -> Iterator[str]:
    """Effects that these poses cannot determine or separate, and the poses to record for them."""
    if prospect.blind:
        yield f"  cannot determine: {', '.join(prospect.blind)}"
    if "g_sensitivity" in prospect.blind:
        yield f"  put {ADVISED_TILT}: that shows g_sensitivity at this one speed"
    for name, (visible, total) in prospect.partly.items():
        yield f"  determines {visible} of the {total} parameters of {name}"
    for group in prospect.aliases:
        yield f"  cannot separate: {', '.join(group)}"
    for reason in dict.fromkeys(prospect.absent.values()):
        names = [name for name, why in prospect.absent.items() if why == reason]
        yield f"  cannot test {', '.join(names)}: {reason}"
    for effect in effects:
        rivals = [group for group in prospect.aliases if effect.name in group]
        if effect.name in prospect.absent:
            continue
        if not rivals and effect.name not in (*prospect.blind, *prospect.partly):
            yield f"  {effect.name}: these poses determine it, and tell a large one from all others"
            continue
        named = {effect.name: effect for effect in effects}
        confused = [named.get(name) or find_effect(name) for group in rivals for name in group
                 if name in named or name in EFFECTS or name.startswith(OF_COLUMN)]
        advice = settling_block(
            prospect.fit, partial(chance_of_a_name, rivals=[
                Rival(rival, None) for rival in confused or [effect]]), full_scale)
        yield (f"  for {effect.name} record: {advice.timed}" if advice and advice.is_worth_it else
               f"  for {effect.name} further poses do not help: {effect.page.separates}")


def plan_json(plan: TriadPlan) -> dict[str, Any]:
    """The same output for programs, in SI units; sds are null where the noise is unknown."""
    best = plan.next_pose
    return {
        "settings": [{
            "name": setting.name,
            "rate_rad_s": setting.rate_rad_s,
            "recorded": len(setting.means),
            "missing": len(setting.missing),
            "seconds_per_pose": setting.seconds,
            "tilt_rad": setting.tilt_rad,
            "unusable": setting.unusable,
        } for setting in plan.settings],
        "noise": plan.noise,
        "recorded": _outlook_json(plan.at_hand, plan.noise != "unknown"),
        "complete": _outlook_json(plan.complete, plan.noise != "unknown"),
        "next_pose": {"up": direction_name(best.up), "plate": best.run,
                      "sds_fall_by": 1 - best.shrinks},
        "saturates": plan.saturates,
        "not_planned": dict(plan.not_planned),
    }


def _outlook_json(outlook: Prospect | str | None, noise_known: bool) -> dict[str, Any] | None:
    if outlook is None:
        return None
    if isinstance(outlook, str):
        return {"determined": False, "reason": outlook}
    sds = outlook.sd.tolist() if noise_known else [None, None, None]
    return {
        "determined": True,
        "dof": outlook.dof,
        "condition": outlook.condition,
        "d_efficiency": outlook.d_efficiency,
        "sd_misalignment_rad": sds[0],
        "sd_bias": sds[1],
        "sd_scale_relative": sds[2],
        "cannot_determine": outlook.blind,
        "determines_partly": outlook.partly,
        "cannot_separate": outlook.aliases,
        "cannot_test": outlook.absent,
    }
