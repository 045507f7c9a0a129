"""The catalogue: importing this module registers every listed effect, in the order shown."""

from calib.effects import base as base_effects
from calib.effects import environment as environment_effects
from calib.effects import motion as motion_effects
from calib.effects import nonlinear as nonlinear_effects
from calib.effects import reference as reference_effects
from calib.effects.effect import EFFECTS, Effect, column_effect
from calib.errors import CalibrationError

ROOMS = (base_effects, nonlinear_effects, environment_effects, motion_effects, reference_effects)
BASE = ("bias", "scale", "misalignment")


class UnknownEffect(CalibrationError):
    """No effect has this name; carries ``name``."""

    def __init__(self, name: str) -> None:
        super().__init__(f"no effect is named '{name}'; `pipeline effects` lists them all")
        self.name = name


def find_effect(name: str) -> Effect:
    """The effect called ``name``; ``column:NAME`` makes a bias that follows the logged column."""
    if name in EFFECTS:
        return EFFECTS[name]
    if name.startswith("column:") and len(name) > len("column:"):
        return column_effect(name.removeprefix("column:"))
    raise UnknownEffect(name)
