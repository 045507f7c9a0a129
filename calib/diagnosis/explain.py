"""The diagnosis as a person would say it."""

from collections.abc import Sequence

import numpy as np

from calib.diagnosis.next_measurement import Advice
from calib.diagnosis.ranking import Candidate
from calib.diagnosis.verdict import Verdict
from calib.effects.catalogue import find_effect
from calib.errors import CalibrationError
from calib.fit.leave_one_out import compare
from calib.fit.result import Fit

LEAST_FALL_PERCENT = 5.0
"""Fall of the leave-one-out error from which the nearest listed effect is worth trying."""


def put_into_words(
    fit: Fit,
    verdict: Verdict,
    ranking: Sequence[Candidate],
    p_value: float,
    advice: Advice | None,
) -> str:
    """The verdict in two or three sentences."""
    speak = {
        "nothing_missing": _nothing,
        "effect": _effect,
        "ambiguous": _ambiguous,
        "unknown": _unknown,
        "bad_pose": _bad_pose,
        "noise": _noise,
    }[verdict.code]
    return speak(fit, verdict, ranking, p_value) + _what_next(verdict, advice)


def _misfit(fit: Fit, p_value: float) -> str:
    chance = f"p = {p_value:.2g}" if p_value > 1e-300 else "p below 1e-300"
    return f"chi²/dof {fit.chi2 / fit.dof:.3g} with {fit.dof} degrees of freedom, {chance}"


def _nothing(fit: Fit, verdict: Verdict, ranking: Sequence[Candidate], p_value: float) -> str:
    return (
        f"Nothing is missing: the poses' own noise explains the residual ({_misfit(fit, p_value)})."
    )


def _physics(name: str) -> str:
    try:
        said = find_effect(name).physics
    except CalibrationError:
        return "your own effect."
    return said[0].lower() + said[1:]


def _effect(fit: Fit, verdict: Verdict, ranking: Sequence[Candidate], p_value: float) -> str:
    assert verdict.name is not None
    best = next(c for c in ranking if c.name == verdict.name and c.kind == "listed")
    share = 100 * best.chi2_drop / fit.chi2
    says = f"'{verdict.name}' is missing: {_physics(verdict.name)} "
    says += f"The misfit is {_misfit(fit, p_value)}; it explains {share:.0f} % of chi². "
    largest = int(np.argmax(np.abs(best.size))) if best.size.size else 0
    if best.size.size:
        says += (
            f"Its largest part is about {best.size[largest]:.3g} ± {best.sd[largest]:.2g} "
            f"{best.unit}. "
        )
    if len(verdict.group) > 1:
        others = " or ".join(f"'{name}'" for name in verdict.group[1:])
        says += f"In these poses it looks the same as {others}: they cannot tell which it is. "
    if verdict.partner is not None:
        says += f"A second effect shows beside it: '{verdict.partner}'. "
    return says.rstrip()


def _readable(key: str) -> str:
    if key.startswith("~"):
        return f"something that follows {_covariate(key[1:])}"
    return {
        "jump": "a jump of the bias",
        "bad_pose": "one bad pose",
        "noise": "more noise than the poses show by themselves",
    }.get(key, f"'{key}'")


def _covariate(name: str) -> str:
    return {
        "time_s": "time",
        "spin_rad_s": "the rate of the plate",
        "attitude": "the attitude in a way of third order or higher",
    }.get(name, f"the logged column {name}")


def _ambiguous(fit: Fit, verdict: Verdict, ranking: Sequence[Candidate], p_value: float) -> str:
    names = [_readable(key) for key in verdict.group]
    listed = ", ".join(names[:-1]) + " or " + names[-1] if len(names) > 1 else names[0]
    return (
        f"Something may be missing ({_misfit(fit, p_value)}), and these data cannot tell what: "
        f"{listed}."
    )


def _unknown(fit: Fit, verdict: Verdict, ranking: Sequence[Candidate], p_value: float) -> str:
    assert verdict.name is not None
    shape = {
        "jump": "the bias drifts during the session, and a jump fits better than a straight line "
        "(bias_drift) or a settling (warm_up)",
        "time_s": "the residual drifts with time, along no straight line (bias_drift) and no "
        "settling (warm_up)",
    }
    what = shape.get(verdict.name, f"the residual follows {_covariate(verdict.name)}")
    return (
        f"Something is missing that no listed effect explains: {what} ({_misfit(fit, p_value)}). "
        f"{_nearest(fit, verdict, ranking)}"
        f"If you know its physics, write it as your own effect (`effects:` in the config)."
    )


def _nearest(fit: Fit, verdict: Verdict, ranking: Sequence[Candidate]) -> str:
    """What the nearest listed effect would do for an error of unlisted shape."""
    if not verdict.group:
        return ""
    nearest = next(c for c in ranking if c.name == verdict.group[0] and c.kind == "listed")
    share = 100 * (1 - nearest.loo_after / compare(fit).loo_rms)
    if not share >= LEAST_FALL_PERCENT:
        return ""
    return (
        f"The nearest listed one, '{nearest.name}', would take {share:.0f} % off the "
        f"leave-one-out error. "
    )


def _bad_pose(fit: Fit, verdict: Verdict, ranking: Sequence[Candidate], p_value: float) -> str:
    return (
        f"One pose does not agree with the others: {verdict.name} ({_misfit(fit, p_value)}). "
        f"Record it again, or take it out of the list of poses."
    )


def _noise(fit: Fit, verdict: Verdict, ranking: Sequence[Candidate], p_value: float) -> str:
    factor = np.sqrt(fit.chi2 / fit.dof)
    return (
        f"The residual is {factor:.2g} times what the poses' own noise explains, without a shape "
        f"that any effect has ({_misfit(fit, p_value)}). The sds of the parameters are widened by "
        f"that factor. Longer poses and a firmer base usually help."
    )


def _what_next(verdict: Verdict, advice: Advice | None) -> str:
    if advice is not None:
        return f" Record next: {advice.says}."
    if verdict.code == "ambiguous":
        return " Record next: the same poses once more, in random order and for longer."
    if verdict.code == "effect" and len(verdict.group) > 1:
        try:
            return f" What separates them: {find_effect(verdict.group[0]).page.separates}."
        except CalibrationError:
            return ""
    return ""
