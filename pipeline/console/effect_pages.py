"""The catalogue of effects as text: the list, and a page for each effect."""

import sys
import textwrap
from collections.abc import Iterable, Iterator

from calib.effects.catalogue import UnknownEffect, find_effect
from calib.effects.effect import EFFECTS, Effect
from pipeline.errors import ConfigError
from pipeline.text.names import nearest_name
from pipeline.text.tables import table_lines
from vision.rate.term_pages import TERM_PAGES
from vision.rate.terms import MEANING, TERMS, UNITS

WIDTH = 92  #: characters of a page that is not shown on a terminal; chosen
PLACES = {
    "reading": "the raw reading: it is one of the nine parameters of the linear form",
    "sensor": "the corrected vector; all effects are fitted jointly",
    "reference": "the reference (the rate of the plate, or gravity), not the sensor",
    "noise": "the sds: its coefficients are drawn, their size is estimated, nothing is corrected",
}


def catalogue_lines() -> Iterator[str]:
    """Every listed effect under the heading of its module, with its formula."""
    by_module: dict[str, list[Effect]] = {}
    for effect in EFFECTS.values():
        by_module.setdefault(effect.columns.__module__, []).append(effect)
    for module, effects in by_module.items():
        yield (sys.modules[module].__doc__ or module).strip().splitlines()[0]
        yield from table_lines([[e.name, _triads(e), e.page.formula] for e in effects])
        yield ""
    yield "Bias proportional to a logged column."
    yield from table_lines([["column:NAME", "all", "e_k = c_k · NAME"]])
    yield ""
    yield "Terms of the plate's phase (pipeline add CONFIG rate.SETTING.TERM)."
    yield from table_lines([[term, MEANING[term]] for term in TERMS])
    yield ""
    yield "`pipeline effects NAME` prints the page of an effect."


def _triads(effect: Effect) -> str:
    return " ".join(effect.only_for) or "all"


def page_lines(name: str, width: int = WIDTH) -> Iterator[str]:
    """One effect's page in lines of at most ``width`` columns.

    Raises
    ------
    ConfigError
        No effect has this name.
    """
    if name in TERMS:
        yield name
        yield from textwrap.wrap(f"A term of the plate's phase: {MEANING[name]}.", width)
        yield ""
        term = TERM_PAGES[name]
        yield from _wrapped((
            ("formula", term.formula), ("parameters", f"in {UNITS[name]}"),
            ("typical size", term.typical), ("source", term.source),
            ("confused with", term.confounded), ("separated by", term.separates)), width)
        yield ""
        yield f"Add it with: pipeline add CONFIG rate.SETTING.{name}"
        return
    try:
        effect = find_effect(name)
    except UnknownEffect as error:
        near = nearest_name(name, [*EFFECTS, *TERMS])
        raise ConfigError(f"no effect is named '{name}'{near}; `pipeline effects` lists all "
                          f"effects.") from error
    yield effect.name
    yield from textwrap.wrap(effect.physics, width)
    yield ""
    page = effect.page
    typical = "; ".join(f"{part}: {size}" for part, size in page.typical.items())
    parameters = f"{', '.join(effect.parameters)}  [{_units(effect)}]"
    if effect.shape is not None:
        parameters += f", and the shape parameter {effect.shape.name} [{effect.shape.unit}]"
    yield from _wrapped((
        ("formula", page.formula),
        ("parameters", parameters),
        ("acts on", f"{_triads(effect)}: {PLACES[effect.acts_on]}"),
        ("typical size", typical or "depends on the column"),
        ("source", page.source),
        ("confused with", page.confounded),
        ("separated by", page.separates),
    ), width)
    if effect.acts_on != "reading":
        yield ""
        yield f"Add it with: pipeline add CONFIG {effect.triads[0]}.{effect.name}"


def _wrapped(facts: Iterable[tuple[str, str]], width: int) -> Iterator[str]:
    """Titles and texts, the texts wrapped beside their titles."""
    for title, text in facts:
        yield from textwrap.wrap(text, width, initial_indent=f"{title:<14} ",
                                 subsequent_indent=" " * 15)


def _units(effect: Effect) -> str:
    units = list(dict.fromkeys(effect.unit_for(triad) for triad in effect.triads))
    return " or ".join(units)
