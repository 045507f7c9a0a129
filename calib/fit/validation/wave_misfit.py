"""Waves that fit neither gravity nor a field in the room, and the sds of what rests on them.

A cable that tugs, or a plate that nods twice per turn, turns the sensor in step with the plate, and
a gyroscope feels that. What gravity does to it by a known effect, and what stays in the room, make
waves of few shapes over the poses of a run; the rest of 18 poses' waves is noise, or it is this.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from calib.effects.catalogue import find_effect
from calib.effects.effect import Effect
from calib.fit.least_squares.result import Fit
from calib.fit.rows.wave_rows import WaveRows
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseSet

UNEXPLAINED_P_VALUE = 1e-4
"""Derived: one sound run in ten thousand."""

SAME_WAVES = 1e-8
"""Share of the largest singular value from which a shape of waves is another one. Numerical."""


def with_misfit_of_waves(fit: Fit) -> PoseSet | None:
    """The poses of a gyroscope with sds of the waves that contain their misfit.

    Parameters
    ----------
    fit : Fit
        Whose parameters, but for effects of gravity, the means determine.

    Returns
    -------
    PoseSet or None
        None where some effect of gravity, with what is fixed in the room, explains the waves of
        every run. Else with a note for each run where none does: the sds of its waves are
        multiplied by the root of chi²/dof that a g-sensitivity and the effects of gravity in the
        model leave beside the fit. Waves that then show a g-sensitivity no better than its typical
        size are left out, as those of a level plate are, unless nothing else checks the fit.
    """
    poses, waves = fit.poses.as_stated, fit.equations.waves
    if poses.ring is None or waves is None or poses.triad != "gyroscope":
        return None
    run = np.array([poses.run[place] for place in waves.row_pose])
    factor, notes = np.ones(len(run)), []
    for name in dict.fromkeys(run.tolist()):
        misfit = _misfit(fit, waves, np.flatnonzero(run == name))
        if misfit is not None:
            factor[run == name] = misfit.factor if misfit.is_used else np.inf
            notes.append(f"{name}: {misfit}")
    if not notes:
        return None
    of_ring = factor.reshape(len(poses.ring.place), -1)[:, :1]
    ring = replace(poses.ring, sd=poses.ring.sd * of_ring)
    return replace(poses, ring=ring.only(np.flatnonzero(np.isfinite(of_ring[:, 0]))),
                   notes=(*poses.notes, *notes))


@dataclass(frozen=True)
class _Misfit:
    """What ``chi2`` over ``dof`` the waves of a run leave, and whether they are of use."""

    chi2: float
    dof: int
    is_used: bool

    @property
    def factor(self) -> float:
        return float(np.sqrt(self.chi2 / self.dof))

    def __str__(self) -> str:
        done = (f"The sds of these waves are {self.factor:.2g} times their noise, and what rests "
                f"on them, as a g-sensitivity, is known so much less." if self.is_used else
                "These waves are left out: they show no g-sensitivity of ordinary size.")
        return (f"what goes round once per turn fits neither gravity nor a field in the room "
                f"(chi²/dof {self.chi2 / self.dof:.3g} with {self.dof} degrees of freedom): a "
                f"cable tugs, or the plate nods. {done} Lay the cable loose, set the player "
                f"firmly and record these poses again.")


def _misfit(fit: Fit, waves: WaveRows, rows: IntArray) -> _Misfit | None:
    """The misfit of some of the wave rows; None where an effect of gravity explains it."""
    end = fit.equations.data_count
    residual = fit.rows.residual[end - waves.count : end][rows]

    def columns(effects: Iterable[Effect]) -> FloatArray:
        return np.column_stack([
            waves.columns(fit.rows, effect, fit.shapes.get(effect.name))[rows]
            for effect in effects])

    g_sensitivity, in_square = map(find_effect, ("g_sensitivity", "g_squared_sensitivity"))
    sensed = columns([g_sensitivity])
    by_model = columns([g_sensitivity, *(e for e in fit.model.effects if "force" in e.needs)])
    any_shape = np.column_stack([by_model, columns([in_square]), waves.common[rows]])
    squares, dof = _left(residual, any_shape)
    if dof < 1 or chi2.sf(squares, dof) >= UNEXPLAINED_P_VALUE:
        return None
    squares, dof = _left(residual, by_model)
    shown = float(np.median(np.linalg.svd(sensed, compute_uv=False)))
    typical = g_sensitivity.page.typical["MPU-6050"].si_for("gyroscope")
    of_means = len(fit.equations.magnitude) + 3 * len(fit.equations.null)
    return _Misfit(squares, dof, is_used=(
        of_means <= fit.model.size or shown * (typical or 0.0) > np.sqrt(squares / dof)))


def _left(residual: FloatArray, columns: FloatArray) -> tuple[float, int]:
    """Sum of squares of rows (d,) beside columns (d, k), all in sds, and its degrees of freedom."""
    unit = columns / np.maximum(np.linalg.norm(columns, axis=0), NO_LENGTH)
    shape, size, _ = np.linalg.svd(unit, full_matrices=False)
    shape = shape[:, size > SAME_WAVES * size[0]]
    rest = residual - shape @ (shape.T @ residual)
    return float(rest @ rest), len(rest) - shape.shape[1]
