"""Conditions that an effect needs, and reasons why some poses cannot evaluate it."""

from collections.abc import Mapping

import numpy as np

from calib.effects.effect import Effect, Need
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray


def unavailable(effect: Effect, at: Conditions) -> str | None:
    """Reason why ``effect`` cannot be evaluated on these poses, or None if it can.

    Parameters
    ----------
    effect : Effect
    at : Conditions
        Of the n poses with their nominal readings.

    Returns
    -------
    str or None
        In words that end a sentence which names the effect.
    """
    if np.isfinite(effect.evaluate(at)).all():
        return None
    return why_not_finite(effect, at)


def why_not_finite(effect: Effect, at: Conditions) -> str:
    """Reason why the columns of ``effect`` are not finite in poses at ``at``, in words."""
    needs, columns = lacking(effect, at)
    if needs:
        return LACKING[needs[0]]
    return (f"the logs have no complete column {columns[0]}" if columns else
            "its columns are not numbers in these poses")


LACKING: Mapping[Need, str] = {
    "force": "the accelerometer was not logged in every pose",
    "time": "the logs' clocks overlap or are missing, so the order in time is not known",
    "previous": "the logs' clocks overlap or are missing, so the order in time is not known",
    "vibration": "the accelerometer was not logged in every pose",
    "plate": "the plate's rate is not known",
}


def lacking(effect: Effect, at: Conditions) -> tuple[list[Need], list[str]]:
    """Needs of ``effect`` and logged columns that are not complete in ``at``.

    Parameters
    ----------
    effect : Effect
    at : Conditions
        Of the n poses, or of the n samples of a log, that it is to be evaluated on.

    Returns
    -------
    needs : list of str
        Of :data:`calib.effects.effect.Need`, those that are NaN or infinite in a row; none where
        the effect can be evaluated.
    columns : list of str
        Logged columns that it reads and that have no number in a row.
    """
    fields: Mapping[Need, FloatArray] = {
        "force": at.force,
        "time": at.time_s,
        "previous": at.previous,
        "vibration": at.vibration,
        "plate": at.spin_rad_s,
    }
    return (
        [need for need in effect.needs if not np.isfinite(fields[need]).all()],
        [name for name in effect.logged if not np.isfinite(at.column(name)).all()],
    )
