"""Driver of an effect: the condition of the poses against which its chart is drawn.

It is found from the effect itself: the one condition whose change changes a column is its driver. A
column that depends on several conditions at once (a product in the user's expression, the direction
of the pose before) is drawn against its own value.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.effects.effect import Effect
from calib.numbers import RPM
from calib.poses.conditions import OTHER_TRIAD, RUN_COLUMN, Conditions
from calib.poses.imu_log import AXES, SI_UNIT, TEMPERATURE, FloatArray
from pipeline.text.formatting import DISPLAY

SHIFT = 0.37  #: share of the range of a condition, to test whether an effect depends on it
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
    """Every scalar condition that is known in these poses."""
    unit, size, felt = {
        "accelerometer": ("g", 1 / STANDARD_GRAVITY_M_S2, "specific force along"),
        "gyroscope": ("°/s", DISPLAY["gyroscope"][1], "rate about"),
    }.get(triad, (SI_UNIT[triad], 1.0, "reading along"))
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


@dataclass(frozen=True, eq=False)
class Dependence:
    """The columns of an effect in these poses, and the conditions that change them.

    ``columns`` (n, 3, k), SI per unit of each parameter; with every condition the largest change of
    each of them that its change causes, (3, k).
    """

    effect: Effect
    shape: float | None
    at: Conditions
    columns: FloatArray
    changes: tuple[tuple[Driver, FloatArray], ...]

    def driver_of(self, a: int, j: int) -> tuple[Driver | None, bool]:
        """The one condition that drives parameter j on axis a, and whether it acts on the scale.

        None where several conditions together do.
        """
        value = self.columns[:, a, j]
        nothing = NOTHING * float(np.abs(value).max())
        moving = [one for one, change in self.changes if not change[a, j] <= nothing]
        if len(moving) == 1:
            return moving[0], False
        scale = next((one for one in moving if (one.field, one.part) == ("vector", a)), None)
        if len(moving) != 2 or scale is None:
            return None, False
        doubled = scale.changed(self.at, 2 * scale.of(self.at))
        twice = self.effect.evaluate(doubled, self.shape)[:, a, j]
        if np.abs(twice - 2 * value).max() > nothing:
            return None, False
        return next(one for one in moving if one is not scale), True


def dependence(
    triad: str, effect: Effect, shape: float | None, at: Conditions
) -> Dependence:
    """Change every condition of the poses, one after the other, and compare the columns.

    Raises
    ------
    Undetermined
        A user's function fails at conditions that these poses do not have.
    """
    columns = effect.evaluate(at, shape)
    changes = []
    for driver in drivers(triad, at):
        now = driver.of(at)
        if not np.isfinite(now).all():
            continue
        reach = np.ptp(now) or np.abs(now).max() or 1.0
        with np.errstate(all="ignore"):  # a time before the session can be out of an effect's range
            others = [effect.evaluate(driver.changed(at, changed), shape) - columns
                      for changed in (now + SHIFT * reach, -now)]
        changes.append((driver, np.abs(others).max(axis=(0, 1))))
    return Dependence(effect, shape, at, columns, tuple(changes))
