"""A card for every effect: the physics as a drawing, its formula, its fingerprint, its size.

The drawings are macros of ``templates/drawings.html`` by the name of the effect; an effect without
one has the drawing of a user-defined effect.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from typing import Literal

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.verdict.decision import Code
from calib.diagnosis.verdict.ranking import Candidate
from calib.diagnosis.verdict.wording import enumeration
from calib.effects.catalogue import EFFECTS, UnknownEffect, find_effect
from calib.effects.effect import Effect
from calib.effects.units import display_unit
from calib.poses.imu_log import AXES, FloatArray, Triad
from pipeline.report.triad.fingerprint import Fingerprint, fingerprint, fingerprint_svg
from pipeline.report.triad.refitted import Refits
from pipeline.results.json_values import Json
from pipeline.stages.triads import FRAME, TriadResult
from pipeline.text.formatting import with_minus_signs, with_sd

Standing = Literal["missing", "model", "offered", "idle", "unseen", "unavailable"]

STANDINGS: Mapping[Standing, str] = {
    "missing": "missing",
    "model": "in the model",
    "offered": "may be missing",
    "idle": "not named",
    "unseen": "cannot be determined here",
    "unavailable": "not in these logs",
}
EXPANDED: tuple[Standing, ...] = ("missing", "offered", "model")
"""Cards that are open from the start: those of the verdict and of the model."""

CLEAR_SD = 3.0  #: a size beyond this many sds is set in bold
_INDEX = re.compile(r"(?<!\w)([^\W_]\d?)_([A-Za-z]{1,3})(?![A-Za-z0-9_])")


SizeCell = tuple[str, str, bool, float]
"""One parameter: value, sd, whether it is clearly not zero, and its share of the largest."""


def effect_cards(refits: Refits, boxes: Sequence[Json], drawings: Sequence[str]) -> list[Json]:
    """A card for every effect of the triad, the expanded ones first.

    Parameters
    ----------
    refits : Refits
    boxes : sequence of dict
        ``effects`` of :func:`pipeline.report.triad.refit_table.refit_json` of the same triad.
    drawings : sequence of str
        Names of the macros that draw.
    """
    entries = {one["name"]: one for one in boxes}
    cards = [_card(refits, effect, entries, drawings)
             for effect in _effects(refits.result, entries, refits.defined)]
    return sorted(cards, key=lambda card: not card["expanded"])


def _effects(
    result: TriadResult, entries: Mapping[str, Json], defined: Mapping[str, Effect]
) -> Iterator[Effect]:
    """The effects of the page's boxes in their order, then the rest of the catalogue."""
    catalogue = {name: effect for name, effect in EFFECTS.items() if result.triad in effect.triads}
    in_model = {effect.name: effect for effect in result.calibration.fit.model.effects}
    for name in dict.fromkeys([*entries, *defined, *catalogue]):
        try:
            yield in_model.get(name) or defined.get(name) or find_effect(name)
        except UnknownEffect:  # a logged column that is no effect
            continue


def _card(
    refits: Refits, effect: Effect, entries: Mapping[str, Json], drawings: Sequence[str]
) -> Json:
    """View of one effect; ``size`` is None where nothing was fitted."""
    result, entry = refits.result, entries.get(effect.name)
    candidate = result.diagnosis.listed.get(effect.name)
    standing = _standing(result, effect)
    seen = entry is not None and entry["reason"] is None
    shape = fingerprint(refits, effect.name) if seen else None
    named = effect.name if effect.name in drawings else None
    listed = effect.name in EFFECTS
    return {
        "effect": effect,
        "drawing": named or ("column" if effect.names_column else "user_defined"),
        "formula": formula_html(effect.page.formula) if listed else escape(effect.page.formula),
        "standing": standing,
        "status": _status(result, effect, standing),
        "typical": tuple(_typical(effect, result.triad)),
        "size_title": "Size in the model" if standing == "model" else "Size in these poses",
        "size": _size_table(refits, effect, candidate),
        "fingerprint": "" if shape is None else fingerprint_svg(
            shape, effect.name, result.calibration.fit),
        "caption": "" if shape is None else _caption(effect, shape),
        "confused_here": _confused_here(effect, entries),
        "expanded": standing in EXPANDED and effect.acts_on != "reading",
    }


def formula_html(formula: str) -> str:
    """A formula of the catalogue as HTML: a letter after ``_`` is an index.

    >>> formula_html("e_k = K2_k · s_k²")
    'e<sub>k</sub> = K2<sub>k</sub> · s<sub>k</sub>²'
    """
    return _INDEX.sub(r"\1<sub>\2</sub>", escape(formula))


def _standing(result: TriadResult, effect: Effect) -> Standing:
    diagnosis = result.diagnosis
    if effect.name in result.calibration.fit.model.names:
        return "model"
    if effect.name in diagnosis.names:
        return "missing"
    likely = {member for one in diagnosis.inclusion for member in one.members
              if one.probability >= 1 - CONSTANTS.sure}
    if diagnosis.verdict is not Code.NOTHING_MISSING and effect.name in {*likely, *diagnosis.group}:
        return "offered"
    if effect.name in diagnosis.unavailable:
        return "unavailable"
    known = {c.name for c in diagnosis.ranking}
    return "idle" if effect.name in known else "unseen"


def _status(result: TriadResult, effect: Effect, standing: Standing) -> str:
    if effect.name == FRAME and result.frame is not None and standing == "unseen":
        return "a parameter already"
    words = STANDINGS[standing]
    inclusion = next((one for one in result.diagnosis.inclusion
                      if effect.name in one.members), None)
    if standing == "offered" and inclusion is not None:
        return f"{words}, probability {inclusion.probability:.2g}"
    return words


def _caption(effect: Effect, shape: Fingerprint) -> str:
    return (
        f"Bars are rows of the fit, in sds; the band is the noise of ± 1 sd. At its best size "
        f"{effect.name} explains {_per_cent(shape.explained)} of the residual's chi². The other "
        f"parameters leave {_per_cent(shape.visible)} of its signature visible in these poses."
    )


def _per_cent(share: float) -> str:
    return f"{100 * share:.{0 if share >= 0.1 else 1}f} %"


def _confused_here(effect: Effect, entries: Mapping[str, Json]) -> str:
    entry = entries.get(effect.name)
    if entry is None:
        return ""
    if entry["reason"] is not None:
        return f"{entry['reason'][0].upper()}{entry['reason'][1:]}."
    if entry["aliases"]:
        return f"These poses cannot separate it from {enumeration(entry['aliases'], 'or')}."
    parts = [name for name, one in entries.items() if effect.name in one["aliases"]]
    if parts:
        return (f"{enumeration(parts, 'or')} would look like a part of it. These poses separate it "
                f"from every further listed effect.")
    return "These poses separate it from every other listed effect."


# --- sizes -------------------------------------------------------------------------------------


def _size_table(refits: Refits, effect: Effect, candidate: Candidate | None) -> Json | None:
    """The fitted parameters, with those of the boxes for a candidate; None without any.

    They are a table: a row for all, or one for each axis of a matrix. ``shape`` is the shape
    parameter with its sd and unit.
    """
    values, sds = _sizes(refits, effect, candidate)
    k = len(effect.parameters)
    if len(values) < k:
        return None
    unit, factor = display_unit(effect.unit_for(refits.result.triad), list(values[:k]))
    largest = float(np.abs(values[:k]).max()) * factor
    cells = tuple(_cell(value * factor, sd * factor, largest)
                  for value, sd in zip(values[:k], sds[:k], strict=True))
    shape = ""
    if effect.shape is not None and len(values) > k:
        shape = f"{effect.shape.name} = {with_sd(values[k], sds[k])} {effect.shape.unit}"
    if k == len(AXES) ** 2:
        columns = tuple(name[1:] for name in effect.parameters[:3])
        rows = tuple(name[0] for name in effect.parameters[::3])
        table = {"columns": columns, "rows": rows, "cells": (cells[:3], cells[3:6], cells[6:])}
    else:
        table = {"columns": effect.parameters, "rows": ("",), "cells": (cells,)}
    return {"unit": unit, "shape": shape, **table}


def _typical(effect: Effect, triad: Triad) -> Iterator[tuple[str, str]]:
    """Class of parts and its typical size, in the unit of the sizes that were fitted."""
    for part, typical in effect.page.typical.items():
        sizes = [size.within(*display_unit(effect.unit_for(triad), [size.si]))
                 for size in typical.sizes if size.triad in (None, triad)]
        if sizes:
            yield part, ", ".join(sizes) + (f" ({typical.note})" if typical.note else "")
        elif not typical.sizes:
            yield part, typical.note


def _sizes(
    refits: Refits, effect: Effect, candidate: Candidate | None
) -> tuple[FloatArray, FloatArray]:
    """Parameters and sds, SI; the shape parameter last where it was fitted.

    A candidate that is named beside others has the sizes of the refit with all of them.
    """
    calibration, added = refits.run.calibration, refits.run.added
    named = [name for name in refits.result.diagnosis.names if name not in added]
    if candidate is not None and effect.name not in added:
        refitted = refits.flipped(*(named if effect.name in named else [effect.name]))
        calibration = refitted.calibration if refitted is not None else calibration
    if effect.acts_on == "reading" and effect.name in calibration.fit.model.names:
        where = calibration.fit.model.slices()[effect.name]
        sd = np.sqrt(np.diag(calibration.fit.cov))
        return calibration.fit.theta[where], sd[where]
    fitted = calibration.effect_values().get(effect.name)
    if fitted is not None:
        return fitted
    if candidate is None:
        return np.zeros(0), np.zeros(0)
    return candidate.size, candidate.sd


def _cell(value: float, sd: float, largest: float) -> SizeCell:
    share = value / largest if largest > 0 else 0.0
    if not np.isfinite(sd):
        return with_minus_signs(f"{value:.3g}"), "not determined alone", False, share
    text, _, spread = with_minus_signs(with_sd(value, sd)).partition(" ± ")
    return text, f"± {spread}" if spread else "", bool(abs(value) > CLEAR_SD * sd), share
