"""A bias that follows a logged column: ``column:NAME``."""

import numpy as np

from calib.effects.effect import OF_COLUMN, Effect, Page, per_axis
from calib.effects.units import column_unit
from calib.poses.imu_log import AXES


def column_effect(name: str) -> Effect:
    """The effect ``column:NAME``: a bias that follows the logged column NAME linearly."""
    return Effect(
        name=OF_COLUMN + name,
        parameters=AXES,
        unit=f"{{u}} per {column_unit(name)}",
        logged=(name,),
        constant_is="bias",
        names_column=name,
        columns=lambda at: per_axis(np.tile(at.column(name)[:, None], 3)),
        physics=f"Bias that moves in proportion to the logged column {name}.",
        page=Page(
            formula=f"e_k = c_k · {name}",
            typical={},
            source="found in these data, not in a catalogue",
            confounded="every other column that moves together with it",
            separates=f"vary {name} alone while the sensor stays in one pose",
        ),
    )
