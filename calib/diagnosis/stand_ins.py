"""Listed effects that these poses cannot separate from an effect of the model."""

from collections.abc import Mapping, Sequence

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.search.table_at import table_at
from calib.effects.catalogue import BASE
from calib.fit.least_squares.result import Fit


def stand_ins(fit: Fit, hypotheses: Sequence[Hypothesis]) -> Mapping[str, tuple[str, ...]]:
    """The effects that ``fit`` was extended by, with those that would do as well in their place.

    Parameters
    ----------
    fit : Fit
    hypotheses : sequence of Hypothesis
        What may be missing beside the model of ``fit``.

    Returns
    -------
    mapping of str to tuple of str
        Of effects that something may stand in the place of: listed effects whose odds against it
        are better than one to twenty, while either is as much better than none.
    """
    listed = [h for h in hypotheses if h.kind == "listed" and not h.is_placed]
    alike: dict[str, tuple[str, ...]] = {}
    for effect in fit.model.effects:
        if effect.name in BASE or effect.acts_on in ("reading", "noise") or effect.drawn:
            continue
        mine = Hypothesis(effect.name, "listed", 0.0, effect, fit.shapes.get(effect.name))
        table = table_at(fit, (mine, *listed), (effect.name,))
        density, _ = table.singles()
        nothing = float(np.logaddexp(*table.noise.nothing(table.chi2)))
        least = max(float(density[0]) - CONSTANTS.told_apart,
                    nothing + CONSTANTS.told_apart)
        others = dict.fromkeys(
            h.name for h, value in sorted(zip(listed, density[1:], strict=True),
                                          key=lambda pair: -pair[1]) if value > least)
        if others:
            alike[effect.name] = tuple(others)
    return alike
