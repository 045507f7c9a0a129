"""Joint decision of several clips of a session between a readout delay and a wave.

A delay of the frame's rows is the same time in every clip of a camera, so that its wave grows with
the rate and changes its sign with the direction. A wave of the mark, the plate or the view has the
same size at every rate and in both directions.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from vision.rate.diagnosis import PhaseDiagnosis, TermCandidate

DELAY, WAVE = "rolling_shutter", "once_per_rev"


# Limits of the joint decision.
LEAST_SPREAD = 0.1
"""Least relative spread of the size that changes from clip to clip. Derived: a delay read as a wave
spreads by 15 % between 33 and 45 rpm, the nearest two speeds of a record player."""
CLEARLY_STEADIER = 0.5
"""Ratio of the two relative spreads below which the steadier is named. Derived: at 33 and 45 rpm
sizes with an error of 7 % still stay below it."""


def judge_together(
    clips: Sequence[tuple[str, PhaseDiagnosis, float]],
) -> Mapping[str, PhaseDiagnosis]:
    """Decide on the clips that show a delay or a wave from all clips of a session.

    A single clip cannot separate them reliably: a small wave beside the delay looks like a wave
    alone.

    Parameters
    ----------
    clips : sequence of (name, PhaseDiagnosis, rate)
        Clips of one camera in one position; the rates are signed, rad/s.

    Returns
    -------
    mapping of name to PhaseDiagnosis
        The joint verdicts; empty if none is open, or none is decided.
    """
    either = [name for name, diagnosis, _ in clips if {DELAY, WAVE} <= set(diagnosis.group)]
    sizes = [(name, *both, rate) for name, diagnosis, rate in clips
             if (both := _sizes(diagnosis)) is not None]
    if not either or len(sizes) < 2:
        return {}
    delay = np.array([size for _, size, _, _ in sizes])
    rate = np.array([each for *_, each in sizes])
    # As a function of the plate's angle, the wave of a delay changes its sign with the direction.
    wave = np.array([size for _, _, size, _ in sizes]) * np.sign(delay) * np.sign(rate)
    spreads = {DELAY: _spread(delay), WAVE: _spread(wave)}
    steady, other = sorted(spreads, key=lambda term: spreads[term])
    is_clear = spreads[steady] < CLEARLY_STEADIER * spreads[other]
    if not is_clear or spreads[other] < LEAST_SPREAD:
        return {}
    shown = {DELAY: f"{_listed(delay * 1e6)} µs per row", WAVE: f"{_listed(np.degrees(wave))}°"}
    because = (f"The clips {', '.join(name for name, *_ in sizes)} together decide: the size of "
               f"{steady} is nearly the same in all ({shown[steady]}), that of {other} is not "
               f"({shown[other]}).")
    return {name: _decided(diagnosis, steady, because)
            for name, diagnosis, _ in clips
            if name in either and (diagnosis.verdict, diagnosis.name) != ("effect", steady)}


def _sizes(diagnosis: PhaseDiagnosis) -> tuple[float, float] | None:
    """Delay and amplitude of the wave in a clip that shows either as the other's alias."""
    by_name: dict[str, TermCandidate] = {each.name: each for each in diagnosis.ranking}
    if not (by_name.keys() >= {DELAY, WAVE} and DELAY in by_name[WAVE].aliases):
        return None
    return float(by_name[DELAY].size[0]), float(np.linalg.norm(by_name[WAVE].size))


def _spread(sizes: np.ndarray) -> float:
    """Relative scatter of sizes about their mean."""
    return float(sizes.std() / max(abs(float(sizes.mean())), np.finfo(float).tiny))


def _listed(sizes: np.ndarray) -> str:
    return ", ".join(f"{size:.3g}" for size in sizes)


def _decided(diagnosis: PhaseDiagnosis, term: str, because: str) -> PhaseDiagnosis:
    leader = next(each for each in diagnosis.ranking if each.name == term)
    text = (f"{term} is missing: with it the phase residual falls to "
            f"{np.degrees(leader.rms_after_rad):.3g}° rms.")
    return replace(diagnosis, verdict="effect", name=term, explanation=text, record_next=None,
                   together=because, further=())
