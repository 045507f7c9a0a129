"""Planned poses that cannot determine the model are refused before the first is recorded."""

from collections.abc import Sequence
from pathlib import Path

from calib.errors import Undetermined
from calib.poses.imu_log import TRIADS
from pipeline.config.load import Config
from pipeline.plan.outlook import TriadPlan, plan_of


def require_planned(config: Config) -> None:
    """Refuse a recording that would end, complete, in poses that do not determine the model.

    Without a section ``record`` nothing is planned. Runs no Python: effects that are written in it
    are left out of the model that is judged.

    Raises
    ------
    Undetermined
        With what is missing, and what to change.
    ConfigError, UnreadableInput
        As :func:`pipeline.plan.outlook.plan_of`.
    """
    if config.record is None:
        return
    require_sufficient(config.source.path, tuple(plan_of(_without_python(config))))


def require_sufficient(path: Path, plans: Sequence[TriadPlan], *, reasons: bool = True) -> None:
    """Refuse plans whose poses, recorded and missing, do not determine the model.

    Without ``reasons``, which were printed already, the message is one line.

    Raises
    ------
    Undetermined
        With what is missing, and what to change.
    """
    refused = {plan.triad: plan.complete for plan in plans if isinstance(plan.complete, str)}
    if refused:
        why = " ".join(refused.values()) if reasons else f"({' and '.join(refused)})"
        raise Undetermined(
            f"{path}: the planned poses will not determine the model{':' * reasons} {why}"
            f"{'' if reasons else '.'} Record more poses (`record: {{poses: 18}}`), add a plate "
            f"setting, or fit a smaller model; `pipeline plan` shows what each would give.")


def _without_python(config: Config) -> Config:
    written = {name for name, effect in config.effects.items() if effect.python is not None}
    kept = {name: effect for name, effect in config.effects.items() if name not in written}
    changes: dict[str, object] = {"effects": kept}
    for triad in TRIADS:
        section = getattr(config, triad)
        if section is not None:
            model = tuple(name for name in section.model if name not in written)
            changes[triad] = section.model_copy(update={"model": model})
    return config.model_copy(update=changes)
