"""Mistakes in the files, done to arrays of poses: each is named, and noise alone is none."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from calib.consistency.common_mistakes import block_mistakes, odd_mistakes
from calib.consistency.mistakes import (
    LEFT_OVER,
    possible_mistakes,
    require_no_mistake,
    require_one_sensor,
)
from calib.diagnosis.diagnose import diagnose
from calib.effects.catalogue import BASE
from calib.errors import Contradiction, FitFailed, Undetermined
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit, fit_sets
from calib.fit.model import Model
from calib.fit.validation.odd_poses import left_over, quadric
from calib.poses.imu_log import BoolArray, FloatArray, Triad
from calib.poses.pose_set import PoseSet
from tests.calib.made_poses import (
    FAST,
    MODEL,
    SLOW,
    base_theta,
    made_poses,
    noisy,
    read_through,
    with_noise,
)

SWAPPED = np.eye(3)[[1, 0, 2]]
Y_MIRRORED = np.diag([1.0, -1.0, 1.0])
FASTER = 1.35 * SLOW  #: as 45 to 33 rpm


def session(triad: Triad, seed: int = 0, runs: int = 1) -> PoseSet:
    """Poses read with noise: four runs of the gyroscope, ``runs`` of the accelerometer."""
    speeds = (SLOW, FASTER, FAST, 0.0) if triad == "gyroscope" else runs * (0.0,)
    return noisy(made_poses(triad, speeds, seed=seed, shared_sd=1e-4), seed)


def turned(poses: PoseSet, matrix: FloatArray, member: BoolArray) -> PoseSet:
    """The readings of some poses multiplied by a matrix."""
    reading, sd = poses.reading.copy(), poses.sd.copy()
    reading[member] = reading[member] @ matrix.T
    sd[member] = sd[member] @ np.abs(matrix.T)
    return replace(poses, reading=reading, sd=sd)


def at_rates(poses: PoseSet, factors: dict[str, float]) -> PoseSet:
    """Other rates stated for some runs."""
    factor = np.array([factors.get(run, 1.0) for run in poses.run])
    magnitude = poses.reference.magnitude * factor
    return replace(poses, reference=replace(poses.reference, magnitude=magnitude))


def run(poses: PoseSet, name: str) -> BoolArray:
    return np.array(poses.run) == name


def largest_y(poses: PoseSet) -> BoolArray:
    """The three poses that a mirrored y changes most."""
    size = np.abs(poses.reading[:, 1])
    return size >= np.sort(size)[-3]


def fitted_if_possible(poses: PoseSet) -> Fit | None:
    try:
        return fit(poses, MODEL)
    except (FitFailed, Undetermined):
        return None


CASES: dict[str, tuple[Triad, Callable[[PoseSet], PoseSet], str]] = {
    "axes of one run": ("gyroscope", lambda p: turned(p, SWAPPED, run(p, "run 1")),
                        r"x and y are exchanged in the poses of run 'run 1'"),
    "an axis of one run": ("gyroscope", lambda p: turned(p, Y_MIRRORED, run(p, "run 1")),
                           r"y has the opposite sign in the poses of run 'run 1'"),
    "the range of one run": ("gyroscope", lambda p: turned(p, 0.5 * np.eye(3), run(p, "run 0")),
                             r"the readings are halved in the poses of run 'run 0'"),
    "the rates of two runs": (
        "gyroscope", lambda p: at_rates(p, {"run 0": FASTER / SLOW, "run 1": SLOW / FASTER}),
        r"of run 'run 0' and run 'run 1' are exchanged"),
    "the rate of one run": ("gyroscope", lambda p: at_rates(p, {"run 0": FASTER / SLOW}),
                            r"in run 'run 0', not at"),
    "axes from a pose on": (
        "accelerometer", lambda p: turned(p, SWAPPED, np.arange(len(p)) >= 9),
        r"x and y are exchanged from pose 10 on"),
    "an axis of three poses": (
        "accelerometer", lambda p: turned(p, Y_MIRRORED, largest_y(p)),
        r"y has the opposite sign in pose \d+ and pose \d+ and pose \d+ "),
    "the range of three poses": (
        "accelerometer", lambda p: turned(p, 0.5 * np.eye(3), np.isin(np.arange(18), [2, 7, 8])),
        r"halved in pose 3 and pose 8 and pose 9 "),
    "the unit of one pose": (
        "accelerometer", lambda p: turned(p, 1e3 * np.eye(3), np.arange(len(p)) == 4),
        r"in mg instead of g in pose 5 "),
}


@pytest.mark.parametrize("case", CASES)
def test_a_mistake_is_named_with_its_place(case: str) -> None:
    triad, spoil, words = CASES[case]
    poses = spoil(session(triad))
    with pytest.raises(Contradiction, match=words):
        require_no_mistake(poses, MODEL, fitted_if_possible(poses))


@pytest.mark.parametrize("case", [
    "an effect", "an axis of one run", "the range of one run", "twice the range of one run",
    "axes from a pose on", "an axis of three poses"])
def test_what_is_not_tried_leaves_too_much(case: str) -> None:
    """Each mistake that the quadrics of two parts rule out leaves too much in the fit itself."""
    triad, spoil, _ = CASES.get(case.removeprefix("twice "), ("accelerometer", lambda p: p, ""))
    poses = session(triad, runs=3)
    if triad == "accelerometer":
        poses = replace(poses, run=("rest",) * len(poses))
    if case == "an effect":
        model = Model.of((*BASE, "cubic"))
        theta = np.append(base_theta(MODEL, triad), [1e-4, -5e-5, 2e-4])
        poses = with_noise(read_through(poses, model, theta), np.random.default_rng(1))
    poses = spoil(poses)
    if case.startswith("twice"):  # of what it is halved in the other case
        poses = turned(poses, 4 * np.eye(3), run(poses, "run 0"))
    mistakes = [*block_mistakes(poses), *odd_mistakes(poses, largest_y(poses))]
    whole = float(left_over(*quadric(poses))[0][0])
    possible = possible_mistakes(mistakes, poses, whole)
    assert len(possible) < len(mistakes)
    out = [one for one in mistakes if one not in possible]
    for fits in fit_sets([one.undone for one in out[::7]], MODEL):
        if fits.fitted is not None:
            assert (fits.fitted.chi2 - fits.fitted.dof > LEFT_OVER * (
                whole - fits.fitted.dof)).all()


@pytest.mark.parametrize("factor", [0.52, 1.9, 300.0])
def test_a_pose_that_no_common_mistake_mends_is_not_said_to_be_mended(factor: float) -> None:
    for seed in range(2):
        whole = session("accelerometer", seed)
        poses = turned(whole, factor * np.eye(3), np.arange(len(whole)) == 4)
        fitted = fitted_if_possible(poses)
        if fitted is not None:
            require_no_mistake(poses, MODEL, fitted)
        else:
            with pytest.raises(Contradiction, match=r"readings of pose 5 contradict"):
                require_no_mistake(poses, MODEL, None)


def test_two_poses_of_one_attitude_with_a_constant_are_bad_poses_and_no_exchange_of_axes() -> None:
    """One equation, which some of 47 exchanges meets by chance."""
    twice = session("accelerometer", runs=2)
    odd = np.isin(np.arange(len(twice)), [7, 25])
    poses = replace(twice, reading=twice.reading + odd[:, None] * np.array([0.08, -0.03, 0.02]))
    fitted = fit(poses, MODEL)
    require_no_mistake(poses, MODEL, fitted)
    assert sorted(diagnose(fitted).group) == ["pose 26", "pose 8"]


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_noise_alone_is_no_mistake_in_twenty_sessions(triad: Triad) -> None:
    for seed in range(20):
        poses = session(triad, seed)
        fitted = fit(poses, MODEL)
        require_no_mistake(poses, MODEL, fitted)
        require_one_sensor(poses, MODEL, fitted)


@pytest.mark.parametrize(("triad", "name", "size"), [
    ("gyroscope", "quadratic", [0.002, -0.001, 0.003]),
    ("gyroscope", "asymmetry", [0.01, 0.02, -0.01]),
    ("gyroscope", "temperature_scale", [1e-3, -5e-4, 2e-3]),
    ("gyroscope", "g_sensitivity", [1e-4 * i for i in range(-4, 5)]),
    ("accelerometer", "cubic", [1e-4, -5e-5, 2e-4]),
])
def test_a_missing_effect_is_no_mistake_in_the_files(
    triad: Triad, name: str, size: list[float]
) -> None:
    model = Model.of((*BASE, name))
    theta = np.r_[base_theta(MODEL, triad), size]
    for seed in range(2):
        speeds = (SLOW, FASTER, FAST, 0.0) if triad == "gyroscope" else (0.0,)
        poses = made_poses(triad, speeds, seed=seed, shared_sd=1e-4)
        read = with_noise(read_through(poses, model, theta), np.random.default_rng(seed))
        fitted = fit(read, MODEL)
        assert fitted.p_value < 1e-10
        require_no_mistake(read, MODEL, fitted)
        require_one_sensor(read, MODEL, fitted)


def test_another_zero_than_at_rest_is_no_other_unit() -> None:
    poses = noisy(made_poses("gyroscope", (SLOW, 0.0), shared_sd=1e-4), 0)
    turning = run(poses, "run 0")  # the chip takes its zero off at rest
    zero = poses.reading[~turning].mean(axis=0) - np.outer(turning, [1e-2, -6e-3, 8e-3])
    other = replace(poses, reading=poses.reading - zero)
    require_no_mistake(other, MODEL, fit(other, MODEL))


def test_a_run_by_another_sensor_is_told_by_its_gains() -> None:
    poses = session("gyroscope")
    other = turned(poses, np.diag([1.3, 1.0, 0.9]), run(poses, "run 1"))
    with pytest.raises(Contradiction, match=r"run 'run 1' agree with each other.*gains differ"):
        require_one_sensor(other, MODEL, fit(other, MODEL))


def test_gains_that_warmth_changes_are_no_other_sensor() -> None:
    poses = session("gyroscope")
    warm = turned(poses, 1.005 * np.eye(3), run(poses, "run 1"))
    fitted = fit(warm, MODEL)
    assert fitted.p_value < 1e-10
    require_one_sensor(warm, MODEL, fitted)
