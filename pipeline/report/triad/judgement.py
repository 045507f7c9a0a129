"""Whether an effect is there: what a tick is worth, in words, and the command that writes it."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.special import fdtrc

from calib.fit.least_squares.result import MISFIT_P_VALUE
from pipeline.report.triad.refitted import RefitSource, Refitted, toggled
from pipeline.results.json_values import Json
from pipeline.text.commands import command

UNCHANGED = 5e-4  #: relative change of the leave-one-out error that the page calls none; layout
BESIDE_MISFIT_SD = 1.0
"""Sds from which an effect beside a large misfit is called unseen and not absent. A judgement."""


def changes_json(
    refits: RefitSource, ticked: Sequence[str], refitted: Refitted, config: Path,
    guesses: Collection[str],
) -> Json:
    """Judgements of the effects that were ticked or unticked, and the commands that are worth it.

    Taking an effect out again is always possible.

    Parameters
    ----------
    refits : RefitSource
    ticked : sequence of str
        The added effects that are ticked.
    refitted : Refitted
        The fit with these.
    config : Path
        The file that commands name.
    guesses : collection of str
        Effects that look like others and that no verdict names.
    """
    run, triad = refits.added, refitted.fit.poses.triad
    judgements, commands = [], []
    for name in toggled([n for n in run if n not in ticked], [n for n in ticked if n not in run]):
        other = refits.of(toggled(ticked, [name]))
        is_ticked, in_model = name in ticked, name in run
        target = (config, f"{triad}.{name}")
        judged = None if other is None else judged_effect(
            name, *((refitted, other) if is_ticked else (other, refitted)))
        if judged is not None:
            judgements.append({"text": judged.text(in_model, is_ticked),
                               "good": in_model != judged.helps})
        if in_model:
            commands.append(command("remove", *target))
        elif judged is not None and judged.helps:
            commands.append(command("add", *target,
                                    *(["--anyway"] if name in guesses else [])))
    return {"judgements": judgements, "commands": commands}


@dataclass(frozen=True)
class Judgement:
    """Whether an effect is there, by what leaving it out does to the fit that contains it.

    ``is_there`` : noise would explain the fall of chi-square in fewer than one case in 200;
    ``change`` is that of the leave-one-out error with the effect, relative.
    """

    name: str
    in_sd: float
    is_there: bool
    change: float
    misfit: bool

    @property
    def helps(self) -> bool:
        """The effect is there, and the model predicts better with it."""
        return self.is_there and self.change < 0

    def text(self, in_model: bool, ticked: bool) -> str:
        """The judgement in words; ``in_model`` of the run, ``ticked`` on the screen."""
        size = f"{self.name}: {self.in_sd:.{1 if self.in_sd < 9.95 else 0}f} sd"
        loo = ("leave-one-out does not change" if abs(self.change) < UNCHANGED else
               f"leave-one-out {'rises' if self.change > 0 else 'falls'} {_percent(self.change)}")
        if in_model and not ticked:
            return (f"{size}: it is there. With it {loo}; keep it." if self.helps
                    else f"{size}: not there. With it {loo}; remove it.")
        if self.helps:
            return f"{size}: it is there; {loo}."
        if self.is_there:
            return f"{size}, but {loo}: the model predicts worse with it."
        # Beside a large misfit an effect of a few sds can still turn out to be there.
        open_ = self.misfit and self.in_sd > BESIDE_MISFIT_SD
        return f"{size}: {'not seen beside what remains unexplained' if open_ else 'not there'}; " \
               f"{loo}."


def judged_effect(name: str, with_it: Refitted, without: Refitted) -> Judgement | None:
    """The judgement of one effect; None where it adds no parameter that these poses see."""
    count = without.fit.dof - with_it.fit.dof
    if count < 1:
        return None
    fit = with_it.fit
    drop = max(without.fit.chi2 - fit.chi2, 0.0)
    # Where noise does not explain what remains, that scatter is the measure, as for the sds.
    misfit = fit.p_value < MISFIT_P_VALUE
    ratio = drop / count / (fit.chi2 / fit.dof if misfit else 1.0)
    p_value = fdtrc(count, fit.dof if misfit else fit.poses.noise_dof, ratio)
    return Judgement(name, float(np.sqrt(ratio)), bool(p_value < MISFIT_P_VALUE),
                     with_it.comparison.loo_rms / without.comparison.loo_rms - 1, bool(misfit))


def _percent(share: float) -> str:
    size = abs(100 * share)
    if size >= 1000:
        return f"{1 + abs(share):.3g}-fold"
    return f"by {size:.0f} %" if size >= 10 else f"by {size:.2g} %"
