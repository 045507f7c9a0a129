"""The catalogue of effects as a person reads it: the list, and a page that teaches each."""

import sys
import textwrap
from collections.abc import Iterator

from calib.effects.catalogue import UnknownEffect, find_effect
from calib.effects.effect import EFFECTS, Effect
from calib.poses.imu_log import TRIADS
from pipeline.errors import ConfigError
from pipeline.formatting import aligned
from pipeline.names import nearest_name
from vision.rate.terms import MEANING, TERMS

WIDTH = 92
PLACES = {
    "reading": "on the raw reading: part of the nine parameters of the linear form",
    "sensor": "on the corrected vector, fitted jointly with everything else",
    "reference": "on the reference: the plate's rate or gravity, not the sensor",
}

def catalogue_lines() -> Iterator[str]:
    """Every listed effect under the heading of its module, with its formula."""
    by_module: dict[str, list[Effect]] = {}
    for effect in EFFECTS.values():
        by_module.setdefault(effect.columns.__module__, []).append(effect)
    for module, effects in by_module.items():
        yield (sys.modules[module].__doc__ or module).strip().splitlines()[0]
        yield from aligned([[e.name, _triads(e), e.page.formula] for e in effects])
        yield ""
    yield "Follows a logged column."
    yield from aligned([["column:NAME", "both", "e_k = c_k · NAME"]])
    yield ""
    yield "Terms of the phase track (pipeline add CONFIG rate.SETTING.TERM)."
    yield from aligned([[term, MEANING[term]] for term in TERMS])
    yield ""
    yield "pipeline effects NAME explains one."


def _triads(effect: Effect) -> str:
    return "both" if effect.triads == TRIADS else " ".join(effect.triads)


def page_lines(name: str) -> Iterator[str]:
    """One effect's page.

    Raises
    ------
    ConfigError
        No effect has this name.
    """
    if name in TERMS:
        yield from textwrap.wrap(f"{name}, a term of the phase track: {MEANING[name]}.", WIDTH)
        yield f"Add it with: pipeline add CONFIG rate.SETTING.{name}"
        return
    try:
        effect = find_effect(name)
    except UnknownEffect as error:
        near = nearest_name(name, [*EFFECTS, *TERMS])
        raise ConfigError(f"no effect is named '{name}'{near}; `pipeline effects` lists them "
                          f"all.") from error
    yield effect.name
    yield from textwrap.wrap(effect.physics, WIDTH)
    yield ""
    page = effect.page
    typical = "; ".join(f"{part}: {size}" for part, size in page.typical.items())
    parameters = f"{', '.join(effect.parameters)}  [{_units(effect)}]"
    if effect.shape is not None:
        parameters += f", and {effect.shape.name} [{effect.shape.unit}], fitted too"
    for title, text in (
        ("formula", page.formula),
        ("parameters", parameters),
        ("acts on", f"{_triads(effect)}; {PLACES[effect.acts_on]}"),
        ("typical size", typical or "depends on the column"),
        ("source", page.source),
        ("confused with", page.confounded),
        ("told apart by", page.separates),
    ):
        yield from textwrap.wrap(text, WIDTH, initial_indent=f"{title:<14} ",
                                 subsequent_indent=" " * 15)
    if effect.acts_on != "reading":
        yield ""
        yield f"Add it with: pipeline add CONFIG {effect.triads[0]}.{effect.name}"


def _units(effect: Effect) -> str:
    units = list(dict.fromkeys(effect.unit_for(triad) for triad in effect.triads))
    return " or ".join(units)
