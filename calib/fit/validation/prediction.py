"""Expected error of a calibration on the next log: sd of a corrected magnitude, by direction.

    sd(n)² = g cov gᵀ,   g = n · ds/dtheta   at the true vector m n

with cov that of the parameters, noise and common errors together, and m every magnitude that was
measured. A small residual says nothing about directions without a pose; this does.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.effects.effect import Effect
from calib.fit.least_squares.result import Fit
from calib.fit.rows.residuals import Equations
from calib.fit.rows.sensitive_axes import axes_of, sensor_columns
from calib.fit.triad.calibration import TriadCalibration
from calib.fit.triad.correction import linear_form
from calib.fit.validation.weak_directions import (
    LARGEST_TO_POSE,
    times_a_pose,
    unchecked_poses,
    variances_along,
)
from calib.poses.attitudes import natural_directions, spread_directions
from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseSet
from calib.poses.reference import SAME_MAGNITUDE, Reference

SPREAD_DIRECTIONS = 200
"""Number of directions beside the 26 natural ones, 14° apart: the sd is a smooth function of second
order in n. Numerical."""

LOGS = 25
"""Number of conditions that represent those of another log, of gravity 40° apart. Numerical: root
mean squares over them are known to a seventh."""

@dataclass(frozen=True, eq=False)
class Prediction:
    """Sd of a corrected magnitude over the sphere of directions, SI.

    Attributes
    ----------
    magnitude : array, shape (m,)
        Every magnitude that was measured.
    directions : array, shape (d, 3)
        Unit vectors.
    gradient : array, shape (m, d, p)
        Of the corrected magnitude by the parameters.
    variance : array, shape (m, d)
        By what the poses determine.
    times_a_pose : float
        Ratio of the sd to that of one pose, in the direction where it is largest.
    weakest : array, shape (3,)
        This direction.
    wanted : tuple of array, shape (3,)
        Natural directions in which poses would mend that, the best first.
    unchecked : tuple of str
        The poses that no other pose checks (:data:`..weak_directions.LEAST_REDUNDANCY`).
    unseen : mapping of str to array, shape (m, d)
        Variance by each effect that the poses cannot see, at the size typical of the sensor.
    untold : mapping of str to array, shape (m, d)
        Variance by each effect of the model that the samples of another log do not tell.
    open : array, shape (m, d)
        Variance by what may be missing and what the model's effects stand for, weighed by their
        probabilities, by formulas that may be off between the values that the poses saw, and by
        noise from pose to pose.
    """

    magnitude: FloatArray
    directions: FloatArray
    gradient: FloatArray
    variance: FloatArray
    times_a_pose: float
    weakest: FloatArray
    wanted: tuple[FloatArray, ...] = ()
    unchecked: tuple[str, ...] = ()
    unseen: Mapping[str, FloatArray] = field(default_factory=dict)
    untold: Mapping[str, FloatArray] = field(default_factory=dict)
    open: FloatArray = field(default_factory=lambda: np.zeros((1, 1)))

    @property
    def sd(self) -> FloatArray:
        """The sd at every magnitude in every direction, all causes together, SI, (m, d)."""
        whole = self.variance + sum((*self.unseen.values(), *self.untold.values())) + self.open
        return np.asarray(np.sqrt(np.maximum(whole, 0.0)))

    @property
    def sd_median(self) -> float:
        """The median over all directions and magnitudes."""
        return float(np.median(self.sd))

    @property
    def sd_worst(self) -> float:
        """The largest over all directions and magnitudes."""
        return float(self.sd.max())

    @property
    def worst_direction(self) -> FloatArray:
        """Unit vector of :attr:`sd_worst`, (3,)."""
        return np.asarray(self.directions[int(np.argmax(self.sd.max(axis=0)))])

    @property
    def by_poses(self) -> float:
        """Root mean square over the sphere of the part that the poses determine."""
        return _rms(self.variance)

    @property
    def by_unseen(self) -> dict[str, float]:
        """Root mean square over the sphere by each effect that the poses cannot see."""
        return {name: _rms(variance) for name, variance in self.unseen.items()}

    @property
    def by_untold(self) -> dict[str, float]:
        """Root mean square over the sphere by each effect that another log does not tell."""
        return {name: _rms(variance) for name, variance in self.untold.items()}

    @property
    def by_open(self) -> float:
        """Root mean square over the sphere by effects that may be missing."""
        return _rms(self.open)

    @property
    def is_mostly_unseen(self) -> bool:
        """Whether more of it comes from typical sizes than from these measurements."""
        return bool(sum(each**2 for each in self.by_unseen.values()) > self.by_poses**2)

    @property
    def holds_everywhere(self) -> bool:
        """Whether no direction is known much worse than one pose there would show it."""
        return self.times_a_pose <= LARGEST_TO_POSE


def predict(calibration: TriadCalibration) -> Prediction | None:
    """Expected error in every direction; None if all poses were at rest.

    The gradient is that under typical conditions: the median time, the medians of the columns.
    """
    fit = calibration.fit
    stated = fit.poses.reference.magnitude.copy()
    if (ring := fit.poses.ring) is not None and np.isfinite(ring.gravity_m_s2).all():
        stated[ring.place] = ring.gravity_m_s2  # of which a mean on a leaning plate is a part
    turning = stated[stated > 0]
    if turning.size == 0:
        return None
    directions = np.vstack([natural_directions(), spread_directions(SPREAD_DIRECTIONS)])
    magnitude = np.array(distinct(turning))
    gradient = np.array(
        [gradient_of(fit, imagined(fit.poses, size * directions)) for size in magnitude])
    pose_sd = float(np.median(fit.equations.magnitude_sd)) * calibration.widening
    times, wanted = times_a_pose(gradient, calibration, pose_sd)
    return Prediction(
        magnitude=magnitude,
        directions=directions,
        gradient=gradient,
        variance=_variance(calibration, magnitude, directions, gradient),
        times_a_pose=float(times.max()),
        weakest=directions[int(np.argmax(times.max(axis=0)))],
        wanted=tuple(directions[wanted]),
        unchecked=unchecked_poses(fit),
    )


def with_sds_of(prediction: Prediction, calibration: TriadCalibration) -> Prediction:
    """``prediction`` with the variance, SI, by other sds of the same parameters."""
    return replace(prediction, variance=_variance(
        calibration, prediction.magnitude, prediction.directions, prediction.gradient))


def _variance(
    calibration: TriadCalibration, magnitude: FloatArray, directions: FloatArray,
    gradient: FloatArray,
) -> FloatArray:
    """Variances (m, d) by the parameters, averaged over the conditions of another log.

    There the gradient differs by the columns of the effects that depend on these.
    """
    fit, of_logs = calibration.fit, gradient[:, None]
    varied = [each for each in fit.model.acting_on("sensor")
              if each.logged or not {"force", "time"}.isdisjoint(each.needs)]
    if varied:
        of_logs = np.repeat(of_logs, LOGS, axis=1)
        where = np.concatenate([np.r_[fit.model.slices()[each.name]] for each in varied])
        for at, size in zip(of_logs, magnitude, strict=True):
            there, here = (effects_along(calibration, varied, logs(fit.poses, size * directions),
                                         fit.shapes) for logs in (other_logs, imagined))
            at[:, :, where] -= there.reshape(LOGS, *here.shape) - here
    return np.asarray([variances_along(at, fit.cov).mean(axis=0) for at in of_logs])


def effects_along(
    calibration: TriadCalibration, effects: Sequence[Effect], poses: PoseSet,
    shapes: Mapping[str, float],
) -> FloatArray:
    """Parts of effects along the vectors of imagined poses (n), SI per parameter (k), (n, k)."""
    true = poses.reading
    axes = axes_of(calibration.correction.linear_form()[0])
    columns = sensor_columns(tuple(effects), poses.conditions(true), shapes, axes)
    return np.asarray(np.einsum("ni,nik->nk", true, columns)
                      / np.linalg.norm(true, axis=1)[:, None])


def _rms(variance: FloatArray) -> float:
    """Root mean square over all directions and magnitudes."""
    return float(np.sqrt(max(float(np.mean(variance)), 0.0)))


def distinct(magnitudes: FloatArray) -> list[float]:
    """The magnitudes that differ by more than ``SAME_MAGNITUDE``, ascending."""
    kept: list[float] = []
    for value in np.sort(magnitudes):
        if not kept or value > kept[-1] * (1 + SAME_MAGNITUDE):
            kept.append(float(value))
    return kept


def gradient_of(fit: Fit, poses: PoseSet) -> FloatArray:
    """Derivative (n, p) of the corrected magnitude by theta, SI, at imagined poses (n)."""
    true = poses.reading
    matrix, offset = linear_form(fit.model, fit.theta)
    linear = true
    sensor = fit.model.acting_on("sensor")
    if sensor:
        size = fit.theta[fit.equations.terms.sensor.index]
        linear = true + sensor_columns(
            sensor, poses.conditions(true), fit.shapes, axes_of(matrix)) @ size
    readings = np.asarray((linear - offset) @ np.linalg.inv(matrix).T)
    equations = Equations.of(replace(poses, reading=readings), fit.model)
    jacobian = equations.rows(fit.theta, np.zeros_like(fit.eta), fit.shapes).jacobian
    gradient = jacobian[: len(true), : fit.model.size] * equations.magnitude_sd[:, None]
    gradient[:, equations.terms.reference.index] = 0.0  # the next log has a different reference
    return np.asarray(gradient)


def typical_force(poses: PoseSet) -> float:
    """The median specific force of poses, m/s²; standard gravity where none was logged."""
    logged = np.linalg.norm(poses.force, axis=1)
    logged = logged[np.isfinite(logged)]
    return float(np.median(logged)) if logged.size else STANDARD_GRAVITY_M_S2


def imagined(
    poses: PoseSet, true: FloatArray, up: FloatArray | None = None, like: IntArray | None = None,
) -> PoseSet:
    """Poses that read true vectors (n, 3), SI, under the typical conditions of the real ones.

    Gravity points ``up`` (3,) or (n, 3), by default along the vectors; each is ``like`` (n,) the
    real pose of this number, where it is stated.
    """
    n = len(true)
    size = np.linalg.norm(true, axis=1)
    up = true / size[:, None] if up is None else np.broadcast_to(up, (n, 3))
    gravity = typical_force(poses)
    q = len(poses.reference.common_names)

    def conditions(values: FloatArray) -> FloatArray:
        typical = np.broadcast_to(np.median(values, axis=0), (n, *values.shape[1:]))
        return typical if like is None else values[like]

    return PoseSet(
        triad=poses.triad,
        label=("",) * n,
        run=("",) * n,
        reading=true,
        sd=conditions(poses.sd),
        force=gravity * up,
        vibration=conditions(poses.vibration),
        spin_rad_s=size if poses.triad == "gyroscope" else np.zeros(n),
        time_s=conditions(poses.time_s),
        expected=np.zeros((n, 3)),
        reference=Reference(size, np.zeros(n), np.zeros((n, q)), poses.reference.common_names),
        columns={name: conditions(values) for name, values in poses.columns.items()},
    )


def other_logs(poses: PoseSet, true: FloatArray) -> PoseSet:
    """Poses that read true vectors (n, 3), SI, in ``LOGS`` other logs, (``LOGS`` n).

    All n of one log come after those of another. Each log has a gravity, a time and values of
    columns of its own; time and columns are drawn from the poses, each by itself.
    """
    drawn, n = np.random.default_rng(0), len(true)

    def of_logs(values: FloatArray) -> FloatArray:
        return np.repeat(drawn.choice(values, LOGS), n)

    return replace(
        imagined(poses, np.tile(true, (LOGS, 1)), np.repeat(spread_directions(LOGS), n, axis=0)),
        time_s=of_logs(poses.time_s),
        columns={name: of_logs(values) for name, values in poses.columns.items()})
