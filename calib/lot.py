"""Many sensors of one design: the calibration of each, and the effects that the lot lacks.

The pose sets come in blocks, so that memory holds one block at a time. A block is a few stacks
(:func:`calib.fit.least_squares.solver.fit_sets`); only the parameters of Angrisano et al. and their
sds are kept for each sensor. The effects that the lot lacks are searched in further passes over the
same blocks (:mod:`calib.diagnosis.population.pool`).

A station (a plate, a camera) whose rate is wrong by a factor makes all gains measured on it wrong,
and no single session can show it. Between stations it shows: their mean gains differ by more than
the sensors' own spread explains.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.population.evidence import Trial, evidence_of
from calib.diagnosis.population.lot import LotEvidence
from calib.diagnosis.population.pool import Pool, pool
from calib.diagnosis.population.random_effects import RandomEffects, random_effects
from calib.effects.catalogue import BASE
from calib.errors import CalibrationError
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit_sets
from calib.fit.least_squares.unknown_sd import tests_the_model
from calib.fit.model import Model
from calib.fit.noise_size import Noise
from calib.fit.parameters import TriadParameters, triad_parameters
from calib.fit.triad.calibration import calibrate_triad
from calib.fit.triad.determined import is_undetermined
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import AXES, FloatArray, IntArray
from calib.poses.pose_set import PoseSet

FEWEST_OF_STATION = 2  #: sensors; derived: one has no spread to tell its station's error from


@dataclass(frozen=True, eq=False)
class SensorPoses:
    """The poses of one sensor of a lot, and the ``station`` where it was measured; empty if one."""

    sensor: str
    poses: PoseSet
    station: str = ""


Passes = Callable[[], Iterable[Sequence[SensorPoses]]]
"""Passes over a lot: each call gives its sensors in blocks, from the first to the last."""


@dataclass(frozen=True, eq=False)
class CalibratedBlock:
    """The sensors of one block.

    Parameters
    ----------
    sensors, stations : tuple of str, length S
        Those that are calibrated.
    parameters : TriadParameters
        Of S sensors, their covariance with the variance of the noise that is to be expected.
    chi2, dof, p_value : array, shape (S,)
    poses : array of int, shape (S,)
        Number of poses of each.
    refusals : dict of str to CalibrationError
        Why the others are not, by their names.
    sizes : dict of str to (array, array), both shape (S,)
        Largest parameter of each further effect of the model and its sd, in its SI unit.
    """

    sensors: tuple[str, ...]
    stations: tuple[str, ...]
    parameters: TriadParameters
    chi2: FloatArray
    dof: IntArray
    p_value: FloatArray
    poses: IntArray
    refusals: dict[str, CalibrationError]
    sizes: dict[str, tuple[FloatArray, FloatArray]]

    def columns(self, names: Sequence[str]) -> dict[str, FloatArray]:
        """The parameters of every sensor and their sds by ``NAME_AXIS`` and ``NAME_AXIS_sd``, (S,).

        ``names`` are those of misalignment (rad), bias (counts) and scale (counts per SI unit).
        """
        value = self.parameters
        groups = (value.misalignment_rad, value.bias_counts, value.scale_counts_per_unit)
        columns: dict[str, FloatArray] = {}
        for name, group, sd in zip(names, groups, value.sd, strict=True):
            for i, axis in enumerate(AXES):
                columns |= {f"{name}_{axis}": group[:, i], f"{name}_{axis}_sd": sd[:, i]}
        return columns


def calibrate_blocks(passes: Passes, model: Model, spec: TriadSpec) -> Iterator[CalibratedBlock]:
    """Calibrate every sensor of a lot.

    Parameters
    ----------
    passes : callable
    model : Model
    spec : TriadSpec
        The data sheet that made the readings nominal.

    Yields
    ------
    CalibratedBlock
        Of one stack; sensors of other poses follow in stacks of their own.
    """
    for block in passes():
        for fits in fit_sets([one.poses for one in block], model):
            refusals = {block[i].sensor: error for i, error in fits.refusals.items()}
            if fits.fitted is None:
                index, fitted = np.zeros(0, dtype=int), None
            else:
                index, fitted, refused = _determined(fits.index, fits.fitted, spec)
                refusals |= {block[i].sensor: error for i, error in refused.items()}
            of_block = [block[int(i)] for i in index]
            yield _calibrated(of_block, fitted, model, spec, refusals)


def _determined(
    index: IntArray, fitted: Fit, spec: TriadSpec
) -> tuple[IntArray, Fit | None, dict[int, CalibrationError]]:
    """The sets ``index`` with determined parameters, their fits, and reasons why others are not."""
    sets = fitted.equations.surroundings.sets
    value = triad_parameters(fitted.model, fitted.theta, fitted.cov, spec)
    largest = np.array([poses.reference.magnitude.max(initial=0.0) for poses in sets])
    lost = is_undetermined(value, np.where(largest > 0, largest, np.nan)).any(axis=(1, 2))
    refused: dict[int, CalibrationError] = {}
    for k in np.flatnonzero(lost):
        try:
            calibrate_triad(fitted.one(int(k)), spec)
        except CalibrationError as error:
            refused[int(index[k])] = error
    kept = np.array([k for k, i in enumerate(index) if int(i) not in refused], dtype=int)
    if len(kept) == len(index):
        return index, fitted, refused
    return index[kept], fitted.take(kept) if kept.size else None, refused


def _calibrated(
    block: Sequence[SensorPoses], fitted: Fit | None, model: Model, spec: TriadSpec,
    refusals: dict[str, CalibrationError],
) -> CalibratedBlock:
    names = tuple(one.sensor for one in block), tuple(one.station for one in block)
    poses = np.array([len(one.poses) for one in block], dtype=int)
    if fitted is None:
        nothing = np.zeros((0, 3))
        parameters = TriadParameters(nothing, nothing, nothing, np.zeros((0, 9, 9)))
        return CalibratedBlock(*names, parameters, np.zeros(0), np.zeros(0, dtype=int),
                               np.zeros(0), poses, refusals, {})
    known = np.array([tests_the_model(one) for one in fitted.equations.surroundings.sets])
    noise = Noise(fitted.dof, fitted.noise_dof, known)
    widened = noise.expected_variance(fitted.chi2)[:, None, None]
    common = fitted.common_shift @ fitted.common_shift.swapaxes(1, 2)
    cov = common + widened * (fitted.cov - common)
    parameters = triad_parameters(model, fitted.theta, cov, spec)
    sizes, each, sd = {}, np.arange(len(poses)), np.sqrt(np.diagonal(cov, axis1=1, axis2=2))
    for name, where in model.slices().items():
        largest = where.start + np.abs(fitted.theta[:, where]).argmax(axis=1)
        sizes[name] = fitted.theta[each, largest], sd[each, largest]
    return CalibratedBlock(
        *names, parameters, fitted.chi2, fitted.dof, fitted.p_value, poses, refusals,
        {name: size for name, size in sizes.items() if name not in BASE})


def pool_of_lot(passes: Passes, model: Model) -> Pool:
    """Effects that ``model`` lacks in a lot, by all its sensors together."""
    def blocks(trials: Sequence[Trial]) -> Iterator[LotEvidence]:
        wanted = {trial.name for trial in trials}
        for block in passes():
            for fits in fit_sets([one.poses for one in block], model):
                if fits.fitted is not None:
                    names = [block[int(i)].sensor for i in fits.index]
                    yield LotEvidence.from_stack(
                        names, evidence_of(fits.fitted, names=wanted))

    return pool(blocks)


def station_errors(
    station: Sequence[str], scale: FloatArray
) -> tuple[dict[str, tuple[float, float]], RandomEffects] | None:
    """Relative deviation of the gains of each station from the lot's.

    Parameters
    ----------
    station : sequence of str, length S
        Where each sensor was measured.
    scale : array, shape (S, 3)
        Scale of every sensor, in any unit.

    Returns
    -------
    errors : dict of str to (float, float)
        Of each station its ``reference_scale`` and the sd of that.
    effects : RandomEffects
        Mean and spread of the stations; their probability to be the same says whether one errs.
    None
        There are not two stations with enough sensors.
    """
    gain = np.log(np.abs(scale)).mean(axis=1)
    names, number = np.unique(np.array(station), return_inverse=True)
    count = np.bincount(number)
    mean = np.bincount(number, gain) / count
    used = count >= FEWEST_OF_STATION
    if used.sum() < 2:
        return None
    within = gain - mean[number]
    variance = float((within[used[number]] ** 2).sum() / (count[used] - 1).sum()) / count[used]
    effects = random_effects(mean[used], variance)
    off = mean[used] - effects.mean
    errors = {str(name): (float(one), float(np.sqrt(square)))
              for name, one, square in zip(names[used], off, variance, strict=True)}
    return errors, effects
