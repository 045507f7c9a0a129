"""Data of the tick boxes: exact refits with every effect, and judgements of a tick in words.

Each is made with the one solver, a single effect exactly as ``pipeline add`` fits it. The script of
the page looks up the ticked set; more effects at once are refitted by ``pipeline open``.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
from scipy.special import fdtrc, ndtri

from calib.diagnosis.next_measurement.advice import pose_in_words, shown_name
from calib.diagnosis.verdict.decision import Code
from calib.diagnosis.verdict.ranking import Candidate
from calib.diagnosis.verdict.wording import what_separates
from calib.fit.least_squares.result import MISFIT_P_VALUE
from pipeline.drawings.charts import NICE
from pipeline.report.page_templates import rounded
from pipeline.report.triad.charts import SHOWN_SD
from pipeline.report.triad.refitted import RefitOf, Refits, Refitted, refitted_json, toggled
from pipeline.results.json_values import Json
from pipeline.stages.triads import FRAME, TriadResult
from pipeline.text.formatting import DISPLAY
from pipeline.text.names import command

PAIRED = 4
"""Number of the most probable effects that have a refit of every pair, in a triad that lacks
something. Chosen: the tables of the tutorial cost a run 0.3 s of one core."""
CONSTANTS: Json = {"shown_sd": SHOWN_SD, "nice": NICE}
"""Levels that the page's script shares with the charts."""
BLIND_REASON = (
    "these poses cannot determine it: bias, scale, misalignment and the effects in the model have "
    "the same signature, or these poses would show it only at a size that no sensor has"
)


def refit_json(refits: Refits, config: Path) -> Json:
    """Data of the boxes of one triad; its commands change ``config``."""
    result, fit = refits.result, refits.run.fit
    unit, factor = DISPLAY[result.triad]
    names = tickable(refits)
    listed = result.diagnosis.listed
    guesses = [name for name in names if result.diagnosis.is_guess(name)]
    entries = [_box_json(name, listed.get(name), refits, name in guesses) for name in names]
    paired = 0 if result.diagnosis.verdict is Code.NOTHING_MISSING else PAIRED
    rows = []
    for ticked in _sets(refits.run.added, names, paired):
        refitted = refits.of(ticked)
        row: Json = {"failed": True}
        if refitted is not None:
            row = refitted_json(refitted)
            row |= {"residual": rounded(row["residual"])} | changes_json(
                refits.of, refits.run.added, ticked, refitted, config, guesses)
        rows.append(row | {"ticked": sorted(names.index(name) for name in ticked)})
    return {
        "triad": result.triad,
        "unit": unit,
        "labels": list(fit.poses.label),
        "shown": [shown_name(label) for label in fit.poses.label],
        "named": [pose_in_words(fit, label) for label in fit.poses.label],
        "several_rows": [bool(count > 1) for count in fit.equations.row_count],
        "sd": rounded(pose.sd * factor for pose in result.comparison.poses),
        "left_out": rounded(pose.left_out * factor for pose in result.comparison.poses),
        "effects": entries + list(_unseen(result)),
        "refits": rows,
    }


def tickable(refits: Refits) -> list[str]:
    """Effects with a box: those of the model, then the candidates, the most probable first."""
    return [name for name in dict.fromkeys([*refits.run.added, *refits.result.diagnosis.listed])
            if name in refits.run.added or refits.flipped(name) is not None]


def _sets(
    added: tuple[str, ...], names: Sequence[str], paired: int
) -> Iterator[tuple[str, ...]]:
    """The run's model, one and two changes of it, and its first effects, one to all."""
    flips = [(), *((name,) for name in names), *combinations(names[:paired], 2)]
    sets = [toggled(added, flip) for flip in flips]
    sets += [added[:k] for k in range(len(added))]
    yield from {frozenset(one): one for one in sets}.values()


def _box_json(
    name: str, candidate: Candidate | None, refits: Refits, is_guess: bool
) -> Json:
    effect = refits.effect(name)
    assert effect is not None
    # Share of chi² that the effect alone removes; 0 where noise alone could.
    share = (candidate.chi2_drop / refits.run.fit.chi2
             if candidate is not None and candidate.p_value < MISFIT_P_VALUE else 0.0)
    return {
        "name": name,
        "physics": effect.physics,
        "separates": effect.page.separates,
        "in_model": name in refits.run.added,
        "share": share,
        "aliases": [] if candidate is None else list(candidate.aliases),
        "guess": is_guess,
        "reason": None,
    }


def _unseen(result: TriadResult) -> Iterator[Json]:
    """Effects that cannot be ticked, and the reasons."""
    for name in result.diagnosis.blind:
        if name == FRAME and result.frame is not None:
            yield _grey(name, "it is a parameter already: the rotation to the accelerometer", "")
        else:
            yield _grey(name, BLIND_REASON, what_separates(name, result.triad))
    for name, reason in result.diagnosis.unavailable.items():
        yield _grey(name, reason, "")


def _grey(name: str, reason: str, separates: str) -> Json:
    return {
        "name": name, "reason": reason, "separates": separates, "in_model": False, "aliases": []
    }


UNCHANGED = 5e-4  #: relative change of the leave-one-out error that the page calls none; layout
SMALLEST_P_VALUE = 1e-300  #: below it the root of the fall of chi-square is shown; a computer's
MUCH_LEFT = 0.1
"""Share of a misfit beyond noise that an effect leaves, from which it may stand for another one. A
judgement: of two effects as large as each other either leaves half."""
BESIDE_MISFIT_SD = 1.0
"""Sds from which an effect beside a large misfit is called unseen, not absent. A judgement."""


def changes_json(
    refit_of: RefitOf, run: Sequence[str], ticked: Sequence[str], refitted: Refitted, config: Path,
    guesses: Collection[str],
) -> Json:
    """Judgements of the effects that were ticked or unticked, and the recommended commands.

    The removal of an effect is always possible.

    Parameters
    ----------
    refit_of : callable
        Gives the fit with other added effects.
    run : sequence of str
        The added effects of the run's model.
    ticked : sequence of str
        The added effects that are ticked.
    refitted : Refitted
        The fit with these.
    config : Path
        The file that commands name.
    guesses : collection of str
        Effects that `add` refuses unless the user insists.
    """
    triad = refitted.fit.poses.triad
    judgements, commands = [], []
    for name in toggled([n for n in run if n not in ticked], [n for n in ticked if n not in run]):
        other = refit_of(toggled(ticked, [name]))
        is_ticked, in_model = name in ticked, name in run
        target = (config, f"{triad}.{name}")
        judged = None if other is None else judged_effect(
            name, *((refitted, other) if is_ticked else (other, refitted)))
        if judged is not None:
            is_good = None if judged.helps and judged.leaves_much else in_model != judged.helps
            judgements.append({"text": judged.text(in_model, is_ticked), "good": is_good})
        if in_model:
            commands.append(command("remove", *target))
        elif judged is not None and judged.helps:
            commands.append(command("add", *target,
                                    *(["--anyway"] if name in guesses else [])))
    return {"judgements": judgements, "commands": commands}


@dataclass(frozen=True)
class Judgement:
    """Whether an effect is there, judged by the fits with and without it.

    ``is_there`` : noise would explain the fall of chi-square in fewer than one case in 200;
    ``in_sd`` are the sds of one normal number that is as improbable; ``change`` is that of the
    leave-one-out error with the effect, relative; ``misfit`` : something remains unexplained;
    ``leaves_much`` : more than ``MUCH_LEFT`` of what was.
    """

    name: str
    in_sd: float
    is_there: bool
    change: float
    misfit: bool
    leaves_much: bool

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
        if self.helps and self.leaves_much:
            return f"{size}: it is there, or stands for what is still unexplained; {loo}."
        if self.helps:
            return f"{size}: it is there; {loo}."
        if self.is_there:
            return f"{size}, but {loo}: the model predicts worse with it."
        # Beside a large misfit an effect of a few sds can still prove to be there.
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
    # Where noise does not explain the residual, its scatter is the measure, as for the sds.
    misfit = fit.p_value < MISFIT_P_VALUE
    ratio = drop / count / (fit.chi2 / fit.dof if misfit else 1.0)
    p_value = fdtrc(count, fit.dof if misfit else fit.poses.noise_dof, ratio)
    in_sd = -ndtri(p_value / 2) if p_value > SMALLEST_P_VALUE else np.sqrt(count * ratio)
    unexplained = [each.fit.chi2 - each.fit.dof for each in (without, with_it)]
    return Judgement(name, float(in_sd), bool(p_value < MISFIT_P_VALUE),
                     with_it.comparison.loo_rms / without.comparison.loo_rms - 1, bool(misfit),
                     bool(misfit and unexplained[1] > MUCH_LEFT * unexplained[0]))


def _percent(share: float) -> str:
    size = abs(100 * share)
    if size >= 1000:
        return f"{1 + abs(share):.3g}-fold"
    return f"by {size:.0f} %" if size >= 10 else f"by {size:.2g} %"
