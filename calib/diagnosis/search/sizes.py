"""Sizes that the residual asks for, before a refit and at one, held against what nature allows."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.search.table import Table
from calib.fit.least_squares.result import Fit
from calib.poses.imu_log import FloatArray

SEEN_SHARE = 1e-3
"""Of the best seen combination of parameters; those seen less have no size of their own."""


def predicted_size(table: Table, j: int) -> tuple[FloatArray, FloatArray]:
    """Size and sd of the parameters that the residual asks of hypothesis ``j`` alone, each (k,)."""
    each = table.spectra[j]
    seen = each.squared > SEEN_SHARE**2 * float(each.squared.max())
    turns, squared = each.turns[:, seen], each.squared[seen]
    size = turns @ (each.along[seen] / squared)
    return size * each.unit, np.sqrt((turns**2 / squared).sum(axis=1)) * each.unit


def within_nature(table: Table, hypotheses: Sequence[Hypothesis]) -> list[Hypothesis]:
    """``hypotheses``, less probable where the rows ask for more of them than nature has.

    The Earth turns by 15°/h: a gyroscope that reads five times that about the vertical is read
    wrong, or stands on something else that turns.
    """
    judged = list(hypotheses)
    for j, h in enumerate(hypotheses):
        if h.effect is None or np.isinf(h.effect.largest) or table.is_blind(j):
            continue
        size, sd = predicted_size(table, j)
        if (np.abs(size) - CONSTANTS.limit_sd * sd > h.effect.largest).any():
            judged[j] = replace(h, log_prior=h.log_prior + float(np.log(CONSTANTS.odds_unnatural)))
            table.log_prior[j] = judged[j].log_prior
    return judged


def beyond_nature(fit: Fit, names: Sequence[str]) -> frozenset[str]:
    """Those of the effects ``names`` of ``fit`` that are larger than nature has them.

    Their sds are allowed for. What looks like such an effect is something else: a gyroscope held
    in a hand turns with the hand, not with the Earth.
    """
    size, sd = np.abs(fit.theta), np.sqrt(np.diag(fit.cov)[: fit.model.size])
    least = size - CONSTANTS.limit_sd * sd
    where = fit.model.slices()
    return frozenset(
        effect.name for effect in fit.model.effects
        if effect.name in names and (least[where[effect.name]] > effect.largest).any()
    )
