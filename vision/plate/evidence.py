"""Whether a model of something that turns is believed: what it explains against what it leaves.

Of values seen in n frames, a model of p parameters each explains the share s of what varies. Per
degree of freedom that is

    F = (s / p) / ((1 - s) / (n - p)),

about 1 where a model was fitted to noise (Fisher's variance ratio), whatever the share of the noise
in a film is: of a dark one it is most of what varies.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class EvidenceThresholds:
    """What is believed.

    Attributes
    ----------
    beyond_noise : float
        F of a model, at least. Derived: ten. Noise of a window of frames is below 2, but what goes
        to and fro, or only comes and goes, turns by chance for a part of a window.
    """

    beyond_noise: float = 10.0


THRESHOLDS = EvidenceThresholds()


def evidence(share: float, frames: int, parameters: int = 1) -> float:
    """The ratio F for what a model explains of all that varies, 0 to 1, in some frames.

    >>> round(evidence(0.5, 21), 1)
    20.0
    """
    unexplained = max(1 - share, 1e-9)
    return max(share, 0.0) / parameters / (unexplained / max(frames - parameters, 1))


def believed(share: float, frames: int, parameters: int = 1) -> bool:
    """Whether what a model explains is beyond the noise that it leaves."""
    return evidence(share, frames, parameters) > THRESHOLDS.beyond_noise
