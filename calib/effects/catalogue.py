"""The catalogue: importing this module registers the effects of every module in this folder.

The registry ``EFFECTS`` is the one list of effects. A new effect is a decorated function in a new
or existing module of this folder; nothing else names it.
"""

import pkgutil
from collections.abc import Collection
from dataclasses import replace
from functools import partial
from importlib import import_module

from calib import effects
from calib.effects.column import column_effect
from calib.effects.effect import EFFECTS, OF_COLUMN, Effect
from calib.errors import CalibrationError
from calib.spelling import nearest_name

for _module in pkgutil.iter_modules(effects.__path__):  # in alphabetical order
    if _module.name != "catalogue":
        import_module(f"{effects.__name__}.{_module.name}")
for _name in sorted(EFFECTS, key=lambda name: EFFECTS[name].columns.__module__):
    EFFECTS[_name] = EFFECTS.pop(_name)  # whichever module was imported first elsewhere

__all__ = [
    "BASE", "EFFECTS", "REFERENCE_DRIFT", "SECOND_WARM_UP", "STEP", "WARM_UP", "UnknownEffect",
    "find_effect", "further_step",
]

BASE = ("bias", "scale", "misalignment")

REFERENCE_DRIFT = "reference_drift"

STEP = "bias_step"
FURTHER_STEPS = tuple(map(str, range(2, 10)))
"""Numbers of further steps, as in ``bias_step_2``. A limit of size."""


WARM_UP, SECOND_WARM_UP = "warm_up", "warm_up_2"
"""A warm-up, and its second time constant, which is a candidate once the first is in the model."""

SECOND_TAU_S = (75.0, 3400.0, 212.0, 850.0, 1700.0, 425.0)
"""Start values of its time constant, s, between and beyond those of the first. Numerical."""


def further_step(names: Collection[str]) -> str:
    """Name of one more step of the bias beside the effects ``names``."""
    every = (STEP, *(f"{STEP}_{number}" for number in FURTHER_STEPS))
    return next((name for name in every if name not in names), every[-1])


class UnknownEffect(CalibrationError):
    """No effect has this name; the message lists the nearest or all; carries ``name``."""

    def __init__(self, name: str) -> None:
        right = nearest_name(name, EFFECTS) or f"; there are: {', '.join(EFFECTS)}"
        super().__init__(f"no effect is named '{name}'{right}")
        self.name = name


def find_effect(name: str) -> Effect:
    """The effect called ``name``; ``column:NAME`` makes a bias that follows the logged column.

    ``extra_noise:RUN``, ``pose_scatter:RUN`` and ``rate_scatter:RUN`` act in one run.

    Raises
    ------
    UnknownEffect
        No effect has this name.
    """
    if name in EFFECTS:
        return EFFECTS[name]
    if name == SECOND_WARM_UP:
        first = EFFECTS[WARM_UP]
        assert first.shape is not None
        return replace(first, name=name, shape=replace(first.shape, starts=SECOND_TAU_S), physics=(
            "Bias that settles with a second time constant besides that of warm_up: the die "
            "before the board, the board before the case."))
    step, _, number = name.rpartition("_")
    if step == STEP and number in FURTHER_STEPS:
        # At the top it would come before the effects of all other modules in EFFECTS.
        from calib.effects.steps import times_from_elsewhere

        elsewhere = partial(times_from_elsewhere, int(number))
        return replace(EFFECTS[STEP], name=name, starts_in=elsewhere)
    if name.startswith(OF_COLUMN) and name != OF_COLUMN:
        return column_effect(name.removeprefix(OF_COLUMN))
    kind, _, run = name.partition(":")
    if run and kind in EFFECTS and EFFECTS[kind].drawn in ("as_noise", "per_pose"):
        from calib.effects.drawn import in_one_run  # as above

        return in_one_run(EFFECTS[kind], run)
    raise UnknownEffect(name)
