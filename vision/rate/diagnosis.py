"""Diagnosis of the phase track: the term that the stated model lacks.

Every hypothesis is a covariance of the residual of the stated model: with X the term's columns, the
model's columns projected out and scaled to unit rms, and residuals r in units of the noise of an
independent residual,

    r ~ N(0, I + τ² X Xᵀ),   log evidence = log mean over τ of N(r | 0, I + τ² X Xᵀ) / N(r | 0, I),

closed form from the decomposition of XᵀX (Bayes factors with a mean over the size of the effect:
Kass and Raftery, JASA 90, 1995). The noise is that of the fullest model, all hypotheses at once,
scaled up by its correlation time. The names are those of ``calib.diagnosis``, which weighs the
effects of a sensor in the same way: prior probabilities of nothing, of a listed term and of an
unknown shape; aliases, which look the same; blind, a term that these data cannot show.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vision.geometry import FloatArray
from vision.rate.least_squares import least_squares
from vision.rate.terms import ALWAYS, MEANING, TERMS, Regressors, columns, design

TAUS = 2.0 ** np.arange(-5, 14)  # in units of the noise: the prior of an effect's size
PRIOR_NONE, PRIOR_LISTED, PRIOR_UNKNOWN = 0.5, 0.35, 0.15  #: probabilities before the data; chosen
TINY = 1e-10  # relative; below it, directions that too similar waves do not span
ANGLE_ORDERS = range(3, 9)  #: per turn, beyond the two that have names
TIME_WAVES = range(1, 9)  #: half cosines over the clip


# Limits for naming a term.
BLIND_SHARE = 0.02
"""Least share of a visible signature that the stated model does not absorb. As in
``calib.diagnosis``."""
ALIAS_CORRELATION = 0.99
"""Canonical correlation above which two terms are one group. As in ``calib.diagnosis``."""
CLEARLY_LESS = 1.25  #: residual of an alias over the leader's from which the alias is ruled out
SMALLEST_SHARE = 0.02  #: least share of the residual's variance that a named term explains
SHAPE_SHARE = 0.2  #: least share of the residual's variance that an unlisted shape explains
SEPARATE = {
    frozenset({"once_per_rev", "rolling_shutter"}): "Film the plate in the other direction or at "
    "a second speed, or with the camera turned by 90°: readout delay grows with the rate and "
    "stays with the frame's rows, a wave of the plate does not.",
}
SHAPE_NEXT = {
    "plate angle": "Look at the residual against plate angle; a second mark opposite the first, or "
    "a flatter view, shows whether the mark or the plate is uneven.",
    "time": "Look at the residual against time; film longer after the plate has settled.",
}


@dataclass(frozen=True, eq=False)
class TermCandidate:
    """One hypothesis, ranked by ``log_evidence``.

    Attributes
    ----------
    name : str
        A term, or "plate angle" or "time" for an unlisted shape.
    log_evidence : float
        Log Bayes factor against nothing.
    chi2_drop : float
        Decrease of the residual's chi-square when it is added.
    size, sd : array, shape (k,)
        Sizes of its parameters, in the term's unit; for a shape the rms in rad, without sd.
    rms_after_rad : float
        Rms of the residual with it added.
    blind : bool
        The stated model absorbs it.
    aliases : tuple of str
        Terms that look the same in this clip.
    """

    name: str
    log_evidence: float
    chi2_drop: float
    size: FloatArray
    sd: FloatArray
    rms_after_rad: float
    blind: bool
    aliases: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class PhaseDiagnosis:
    """The verdict on a phase track.

    Attributes
    ----------
    verdict : str
        nothing_missing, effect, ambiguous, unknown (a shape that no listed term has).
    name : str or None
        The term; or "plate angle" or "time" for an unknown shape.
    group : tuple of str
        Terms that this clip cannot separate.
    explanation : str
        One paragraph.
    record_next : str or None
    ranking : tuple of TermCandidate
    together : str
        Reason why all clips of the session decide jointly, the same for all of them.
    further : tuple of str
        Terms that are missing too once the named one is in the model.
    """

    verdict: str
    name: str | None
    group: tuple[str, ...]
    explanation: str
    record_next: str | None
    ranking: tuple[TermCandidate, ...]
    together: str = ""
    further: tuple[str, ...] = ()


def diagnose(
    model: Sequence[str], base: Regressors, angle_rad: FloatArray, dropped: int
) -> PhaseDiagnosis:
    """Diagnose the residual of the stated model: its missing term, and those missing beside it.

    A term that looks the same as the named one is none of them.

    Parameters
    ----------
    model : sequence of str
        Terms already in the model, besides the constant rate.
    base : Regressors
        Regressors on the rows of the residual.
    angle_rad : array, shape (u,)
        The measured angle.
    dropped : int
        Number of frames dropped silently; without any, ``frame_steps`` cannot be added.
    """
    first = _named(model, base, angle_rad, dropped)
    if first.verdict != "effect" or first.name is None:
        return first
    rest = diagnose((*model, first.name), base, angle_rad, dropped)
    if rest.verdict != "effect" or rest.name is None or rest.name in first.group:
        return first
    further = (rest.name, *rest.further)
    return replace(first, further=further, explanation=(
        f"{first.explanation} Then {' and '.join(further)} {'are' if further[1:] else 'is'} "
        f"missing too."))


def _named(
    model: Sequence[str], base: Regressors, angle_rad: FloatArray, dropped: int
) -> PhaseDiagnosis:
    shapes = _unlisted(base)
    unit = _unit(base, angle_rad, shapes)
    stated, _ = np.linalg.qr(design(model, base, base.stamp_s))
    r = _project_out(angle_rad - base.rate_rad_s * base.stamp_s, stated) / unit
    listed = [t for t in TERMS if t not in model and (t != "frame_steps" or dropped)]
    spans = {term: _project_out(columns(term, base), stated) for term in listed}
    ranking = [_evaluate(term, columns(term, base), spans, r, unit) for term in listed]
    ranking.sort(key=lambda c: -c.log_evidence)
    unlisted = [_evaluate_shape(name, x, stated, r, unit) for name, x in shapes.items()]
    return _decide(ranking, unlisted, r, unit)


def _unit(base: Regressors, angle_rad: FloatArray, shapes: dict[str, FloatArray]) -> float:
    """Noise of an independent residual of the fullest model, which has every hypothesis."""
    x = np.concatenate([design(ALWAYS[:3], base, base.time_s), *shapes.values()], axis=1)
    y = angle_rad - base.line_rad
    # A fast plate has few frames per turn, on which some of the waves look the same.
    fit = least_squares(x, y, y.std() / np.sqrt((x**2).mean(axis=0)))
    return float(fit.noise * np.sqrt(fit.correlation_time))


def _project_out(x: FloatArray, basis: FloatArray) -> FloatArray:
    return x - basis @ (basis.T @ x)


def _evaluate(
    term: str, x: FloatArray, spans: dict[str, FloatArray], r: FloatArray, unit: float
) -> TermCandidate:
    visible = spans[term]
    rms = np.sqrt((x**2).mean(axis=0))
    share = float(np.sqrt((visible**2).mean(axis=0)).max() / max(float(rms.max()), 1e-30))
    blind = share < BLIND_SHARE
    aliases = tuple(
        other
        for other, span in spans.items()
        if other != term
        and not blind
        and _canonical(visible, span) > ALIAS_CORRELATION
    )
    evidence, drop = (-np.inf, 0.0) if blind else _evidence(visible / rms, r)
    scaled = visible / unit
    size = np.asarray(np.linalg.lstsq(scaled, r)[0], float)
    sd = np.asarray(np.sqrt(np.diag(np.linalg.pinv(scaled.T @ scaled))), float)
    after = unit * np.sqrt(((r - scaled @ size) ** 2).mean())
    return TermCandidate(term, evidence, drop, size, sd, float(after), blind, aliases)


def _canonical(one: FloatArray, other: FloatArray) -> float:
    """Largest canonical correlation of the smaller span with the larger."""
    q1, q2 = np.linalg.qr(one)[0], np.linalg.qr(other)[0]
    return float(np.linalg.svd(q1.T @ q2, compute_uv=False).max(initial=0.0))


def _evidence(x: FloatArray, r: FloatArray) -> tuple[float, float]:
    """Log evidence against nothing, and the decrease of chi-square."""
    squared, axes = np.linalg.eigh(x.T @ x)
    clear = squared > TINY * squared[-1]
    squared = squared[clear]
    z = (x.T @ r) @ axes[:, clear] / np.sqrt(squared)  # along the singular vectors
    share = TAUS[:, None] ** 2 * squared
    log = 0.5 * (z**2 * share / (1 + share) - np.log1p(share)).sum(axis=1)
    top = float(log.max())
    return top + float(np.log(np.exp(log - top).mean())), float((z**2).sum())


def _unlisted(base: Regressors) -> dict[str, FloatArray]:
    """Smooth shapes in the plate's angle and in time that no listed term has."""
    line = base.line_rad
    phase = np.pi * (base.time_s - base.time_s[0]) / np.ptp(base.time_s)
    waves = [f(k * line) for k in ANGLE_ORDERS for f in (np.cos, np.sin)]
    return {
        "plate angle": np.stack(waves, axis=1),
        "time": np.stack([np.cos(k * phase) for k in TIME_WAVES], axis=1),
    }


def _evaluate_shape(
    name: str, x: FloatArray, stated: FloatArray, r: FloatArray, unit: float
) -> TermCandidate:
    evidence, drop = _evidence(_project_out(x, stated), r)
    after = unit * np.sqrt(max(float((r**2).sum()) - drop, 0.0) / len(r))
    size = np.array([np.sqrt(drop / len(r)) * unit])
    return TermCandidate(name, evidence, drop, size, np.array([np.nan]), float(after), False, ())


def _decide(
    ranking: list[TermCandidate], unlisted: list[TermCandidate], r: FloatArray, unit: float
) -> PhaseDiagnosis:
    chi2 = float((r**2).sum())
    seen = [c for c in ranking if not c.blind and c.chi2_drop > SMALLEST_SHARE * chi2]
    odd = [c for c in unlisted if c.chi2_drop > SHAPE_SHARE * chi2]
    logs = [np.log(PRIOR_NONE)]
    logs += [np.log(PRIOR_LISTED / max(len(ranking), 1)) + c.log_evidence for c in seen]
    logs += [np.log(PRIOR_UNKNOWN / 2) + c.log_evidence for c in odd]
    everything = (*ranking, *odd)
    rms = np.degrees(unit * np.sqrt(chi2 / len(r)))
    best = int(np.argmax(logs))
    if best == 0:
        text = (f"Nothing is missing: what the model leaves, {rms:.3g}° rms, has no shape that a "
                f"term would take away.")
        return PhaseDiagnosis("nothing_missing", None, (), text, None, everything)
    leader = (seen + odd)[best - 1]
    if leader in odd:
        text = (
            f"Something that follows {leader.name} is in the residual and no listed term has its "
            f"shape: it makes {leader.chi2_drop / chi2:.0%} of the variance of {rms:.3g}° rms."
        )
        return PhaseDiagnosis("unknown", leader.name, (), text, SHAPE_NEXT[leader.name], everything)
    falls = (
        f"the phase residual falls from {rms:.3g}° to {np.degrees(leader.rms_after_rad):.3g}° rms"
    )
    group = (leader.name, *leader.aliases)
    if len(group) > 1 and not _much_better(leader, ranking):
        apart = next((v for k, v in SEPARATE.items() if k <= set(group)), None)
        text = (
            f"{' or '.join(group)} is missing and this clip cannot determine which "
            f"({MEANING[group[0]]}; {MEANING[group[1]]}). With {leader.name} {falls}."
        )
        return PhaseDiagnosis("ambiguous", leader.name, group, text, apart, everything)
    text = f"{leader.name} is missing ({MEANING[leader.name]}): with it {falls}."
    for other in (c for c in ranking if c.name in leader.aliases):
        text += f" {other.name} alone would leave {np.degrees(other.rms_after_rad):.3g}°."
    return PhaseDiagnosis("effect", leader.name, group, text, None, everything)


def _much_better(leader: TermCandidate, ranking: list[TermCandidate]) -> bool:
    """Whether the leader explains more than any of its aliases can.

    The test is the size of the residual, not evidence: long clips would separate two nearly equal
    waves by view errors far smaller than either.
    """
    limit = CLEARLY_LESS * leader.rms_after_rad
    return all(c.rms_after_rad > limit for c in ranking if c.name in leader.aliases)
