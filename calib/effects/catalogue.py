"""The catalogue: importing this module registers the effects of every module in this folder.

The registry ``EFFECTS`` is the one list of effects. A new effect is a decorated function in a
module of this folder, a new one or one that is there; nothing else names it.
"""

import pkgutil
from importlib import import_module

from calib import effects
from calib.effects.effect import EFFECTS, OF_COLUMN, Effect, column_effect
from calib.errors import CalibrationError, Remedy

for _module in pkgutil.iter_modules(effects.__path__):  # in the order of their names
    if _module.name != "catalogue":
        import_module(f"{effects.__name__}.{_module.name}")

__all__ = ["BASE", "EFFECTS", "UnknownEffect", "find_effect"]

BASE = ("bias", "scale", "misalignment")


class UnknownEffect(CalibrationError):
    """No effect has this name; carries ``name``."""

    def __init__(self, name: str) -> None:
        super().__init__(f"no effect is named '{name}'", Remedy("list_effects"))
        self.name = name


def find_effect(name: str) -> Effect:
    """The effect called ``name``; ``column:NAME`` makes a bias that follows the logged column.

    Parameters
    ----------
    name : str

    Returns
    -------
    Effect

    Raises
    ------
    UnknownEffect
        No effect has this name.
    """
    if name in EFFECTS:
        return EFFECTS[name]
    if name.startswith(OF_COLUMN) and name != OF_COLUMN:
        return column_effect(name.removeprefix(OF_COLUMN))
    raise UnknownEffect(name)
