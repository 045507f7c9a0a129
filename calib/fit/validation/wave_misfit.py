"""Waves that fit neither gravity nor the Earth's rate, and the sds of what depends on them.

A cable that tugs, or a plate that nods, turns the sensor in step with the plate; a gyroscope senses
that, and an accelerometer senses gravity turned. Gravity (through a known effect) and fields fixed
in the room make waves of few shapes over the poses of a run; the rest of the poses' waves is noise,
or this disturbance. A motor's field is fixed in the room: it may be larger than the Earth's rate,
and if a gyroscope senses it through a matrix, its component along the lean makes the waves of a
g-sensitivity and that across it the same a quarter of a turn later.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import fdtrc

from calib.effects.catalogue import find_effect
from calib.effects.effect import EFFECTS, Effect
from calib.effects.needs import unavailable
from calib.fit.least_squares.result import Fit
from calib.fit.linear import orthonormal_columns
from calib.fit.rows.wave_rows import WaveRows
from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseSet
from calib.poses.reference import room_names
from calib.poses.samples.in_step import NEIGHBOURS
from calib.rounding import two_digits

UNEXPLAINED_P_VALUE = 1e-4
"""Probability of a misfit by chance: one sound run in ten thousand. Derived."""


def with_misfit_of_waves(fit: Fit) -> PoseSet | None:
    """The poses with sds of the waves that contain their misfit.

    Parameters
    ----------
    fit : Fit
        Of a gyroscope one whose parameters, but for effects of gravity, the means determine.

    Returns
    -------
    PoseSet or None
        None where some effect of gravity, with the Earth's rate, explains the waves of every run.
        Else with a note for each run where none does.

        Gyroscope: where a larger rate that stays in the room explains them, that is the sd of it.
        Else the sds of its waves are multiplied by the root of chi²/dof that a g-sensitivity
        and the effects of gravity in the model leave beside the fit. Waves that then show a
        g-sensitivity no better than its typical size are left out, as those of a level plate are,
        unless nothing else checks the fit. Accelerometer: what comes twice per turn is left out,
        and the sds of what comes once per turn are multiplied by the root of the chi²/dof that the
        model leaves of that.
    """
    poses, waves = fit.poses.as_stated, fit.equations.waves
    if poses.ring is None or waves is None:
        return None
    misfit_of = _of_gyroscope if poses.triad == "gyroscope" else _of_accelerometer
    row_run = np.array(poses.run)[waves.row_pose]
    run = np.array(poses.run)[poses.ring.place]
    factor, notes = np.ones((len(run), 2, 1)), []
    room, common = np.ones(len(run)), poses.reference.common.copy()
    for name in dict.fromkeys(run.tolist()):
        misfit = misfit_of(fit, waves, np.flatnonzero(row_run == name))
        if misfit is not None:
            factor[run == name, :, 0] = misfit.factors
            room[run == name] = misfit.of_room
            common[:, _of_the_room(poses, name)] *= misfit.of_room
            notes.append(f"{name}: {misfit.text}")
    if not notes:
        return None
    ring = replace(poses.ring, sd=poses.ring.sd * factor, room_rad_s=poses.ring.room_rad_s * room)
    return replace(poses, ring=ring.only(np.flatnonzero(np.isfinite(factor[:, 0, 0]))),
                   reference=replace(poses.reference, common=common),
                   notes=(*poses.notes, *notes))


@dataclass(frozen=True)
class _Misfit:
    """Factors of the sds of waves once and twice per turn, NaN if left out, and a note.

    ``of_room`` is the factor of the sd of a rate that is fixed in the room.
    """

    factors: tuple[float, float]
    text: str
    of_room: float = 1.0


TUGS = "a cable tugs, or the plate nods."
AGAIN = "Lay the cable loose, set the player firmly and record these poses again."
FIELD = "as a field does, of a motor's magnet for one"
AWAY = "Lay the sensor higher above the motor and record these poses again."


def _of_the_room(poses: PoseSet, run: str) -> list[int]:
    """Columns of the common errors that are fixed in the room, for one run of a gyroscope."""
    names = poses.reference.common_names
    return [i for i, name in enumerate(names) if name in room_names(run)]


def _residual(fit: Fit, waves: WaveRows) -> FloatArray:
    end = fit.equations.data_count
    return np.asarray(fit.rows.residual[end - waves.count : end])


def _of_accelerometer(fit: Fit, waves: WaveRows, rows: IntArray) -> _Misfit | None:
    """The misfit of the wave rows of a run; None where an effect of attitude explains it."""
    at, known = fit.equations.at_start, fit.model.names
    by_attitude = [effect for effect in EFFECTS.values()
                   if effect.acts_on == "sensor" and not effect.needs and effect.shape is None
                   and effect.name not in known and unavailable(effect, at) is None]
    with_them = fit.equations.extended(by_attitude)
    theta = np.pad(fit.theta, (0, with_them.model.size - fit.model.size))
    squares, dof = _beyond_means(fit, with_them.rows(theta, fit.eta, fit.shapes).jacobian, rows)
    if dof < 1 or _is_noise(squares, dof, waves, rows):
        return None
    of_once, dof_once = _beyond_means(fit, fit.rows.jacobian, rows[rows < waves.once_count])
    factor = float(np.sqrt(max(1.0, of_once / max(dof_once, 1))))
    return _Misfit((factor, np.nan), (
        f"what goes round once and twice per turn fits neither gravity nor an effect of attitude "
        f"(chi²/dof {squares / dof:.3g} with {dof} degrees of freedom): {TUGS} What comes twice "
        f"per turn is left out, and the sds of what comes once per turn are {two_digits(factor)} "
        f"times their noise. {AGAIN}"))


def _of_gyroscope(fit: Fit, waves: WaveRows, rows: IntArray) -> _Misfit | None:
    """The misfit of the wave rows of a run; None where an effect of gravity explains it."""
    residual = _residual(fit, waves)[rows]
    room = _of_the_room(fit.poses, fit.poses.run[waves.row_pose[rows[0]]])

    def columns(effects: Iterable[Effect]) -> FloatArray:
        return np.column_stack([
            waves.columns(fit.rows, effect, fit.shapes.get(effect.name))[rows]
            for effect in effects])

    g_sensitivity, in_square = map(find_effect, ("g_sensitivity", "g_squared_sensitivity"))
    sensed = columns([g_sensitivity])
    by_model = columns([g_sensitivity, *(e for e in fit.model.effects if "force" in e.needs)])
    any_shape = np.column_stack([waves.common[rows], by_model, columns([in_square])])
    squares, dof = _left(residual, any_shape)
    if dof < 1:
        return None
    if _is_noise(squares, dof, waves, rows):
        return _of_a_steady_rate(fit, waves, rows, any_shape, room)
    # Cosine and sine of two directions: a quarter of a turn later.
    later = sensed.reshape(-1, 2, 2, sensed.shape[1])[:, ::-1] * np.array([1, -1])[:, None, None]
    with_field = _left(residual, np.column_stack([any_shape, later.reshape(sensed.shape)]))
    is_field = with_field[1] > 0 and _is_noise(*with_field, waves, rows)
    squares, dof = _left(residual, by_model)
    shown = float(np.median(np.linalg.svd(sensed, compute_uv=False)))
    typical = g_sensitivity.page.typical["MPU-6050"].si_for("gyroscope")
    of_means = len(fit.equations.magnitude) + 3 * len(fit.equations.null)
    factor = float(np.sqrt(squares / dof))
    is_used = of_means <= fit.model.size or shown * (typical or 0.0) > factor
    done = (f"The sds of these waves are {two_digits(factor)} times their noise, and what rests "
            f"on them, as a g-sensitivity, is known so much less." if is_used else
            "These waves are left out: they show no g-sensitivity of ordinary size.")
    cause = (f"but stays in the room, {FIELD}." if is_field else f"or stays in the room: {TUGS}")
    return _Misfit((factor if is_used else np.nan, np.nan), (
        f"what goes round once per turn does not follow gravity (chi²/dof {squares / dof:.3g} with "
        f"{dof} degrees of freedom), {cause} {done} {AWAY if is_field else AGAIN}"))


def _of_a_steady_rate(
    fit: Fit, waves: WaveRows, rows: IntArray, any_shape: FloatArray, room: list[int]
) -> _Misfit | None:
    """A rate fixed in the room, columns ``room``, other than the Earth's; None if there is none."""
    residual = _residual(fit, waves)[rows]
    others, beside = orthonormal_columns(np.delete(any_shape, room, axis=1)), any_shape[:, room]
    beside = beside - others @ (others.T @ beside)
    shape, shown, turn = np.linalg.svd(beside, full_matrices=False)
    is_shown = shown > 1.0  # known better than beforehand
    size = (turn @ fit.eta[room])[is_shown] + (shape.T @ residual)[is_shown] / shown[is_shown]
    squares = float((size**2 / (1 + shown[is_shown] ** -2.0)).sum())
    if not room or _is_noise(squares, len(room), waves, rows):
        return None
    in_sds = float(np.linalg.norm(size))  # two of which make up the Earth's
    return _Misfit((1.0, np.nan), (
        f"what goes round once per turn holds a rate that stays in the room, "
        f"{two_digits(in_sds / np.sqrt(2))} times as large as the Earth's horizontal one, {FIELD}. "
        f"A g-sensitivity that is alike on all axes looks the same, and is known so much less. "
        f"{AWAY}"), in_sds)


def _is_noise(squares: float, dof: int, waves: WaveRows, rows: IntArray) -> bool:
    """Whether the rows of a run are only noise, whose sds its waves show by themselves."""
    rings = len(np.unique(waves.row_pose[rows]))
    shown = 2 * len(NEIGHBOURS) * rings * 3 * (2 if waves.of_gravity else 1)
    return bool(fdtrc(dof, shown, squares / dof) >= UNEXPLAINED_P_VALUE)


def _beyond_means(fit: Fit, columns: FloatArray, rows: IntArray) -> tuple[float, int]:
    """Misfit of some wave rows to columns (r, k) beyond that of the means alone."""
    first, end = fit.equations.data_count - fit.equations.wave_count, fit.equations.data_count
    means = np.r_[:first, end : len(columns)]
    both = np.concatenate([means, first + rows])
    (more, more_dof), (less, less_dof) = (
        _left(fit.rows.residual[which], columns[which]) for which in (both, means))
    return more - less, more_dof - less_dof


def _left(residual: FloatArray, columns: FloatArray) -> tuple[float, int]:
    """Sum of squares and degrees of freedom of rows (d,) after a fit of columns (d, k), in sds."""
    shape = orthonormal_columns(columns)
    rest = residual - shape @ (shape.T @ residual)
    return float(rest @ rest), len(rest) - shape.shape[1]


