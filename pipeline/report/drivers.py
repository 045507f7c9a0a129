"""What drives an effect: the condition of the poses against which its chart is drawn.

The effect itself is asked: the one condition whose change changes a column is its driver. A column
that depends on several conditions at once (a product in the user's expression, the direction of the
pose before) is drawn against its own value.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.effects.effect import Effect
from calib.numbers import RPM
from calib.poses.conditions import OTHER_TRIAD, RUN_COLUMN, Conditions
from calib.poses.imu_log import AXES, TEMPERATURE, FloatArray
from pipeline.text.formatting import DISPLAY

SHIFT = 0.37  #: of the range of a condition, to see whether an effect depends on it
NOTHING = 1e-9  #: relative change that is rounding


@dataclass(frozen=True, eq=False)
class Driver:
    """A scalar condition of the poses: its label with unit, and display units per unit.

    ``field`` is a logged column or a field of :class:`Conditions`."""

    label: str
    unit: str
    factor: float
    field: str
    part: int | None = None  #: component of a vector

    def of(self, at: Conditions) -> FloatArray:
        """Its value in every pose, (n,), in its unit."""
        values = at.columns[self.field] if self.field in at.columns else getattr(at, self.field)
        return np.asarray(values if self.part is None else values[:, self.part])

    def changed(self, at: Conditions, value: FloatArray) -> Conditions:
        """The same conditions with ``value`` (n,) for this one."""
        if self.field in at.columns:
            return replace(at, columns={**at.columns, self.field: value})
        whole: FloatArray = value
        if self.part is not None:
            whole = np.array(getattr(at, self.field))
            whole[:, self.part] = value
        changes: dict[str, Any] = {self.field: whole}
        return replace(at, **changes)


def drivers(triad: str, at: Conditions) -> Iterator[Driver]:
    """Every scalar condition that these poses know."""
    unit, size = (("g", 1 / STANDARD_GRAVITY_M_S2) if triad == "accelerometer"
                  else ("°/s", DISPLAY[triad][1]))
    felt = "specific force along" if triad == "accelerometer" else "rate about"
    yield Driver("time since the session began", "min", 1 / 60, "time_s")
    yield Driver("rate of the plate", "rpm", 1 / RPM, "spin_rad_s")
    for name in at.columns:
        temperature = name == TEMPERATURE
        label = _column_label(name)
        yield Driver("temperature" if temperature else label, "°C" if temperature else "",
                     1.0, name)
    for k, axis in enumerate(AXES):
        yield Driver(f"{felt} {axis}", unit, size, "vector", k)
        yield Driver(f"{felt} {axis} in the pose before", unit, size, "previous", k)
        yield Driver(f"specific force along {axis}", "g", 1 / STANDARD_GRAVITY_M_S2, "force", k)
        yield Driver(f"vibration along {axis}", "g²", STANDARD_GRAVITY_M_S2**-2, "vibration", k)


def _column_label(name: str) -> str:
    """The name of a logged column, or words for one that a fit adds."""
    if name in OTHER_TRIAD:
        return f"the other triad along {name[-1]}"
    return f"run {name.removeprefix(RUN_COLUMN)}" if name.startswith(RUN_COLUMN) else name


def driver_of(
    triad: str, effect: Effect, shape: float | None, at: Conditions, a: int, j: int
) -> tuple[Driver | None, bool]:
    """The one condition that drives parameter j on axis a, and whether it acts on the scale.

    None where several conditions together do.
    """
    value = effect.evaluate(at, shape)[:, a, j]
    size = float(np.abs(value).max())
    moving = list(_moving(triad, effect, shape, at, a, j, value))
    if len(moving) == 1:
        return moving[0], False
    scale = next((each for each in moving if (each.field, each.part) == ("vector", a)), None)
    if len(moving) != 2 or scale is None:
        return None, False
    twice = effect.evaluate(scale.changed(at, 2 * scale.of(at)), shape)[:, a, j]
    if np.abs(twice - 2 * value).max() > NOTHING * size:
        return None, False
    return next(each for each in moving if each is not scale), True


def _moving(
    triad: str, effect: Effect, shape: float | None, at: Conditions, a: int, j: int,
    value: FloatArray,
) -> Iterator[Driver]:
    """Every condition whose change changes the column."""
    size = float(np.abs(value).max())
    for each in drivers(triad, at):
        now = each.of(at)
        if not np.isfinite(now).all():
            continue
        reach = np.ptp(now) or np.abs(now).max() or 1.0
        with np.errstate(all="ignore"):  # a time before the session can be out of an effect's range
            others = [effect.evaluate(each.changed(at, changed), shape)[:, a, j] - value
                      for changed in (now + SHIFT * reach, -now)]
        if not np.abs(others).max() <= NOTHING * size:
            yield each
