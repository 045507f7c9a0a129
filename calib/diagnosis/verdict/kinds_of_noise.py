"""Which kind of noise a residual without any shape is, by the likelihood of each at its size."""

import numpy as np

from calib.effects.catalogue import find_effect
from calib.fit.least_squares.drawn_sizes import log_densities
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.unknown_sd import tests_the_model

SHAPELESS = ("extra_noise", "pose_scatter")
"""Effects that noise without any shape can be, the first where these poses tell none apart. Fact:
the sds of the poses are too small by a factor, or by what differs between the poses."""

TOLD_APART = 3.0
"""Difference of log likelihoods from which one kind of noise is told from another. Derived: 20 to
1."""


def kinds_of_noise(fit: Fit) -> tuple[str, ...]:
    """The likeliest of ``SHAPELESS`` and what looks the same in these poses; none in a model twice.

    Parameters
    ----------
    fit : Fit

    Returns
    -------
    tuple of str
        Empty where the sds of the poses say nothing of the model, or all are in it.
    """
    kinds = [find_effect(each) for each in SHAPELESS if each not in fit.model.names]
    if not kinds or not tests_the_model(fit.poses):
        return ()
    density = log_densities(fit, kinds)
    alike = density > density.max() - TOLD_APART
    first = 0 if alike[0] else int(np.argmax(density))
    others = (each.name for each, same in zip(kinds, alike, strict=True) if same)
    return tuple(dict.fromkeys((kinds[first].name, *others)))
