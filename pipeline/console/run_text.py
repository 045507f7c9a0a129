"""A run as text: a line for each stage, the verdict, the effect of a change of model or poses."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from calib.diagnosis.next_measurement.advice import pose_in_words
from calib.diagnosis.unseen import together
from calib.diagnosis.verdict.decision import Code
from calib.effects.catalogue import EFFECTS, UnknownEffect, find_effect
from calib.effects.typical import largest_for
from calib.effects.units import display_unit
from calib.fit.triad.within_poses import LEAST_SHARE
from calib.mounting.mounting import Mounting
from calib.rounding import in_digits, two_digits
from pipeline.console.parameter_text import effect_rows, mounting_text, shown_effects
from pipeline.model_change import ModelChange, result_of
from pipeline.results.json_values import logged_unit
from pipeline.results.triad import WORST_POSES
from pipeline.stages.rate import SettingRate
from pipeline.stages.recordings import Recordings
from pipeline.stages.run import Outcome
from pipeline.stages.triads import TriadResult
from pipeline.text.formatting import DISPLAY, NAME_WIDTH, count, relative
from pipeline.text.tables import table_lines

FEW_POSES = 3.0
"""Leave-one-out error by noise alone, over that noise, from which it is reported: chooses words."""

RANKED = 6  #: candidates that `pipeline diagnose` shows


def recordings_line(recordings: Recordings) -> str:
    """The number of averaged poses; empty if the configuration contains none."""
    every = recordings.by_setting.values()
    poses = sum(len(recording.means) for recording in every)
    excluded = sum(len(recording.excluded) for recording in every)
    without = f", {excluded} excluded" if excluded else ""
    return f"{'logs':<{NAME_WIDTH}} {count(poses, 'pose')} averaged{without}" if poses else ""


def installation_line(mounting: Mounting) -> str:
    """The mounting angles."""
    return f"{'installation':<{NAME_WIDTH}} {mounting_text(mounting)}"


def triad_line(result: TriadResult) -> str:
    """Name, poses, residual, leave-one-out error and chi-square of a triad."""
    return f"{result.triad:<{NAME_WIDTH}} {triad_figures(result)}"


def triad_figures(result: TriadResult) -> str:
    """Poses, residual, leave-one-out error and chi-square of a triad."""
    unit, factor = DISPLAY[result.triad]
    fit, comparison = result.calibration.fit, result.comparison
    runs = len(set(fit.poses.run))
    poses = count(len(fit.poses), "pose") + (f" in {runs} runs" if runs > 1 else "")
    if fit.poses.ring is not None:
        tilts = sorted({f"{np.degrees(tilt):.1f}°" for tilt in fit.poses.ring.tilt_rad})
        poses += f", plate tilted by {' and '.join(tilts)}"
    return (
        f"{poses}, residual {in_digits(comparison.residual_rms * factor, 3)} "
        f"{unit}, leave-one-out {in_digits(comparison.loo_rms * factor, 3)} "
        f"{unit}{loo_by_noise(result)}, "
        f"chi²/dof {fit.chi2 / fit.dof:.2f}"
    )


def loo_by_noise(result: TriadResult) -> str:
    """Leave-one-out error by noise alone, where that is much larger than a residual."""
    noise = float(np.sqrt(np.mean(result.calibration.fit.equations.row_sd**2)))
    if result.comparison.loo_noise < FEW_POSES * noise:
        return ""
    unit, factor = DISPLAY[result.triad]
    size = two_digits(result.comparison.loo_noise * factor)
    return f" ({size} {unit} by noise alone with so few poses)"


def verdict_line(result: TriadResult) -> str:
    """The diagnosis of a triad in words."""
    return f"{result.triad}: {result.diagnosis.text}"


def misfit_lines(result: TriadResult) -> Iterator[str]:
    """Misfit of the model: the largest residuals, and the covariate that they follow."""
    unit, factor = DISPLAY[result.triad]
    fit = result.calibration.fit
    worst = ", ".join(
        f"{pose_in_words(fit, pose.label)} {pose.residual * factor:+.3g} {unit} "
        f"({pose.in_sd:+.1f} sd)"
        for pose in result.comparison.worst(WORST_POSES)
    )
    yield f"  largest residuals: {worst}"
    if result.excluded:
        yield f"  excluded: {', '.join(excluded_words(result))}"
    covariate = leading_covariate(result)
    if covariate is not None:
        yield f"  the misfit follows: {covariate}"


def excluded_words(result: TriadResult) -> Iterator[str]:
    """Every excluded pose with its residual by the fit without it."""
    unit, factor = DISPLAY[result.triad]
    for pose in result.excluded:
        if pose.predicted is None:
            yield f"{pose.label} (no pose of its run)"
            continue
        residual = pose.predicted.residual
        yield (f"{pose.label} {residual.residual * factor:+.3g} {unit} ({residual.in_sd:+.1f} sd "
               f"by the fit without it)")


def leading_covariate(result: TriadResult) -> str | None:
    """The covariate that the misfit follows; None if the verdict names no such cause.

    A misfit of another cause can follow a covariate too, as a by-product of that cause.
    """
    diagnosis = result.diagnosis
    if diagnosis.verdict is Code.UNKNOWN:
        covariates = ("time_s", "spin_rad_s", *result.calibration.fit.poses.columns)
        return diagnosis.name if diagnosis.name in covariates else None
    if diagnosis.verdict is not Code.EFFECT or diagnosis.name is None:
        return None
    try:
        effect = find_effect(diagnosis.name)
    except UnknownEffect:  # a user-defined effect: its expression names its columns
        return None
    if "time" in effect.needs and not effect.logged:
        return "time_s"
    return effect.logged[0] if effect.logged else None


def ranking_lines(result: TriadResult) -> list[str]:
    """The best candidates with their errors after a refit, and what cannot be determined."""
    unit, factor = DISPLAY[result.triad]
    diagnosis = result.diagnosis
    rows = [["candidate", "log evidence", "chi² drop", f"RMS after [{unit}]", "leave-one-out",
             "cannot be separated from"]]
    rows += [
        [
            candidate.name,
            f"{candidate.log_evidence:+.1f}",
            f"{candidate.chi2_drop:.1f}",
            *("-" if math.isnan(error) else in_digits(error * factor, 3)
              for error in (candidate.rms_after, candidate.loo_after)),
            ", ".join(candidate.aliases),
        ]
        for candidate in diagnosis.ranking[:RANKED]
    ]
    lines = table_lines(rows)
    for name, size in limit_rows(result)[:RANKED]:
        lines.append(f"  at 95 % no larger than: {name} {size}")
    if result.undetermined:
        lines.append(f"  these data cannot determine: {', '.join(result.undetermined)}")
    if result.unseen:
        lines.append(f"  {unseen_text(result)}")
    if diagnosis.aside:
        lines.append(f"  {aside_text(diagnosis.aside)}")
    return lines


def unseen_text(result: TriadResult) -> str:
    """Influence on the parameters of effects that these poses cannot see, if they are typical."""
    sds, parameters = together(result.unseen), result.calibration.parameters
    moved = np.any(np.nan_to_num(sds) > LEAST_SHARE * np.nan_to_num(parameters.sd), axis=1).tolist()
    logged = logged_unit(result.triad, result.calibration.spec)
    scale = float(np.nanmax(sds[2] / parameters.scale_counts_per_unit))
    worst = max(result.unseen, key=lambda name: float(np.nanmax(result.unseen[name][2])))
    parts = [
        text for text, is_moved in (
            (f"a scale by up to {relative(scale)} (most by {worst})", moved[2]),
            (f"a bias by {np.nanmax(sds[1]):.2g} {logged}", moved[1]),
            (f"a misalignment by {np.nanmax(sds[0]):.2g} rad", moved[0]),
        ) if is_moved
    ]
    return (f"if your sensor is typical, these move {' and '.join(parts)}, 1 sd; the stated sds do "
            f"not contain that")


def limit_rows(result: TriadResult) -> list[tuple[str, str]]:
    """Effects that were tested and not named, with their upper limits at 95 %.

    An effect is left out if these poses limit it only to a size that no part has.
    """
    rows = []
    for limit in result.diagnosis.limits:
        effect = EFFECTS.get(limit.name)
        if effect is None or limit.value <= largest_for(result.triad, effect.page.typical.values()):
            unit, factor = display_unit(limit.unit, [limit.value])
            rows.append((limit.name, f"{two_digits(limit.value * factor)} {unit}"))
    return rows


def aside_text(columns: Sequence[str]) -> str:
    """Logged columns that the diagnosis does not use, and how to change that."""
    return (
        f"logged columns that the diagnosis does not use, because their names state an attitude, a "
        f"position, a velocity or a clock; `covariates: [{', '.join(columns)}]` in the "
        f"configuration, beside what else may be a cause, lists the columns to use"
    )


def change_lines(change: ModelChange) -> Iterator[str]:
    """The table before → after, the new effect's size ± sd, and the new verdict."""
    before, after = (result_of(outcome, change.target) for outcome in (change.before, change.after))
    if before is not None and after is not None:
        yield from _error_lines(str(change.target), before, after)
        for shown in shown_effects(after.calibration):
            if shown.effect.name == change.target.name:
                yield from table_lines(effect_rows(shown), indent="")
        yield verdict_line(after)
        return
    setting = str(change.target.section[1])
    yield from _rate_lines(setting, change.before, change.after)


def pose_change_lines(before: Outcome, after: Outcome) -> Iterator[str]:
    """The errors before → after of every triad that has other poses, and its new verdict."""
    for one, other in zip(before.triads, after.triads, strict=True):
        poses = [len(each.comparison.poses) for each in (one, other)]
        if poses[1] != poses[0]:
            yield from _error_lines(f"{one.triad}, {poses[0]} → {poses[1]} poses", one, other)
            yield verdict_line(other)
            if poses[1] > poses[0] and one.diagnosis.verdict is Code.NOTHING_MISSING and (
                    other.diagnosis.verdict in (Code.UNKNOWN, Code.NOISE)):
                yield (f"{one.triad}: the new poses do not agree with those that were there, which "
                       f"noise explained. A sensor's zero moves from day to day and when it is "
                       f"switched on: poses of another time are a session of their own, which "
                       f"`pipeline compare` puts beside this one.")


def _error_lines(title: str, before: TriadResult, after: TriadResult) -> Iterator[str]:
    unit, factor = DISPLAY[before.triad]
    columns = [[title, f"RMS [{unit}]", f"leave-one-out [{unit}]", "chi²/dof", "verdict"]]
    for name, one in (("before", before), ("after", after)):
        fit = one.calibration.fit
        columns.append([name, f"{one.comparison.residual_rms * factor:.4g}",
                        f"{one.comparison.loo_rms * factor:.4g}", f"{fit.chi2 / fit.dof:.3g}",
                        one.diagnosis.verdict])
    yield from table_lines([list(row) for row in zip(*columns, strict=True)], indent="")


def _rate_lines(setting: str, before: Outcome, after: Outcome) -> Iterator[str]:
    rates: list[SettingRate] = [outcome.rates[setting] for outcome in (before, after)]
    rows = [[f"rate.{setting}", "before", "after"]]
    largest = (max(clip.fit.rms_rad for clip in rate.clips) for rate in rates)
    rows.append(["phase residual [°]", *(f"{math.degrees(rms):.4g}" for rms in largest)])
    rows.append(["verdict", *(r.clips[0].diagnosis.verdict for r in rates)])
    yield from table_lines(rows, indent="")
    for clip in rates[1].clips[:1]:
        for term in clip.fit.terms:
            values = ", ".join(f"{v:.3g} ± {s:.2g}" for v, s in zip(term.value, term.sd,
                                                                    strict=True))
            yield f"  {term.name}: {values} {term.unit}"
        yield clip.diagnosis.explanation
