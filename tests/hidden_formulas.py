"""Twenty formulas that no catalogue has, written down before the grammar that is to find them.

Each is the error of a reading in the conditions of its pose, of size one or so; what it is
multiplied by on the three axes is drawn. The first ten were looked at while the grammar was made,
the last ten only when it was finished.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from calib.diagnosis.hypotheses.signature import Projector
from calib.discovery.discover import Discovered, discover
from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from tests.calib.made_poses import made_poses, noisy, rich_poses

RECOVERED = 0.95  #: correlation of the rows

Formula = Callable[[PoseSet, FloatArray], FloatArray]
"""From the poses and their true vectors (n, 3), no unit, to errors (n, 3) or (n, 1)."""


def _column(poses: PoseSet, name: str) -> FloatArray:
    return poses.columns[name][:, None]


def _before(poses: PoseSet, true: FloatArray) -> FloatArray:
    order = np.argsort(poses.time_s)
    before = np.zeros_like(true)
    before[order[1:]] = true[order[:-1]]
    return before


SEEN: Mapping[str, Formula] = {
    "bias ~ power²": lambda p, s: _column(p, "tx_power_w") ** 2,
    "bias ~ power³": lambda p, s: _column(p, "tx_power_w") ** 3,
    "bias ~ supply under 4.8 V": lambda p, s: (_column(p, "supply_v") < 4.8).astype(float),
    "gain ~ exp(-t / 900 s)": lambda p, s: np.exp(-p.time_s[:, None] / 900) * s,
    "gain ~ humidity": lambda p, s: (_column(p, "humidity_pct") - 45) / 5 * s,
    "gain ~ supply²": lambda p, s: (_column(p, "supply_v") - 5) ** 2 * s,
    "bias ~ |T - 28|": lambda p, s: np.abs(_column(p, "temperature_c") - 28),
    "bias ~ tanh of power": lambda p, s: np.tanh((_column(p, "tx_power_w") - 1) / 0.3),
    "|s| ~ humidity": lambda p, s: (_column(p, "humidity_pct") - 45) * np.abs(s),
    "bias ~ exp(-power / 0.5)": lambda p, s: np.exp(-_column(p, "tx_power_w") / 0.5),
}

UNSEEN: Mapping[str, Formula] = {
    "bias ~ sin(2π t / 1500 s)": lambda p, s: np.sin(2 * np.pi * p.time_s[:, None] / 1500),
    "bias ~ √power": lambda p, s: np.sqrt(_column(p, "tx_power_w")),
    "s² ~ temperature": lambda p, s: (_column(p, "temperature_c") - 30) * s**2,
    "bias ~ log(1 + 5 power)": lambda p, s: np.log1p(5 * _column(p, "tx_power_w")),
    "gain ~ |supply - 5|": lambda p, s: np.abs(_column(p, "supply_v") - 5) * s,
    "gain ~ power": lambda p, s: _column(p, "tx_power_w") * s,
    "bias ~ 1 / supply": lambda p, s: 1 / (_column(p, "supply_v") - 4),
    "memory ~ temperature": lambda p, s: (_column(p, "temperature_c") - 30) * _before(p, s),
    "bias ~ humidity · power": lambda p, s: (
        (_column(p, "humidity_pct") - 45) * _column(p, "tx_power_w")),
    "gain ~ power in the second half": lambda p, s: (
        _column(p, "tx_power_w") * (p.time_s[:, None] > np.median(p.time_s)) * s),
}


def with_columns(poses: PoseSet, seed: int) -> PoseSet:
    """``poses`` with two more logged columns that nothing else depends on."""
    random, n = np.random.default_rng([seed, 40]), len(poses)
    return replace(poses, columns={
        **poses.columns,
        "supply_v": 5 + 0.3 * random.standard_normal(n).clip(-2.5, 2.5),
        "tx_power_w": random.uniform(0, 2, n),
    })


def hide(formula: Formula, poses: PoseSet, true: FloatArray, sds: float, seed: int) -> PoseSet:
    """``poses`` that err by ``formula``, on all axes together by ``sds`` of their noise, rms."""
    random = np.random.default_rng([seed, 41])
    unit = np.linalg.norm(true, axis=1).max()
    errors = np.broadcast_to(formula(poses, true / unit), true.shape) * random.normal(size=3)
    errors = errors - errors.mean(axis=0)
    size = np.sqrt(np.mean((errors / poses.sd) ** 2))
    return replace(poses, reading=poses.reading + sds / size * errors)


def poses_of(
    design: str, seed: int, *, more: Callable[[PoseSet, int], PoseSet] | None = None
) -> tuple[PoseSet, FloatArray]:
    """Poses with a draw of their noise and ``more`` columns, and their true vectors."""
    if design == "rich":
        made = rich_poses("gyroscope", seed)
    else:
        made = made_poses("accelerometer", (0.0,), jitter_deg=10.0, seed=seed, corners=True)
    made = with_columns(made, seed)
    made = more(made, seed) if more else made
    return noisy(made, seed), made.reading


def recovered(
    formula: Formula, design: str, sds: float, seed: int,
    *, more: Callable[[PoseSet, int], PoseSet] | None = None,
) -> tuple[bool, str]:
    """Whether the formula that was found is the hidden one, and its words."""
    sound, true = poses_of(design, seed, more=more)
    spoilt = hide(formula, sound, true, sds, seed)
    base = fit(spoilt, Model.of(BASE))
    found = discover(base)
    if found is None:
        return False, "no formula"
    instead = f" [as well: '{found.listed}']" if found.listed else ""
    return _correlation(found, base.poses, sound) > RECOVERED, found.formula.words + instead


def _correlation(found: Discovered, spoilt: PoseSet, sound: PoseSet) -> float:
    """Correlation of the formula with what was hidden, in the rows beside the base."""
    base = fit(spoilt, Model.of(BASE))
    projector = Projector(base)
    errors = (spoilt.reading - sound.reading)[:, :, None]
    hidden = np.zeros(len(base.rows.residual))
    rows = base.equations.whitened(errors, base.rows.vector)[:, 0]
    hidden[: len(rows)] = rows
    where = found.fit.model.slices()[found.formula.name]
    explained = found.fit.rows.jacobian[:, where] @ found.fit.theta[where]
    a, b = projector(hidden), projector(-explained)
    return float(a @ b / np.sqrt((a @ a) * (b @ b)))
