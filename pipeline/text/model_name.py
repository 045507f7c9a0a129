"""How a model is called: by what was added to the nine parameters."""

from collections.abc import Sequence

from calib.effects.catalogue import BASE


def short_model(names: Sequence[str]) -> str:
    """A model's name: the paper's nine parameters, and what was added to them."""
    added = [f"+ {name}" for name in names if name not in BASE]
    base = [name for name in names if name in BASE]
    stem = "base" if set(base) == set(BASE) else " ".join(base)
    return " ".join([stem, *added]).strip()
