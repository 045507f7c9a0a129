"""Other models of a triad, each fitted exactly to the same poses, for the tick boxes.

The page carries a table of them (:mod:`pipeline.report.triad.refit_table`); ``pipeline open`` makes
any.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from calib.effects.catalogue import UnknownEffect, find_effect
from calib.effects.effect import Effect
from calib.errors import CalibrationError
from calib.fit.least_squares.result import MISFIT_P_VALUE, Fit
from calib.fit.least_squares.solver import extend, fit
from calib.fit.model import Model
from calib.fit.triad.calibration import TriadCalibration, calibrate_triad
from calib.fit.validation.leave_one_out import Comparison, compare
from pipeline.console.parameter_text import shown_effects
from pipeline.results.json_values import Json
from pipeline.stages.triads import TriadResult
from pipeline.text.formatting import DISPLAY, with_minus_signs

RefitOf = Callable[[Sequence[str]], "Refitted | None"]
"""Gives one triad with these added effects; None where its poses do not determine them."""


@dataclass(frozen=True, eq=False)
class Refitted:
    """A model fitted to the poses of a triad, and its comparison with them."""

    calibration: TriadCalibration
    comparison: Comparison

    @property
    def fit(self) -> Fit:
        """The fit, with widened sds."""
        return self.calibration.fit

    @property
    def added(self) -> tuple[str, ...]:
        """Names of the effects of the model beyond bias, scale and misalignment."""
        return tuple(e.name for e in self.fit.model.effects if e.acts_on != "reading")


class Refits:
    """Fits of one triad with any of its effects, each made when first needed.

    Parameters
    ----------
    result : TriadResult
        The triad as it was run.
    """

    def __init__(self, result: TriadResult) -> None:
        self.result = result
        self.run = Refitted(result.calibration, result.comparison)
        self.defined = result.made_from.defined
        self.robust = result.made_from.section.loss == "huber"
        self._known: dict[frozenset[str], Refitted | None] = {frozenset(self.run.added): self.run}

    def of(self, names: Sequence[str]) -> Refitted | None:
        """The triad with these added effects; None where its poses do not determine them."""
        key = frozenset(names)
        if key not in self._known:
            self._known[key] = self._made(tuple(dict.fromkeys(names)))
        return self._known[key]

    def flipped(self, *names: str) -> Refitted | None:
        """The run's model with these effects added, or without those that it contains."""
        return self.of(toggled(self.run.added, names))

    def effect(self, name: str) -> Effect | None:
        """The effect of this name; None for a hypothesis without columns, such as a bad pose."""
        in_model = {e.name: e for e in self.run.fit.model.effects} | dict(self.defined)
        try:
            return in_model.get(name) or find_effect(name)
        except UnknownEffect:
            return None

    def _made(self, names: tuple[str, ...]) -> Refitted | None:
        whole = self.run.fit.model
        model = Model(tuple(e for e in whole.effects if e.acts_on == "reading" or e.name in names))
        effects = [self.effect(name) for name in names if name not in whole.names]
        more = [effect for effect in effects if effect is not None]
        if len(more) < len(effects):
            return None
        try:
            if model == whole and len(more) > 1:
                joint = extend(self.run.fit, more)
            elif len(more) + len(whole.effects) - len(model.effects) > 1:
                joint = extend(fit(self.run.fit.poses, model, robust=self.robust), more)
            else:  # as `pipeline add` fits it, to the last digit
                joint = fit(self.run.fit.poses, Model((*model.effects, *more)), robust=self.robust)
            if joint.dof < 1:
                return None
            calibration = calibrate_triad(joint, self.run.calibration.spec)
            return Refitted(calibration, compare(joint))
        except (CalibrationError, np.linalg.LinAlgError):
            return None


def toggled(names: Sequence[str], flips: Sequence[str]) -> tuple[str, ...]:
    """``names`` with those of ``flips`` added at the end, or removed if they are among them.

    >>> toggled(("a", "b"), ("b", "c"))
    ('a', 'c')
    """
    return (*(name for name in names if name not in flips),
            *(name for name in flips if name not in names))


def refitted_json(refitted: Refitted) -> Json:
    """The figures of one model for the page, in the shown unit of the triad."""
    fit, comparison = refitted.fit, refitted.comparison
    factor = DISPLAY[fit.poses.triad][1]
    return {
        "rms": comparison.residual_rms * factor,
        "loo": comparison.loo_rms * factor,
        "chi2": fit.chi2,
        "dof": fit.dof,
        "explained": bool(fit.p_value >= MISFIT_P_VALUE),
        "residual": [pose.residual * factor for pose in comparison.poses],
        "sizes": size_rows(refitted.calibration),
        "unseen": [name for name, where in fit.model.slices().items()
                   if not fit.basis[where].any()],
    }


def size_rows(calibration: TriadCalibration) -> list[list[str]]:
    """Parameter, size ± sd and unit of every added effect, as texts."""
    rows = []
    for shown in shown_effects(calibration):
        effect = shown.effect
        rows += [[f"{effect.name} {parameter}", with_minus_signs(size), shown.unit]
                 for parameter, size in zip(effect.parameters, shown.values, strict=True)]
        if effect.shape is not None and shown.shape is not None:
            rows.append([f"{effect.name} {effect.shape.name}", with_minus_signs(shown.shape),
                         effect.shape.unit])
    return rows
