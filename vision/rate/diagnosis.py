"""What the stated model of the phase track misses.

Every hypothesis is a covariance of what the stated model leaves: with X the term's columns, the
model's own columns projected out and scaled to unit rms, and residuals r in units of the noise of
an independent residual,

    r ~ N(0, I + s² X Xᵀ),   log evidence = log mean over s of N(r | 0, I + s² X Xᵀ) / N(r | 0, I),

closed form from the decomposition of XᵀX. The noise is that of the fullest model, all hypotheses at
once, raised by its correlation time.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vision.geometry import FloatArray
from vision.rate.least_squares import independent, least_squares
from vision.rate.terms import MEANING, TERMS, Regressors, columns, design

SIZES = 2.0 ** np.arange(-5, 14)  # in units of the noise: the prior of an effect's size
BLIND = 0.02  # share of a signature left after the stated model
ALIAS = 0.99  # canonical correlation above which two terms are one group
CLEAR_ODDS = 0.9
CLEARLY_LESS = 1.25  # times the residual that an alias must leave to be ruled out
PRIOR_NONE, PRIOR_LISTED, PRIOR_UNKNOWN = 0.5, 0.35, 0.15
SMALLEST_SHARE = 0.02  # of the residual's variance: less is not worth a term
SHAPE_SHARE = 0.2  # of the residual's variance, for an unlisted shape to be worth a verdict
TINY = 1e-10  # relative; directions that waves too close to each other do not span
ANGLE_ORDERS = range(3, 9)
TIME_WAVES = range(1, 9)
SEPARATE = {
    frozenset({"once_per_rev", "rolling_shutter"}): "Film the plate in the other direction or at "
    "a second speed, or with the camera turned by 90°: readout delay grows with the rate and "
    "stays with the picture's rows, a wave of the plate does not.",
}
SHAPE_NEXT = {
    "plate angle": "Look at the residual against plate angle; a second mark opposite the first, or "
    "a flatter view, shows whether the mark or the plate is uneven.",
    "time": "Look at the residual against time; film longer after the plate has settled.",
}


@dataclass(frozen=True, eq=False)
class Candidate:
    """One hypothesis, ranked by ``log_evidence``."""

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
        Terms that cannot be told apart here.
    says : str
        One paragraph.
    record_next : str or None
    ranking : tuple of Candidate
    """

    verdict: str
    name: str | None
    group: tuple[str, ...]
    says: str
    record_next: str | None
    ranking: tuple[Candidate, ...]


def diagnose(
    model: Sequence[str],
    given: Regressors,
    angle_rad: FloatArray,
    lost: int,
) -> PhaseDiagnosis:
    """Judge what the stated model leaves.

    Parameters
    ----------
    model : sequence of str
        Terms already in the model, besides the constant rate.
    given : Regressors
        On the rows of the residual.
    angle_rad : array, shape (u,)
        The measured angle.
    lost : int
        Pictures found lost silently; without any there is no ``frame_steps`` to add.
    """
    shapes = _unlisted(given)
    unit = _unit(given, angle_rad, shapes)
    base, _ = np.linalg.qr(design(model, given, given.stamp_s))
    r = _left(angle_rad - given.rate_rad_s * given.stamp_s, base) / unit
    listed = [t for t in TERMS if t not in model and (t != "frame_steps" or lost)]
    spans = {term: _left(columns(term, given), base) for term in listed}
    ranking = [_weigh(term, columns(term, given), spans, r, unit) for term in listed]
    odd = [_shape(name, x, base, r, unit) for name, x in shapes.items()]
    ranking.sort(key=lambda c: -c.log_evidence)
    return _verdict(ranking, odd, float((r**2).sum()), unit, len(r))


def _unit(given: Regressors, angle_rad: FloatArray, shapes: dict[str, FloatArray]) -> float:
    """Noise of an independent residual of the fullest model: no hypothesis is in it."""
    listed = design(("once_per_rev", "twice_per_rev", "rate_drift"), given, given.time_s)
    # A fast plate has few pictures per turn, and some of the waves look alike on them.
    basis = independent(np.concatenate([listed, *shapes.values()], axis=1))
    fit = least_squares(basis, angle_rad - given.line_rad)
    return float(fit.noise * np.sqrt(fit.correlation_time))


def _left(x: FloatArray, base: FloatArray) -> FloatArray:
    return x - base @ (base.T @ x)


def _weigh(
    term: str, x: FloatArray, spans: dict[str, FloatArray], r: FloatArray, unit: float
) -> Candidate:
    left = spans[term]
    rms = np.sqrt((x**2).mean(axis=0))
    share = float(np.sqrt((left**2).mean(axis=0)).max() / max(float(rms.max()), 1e-30))
    blind = share < BLIND
    aliases = tuple(
        other
        for other, span in spans.items()
        if other != term and not blind and _canonical(left, span) > ALIAS
    )
    evidence, drop = (-np.inf, 0.0) if blind else _evidence(left / rms, r)
    scaled = left / unit
    size = np.asarray(np.linalg.lstsq(scaled, r)[0], float)
    sd = np.asarray(np.sqrt(np.diag(np.linalg.pinv(scaled.T @ scaled))), float)
    after = unit * np.sqrt(((r - scaled @ size) ** 2).mean())
    return Candidate(term, evidence, drop, size, sd, float(after), blind, aliases)


def _canonical(one: FloatArray, other: FloatArray) -> float:
    """Largest canonical correlation of the smaller span with the larger."""
    q1, q2 = np.linalg.qr(one)[0], np.linalg.qr(other)[0]
    return float(np.linalg.svd(q1.T @ q2, compute_uv=False).max(initial=0.0))


def _evidence(x: FloatArray, r: FloatArray) -> tuple[float, float]:
    """Log evidence against nothing, and the fall of chi-square."""
    squared, axes = np.linalg.eigh(x.T @ x)
    clear = squared > TINY * squared[-1]
    squared = squared[clear]
    z = (x.T @ r) @ axes[:, clear] / np.sqrt(squared)  # along the singular vectors
    share = SIZES[:, None] ** 2 * squared
    log = 0.5 * (z**2 * share / (1 + share) - np.log1p(share)).sum(axis=1)
    top = float(log.max())
    return top + float(np.log(np.exp(log - top).mean())), float((z**2).sum())


def _unlisted(given: Regressors) -> dict[str, FloatArray]:
    """Smooth shapes in the plate's angle and in time that no listed term has."""
    line = given.line_rad
    phase = np.pi * (given.time_s - given.time_s[0]) / np.ptp(given.time_s)
    waves = [f(k * line) for k in ANGLE_ORDERS for f in (np.cos, np.sin)]
    return {
        "plate angle": np.stack(waves, axis=1),
        "time": np.stack([np.cos(k * phase) for k in TIME_WAVES], axis=1),
    }


def _shape(name: str, x: FloatArray, base: FloatArray, r: FloatArray, unit: float) -> Candidate:
    left = _left(x, base)
    evidence, drop = _evidence(left, r)
    after = unit * np.sqrt(max(float((r**2).sum()) - drop, 0.0) / len(r))
    size = np.array([np.sqrt(drop / len(r)) * unit])
    return Candidate(name, evidence, drop, size, np.array([np.nan]), float(after), False, ())


def _verdict(
    ranking: list[Candidate], shapes: list[Candidate], chi2: float, unit: float, n: int
) -> PhaseDiagnosis:
    seen = [c for c in ranking if not c.blind and c.chi2_drop > SMALLEST_SHARE * chi2]
    odd = [c for c in shapes if c.chi2_drop > SHAPE_SHARE * chi2]
    logs = [np.log(PRIOR_NONE)]
    logs += [np.log(PRIOR_LISTED / max(len(ranking), 1)) + c.log_evidence for c in seen]
    logs += [np.log(PRIOR_UNKNOWN / 2) + c.log_evidence for c in odd]
    weight = np.exp(np.array(logs) - max(logs))
    weight /= weight.sum()
    rms = unit * np.sqrt(chi2 / n)
    everything = (*ranking, *odd)
    best = int(weight.argmax())
    if best == 0:
        says = (
            f"Nothing is missing: what the model leaves, {np.degrees(rms):.3g}° rms, has no shape "
            f"that a term would take away."
        )
        return PhaseDiagnosis("nothing_missing", None, (), says, None, everything)
    leader = (seen + odd)[best - 1]
    after = np.degrees(leader.rms_after_rad)
    falls = f"the phase residual falls from {np.degrees(rms):.3g}° to {after:.3g}° rms"
    if leader in odd:
        says = (
            f"Something that follows {leader.name} is in the residual and no listed term has its "
            f"shape: it makes {leader.chi2_drop / chi2:.0%} of the variance of "
            f"{np.degrees(rms):.3g}° rms."
        )
        return PhaseDiagnosis("unknown", leader.name, (), says, SHAPE_NEXT[leader.name], everything)
    group = (leader.name, *leader.aliases)
    share = float(sum(w for w, c in zip(weight[1:], seen + odd, strict=True) if c.name in group))
    if len(group) > 1 and not _much_better(leader, ranking):
        apart = next((v for k, v in SEPARATE.items() if k <= set(group)), None)
        says = (
            f"{' or '.join(group)} is missing and this clip cannot tell which "
            f"({MEANING[group[0]]}; {MEANING[group[1]]}). With {leader.name} {falls}."
        )
        return PhaseDiagnosis("ambiguous", leader.name, group, says, apart, everything)
    if share < CLEAR_ODDS:
        names = tuple(c.name for w, c in zip(weight[1:], seen + odd, strict=True) if w > 0.05)
        says = (
            f"One of {', '.join(names)} is missing, and this clip cannot tell which; with "
            f"{leader.name} {falls}."
        )
        return PhaseDiagnosis(
            "ambiguous", leader.name, names, says, "Film longer, over more turns.", everything
        )
    says = f"{leader.name} is missing ({MEANING[leader.name]}): with it {falls}."
    for other in (c for c in ranking if c.name in leader.aliases):
        says += f" {other.name} alone would leave {np.degrees(other.rms_after_rad):.3g}°."
    return PhaseDiagnosis("effect", leader.name, group, says, None, everything)


def _much_better(leader: Candidate, ranking: list[Candidate]) -> bool:
    """The leader explains what none of its aliases can.

    By the size of what is left, not by evidence: long clips would tell two nearly equal waves
    apart by view errors far smaller than either.
    """
    others = [c for c in ranking if c.name in leader.aliases]
    return all(c.rms_after_rad > CLEARLY_LESS * leader.rms_after_rad for c in others)
