"""Test of a model of rotation: the explained variation against the residual.

A model with p parameters per value, for values in n frames, explains the share s of their
variation. Per degree of freedom that is

    F = (s / p) / ((1 - s) / (n - p)),

about 1 for a model fitted to noise (Fisher's variance ratio), whatever the share of noise in a film
is: in a dark one it is most of the variation.
"""



# Limits of the test.
BEYOND_NOISE = 10.0
"""Least F of an accepted model. Derived: ten. Noise in a window of frames is below 2, but an object
that moves to and fro, or appears and disappears, turns for part of it by chance."""


def believed(share: float, frames: int, parameters: int = 1) -> bool:
    """Whether the share of the variation that a model explains, 0 to 1, is beyond residual noise.

    >>> believed(0.5, 21), believed(0.5, 11)
    (True, False)
    """
    unexplained = max(1 - share, 1e-9) / max(frames - parameters, 1)
    return share / parameters / unexplained > BEYOND_NOISE
