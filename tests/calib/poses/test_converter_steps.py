"""A converter's steps are in the sds of pose means: a coarse log is not refused, nor believed."""

from dataclasses import replace

import numpy as np
import pytest

from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import calibrate_triad
from calib.poses.averaging.average_pose import average_pose
from calib.poses.averaging.mean_noise import pose_mean_sd
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, ImuLog
from calib.poses.samples.converter_steps import (
    least_steps,
    step_variance,
    step_variance_seen,
    value_steps,
)
from tests.fitting import pose_sets
from tests.world.designs import paper_design
from tests.world.imu import Triad, mpu6050
from tests.world.session import simulate

SI = TriadSpec(np.inf, 0, "si")


@pytest.mark.parametrize("noise", [0.0, 0.05, 0.1, 0.2, 0.3, 0.5])
def test_the_variance_is_that_of_rounded_means(noise: float) -> None:
    """Directly: many truths between two steps, each the mean of many rounded samples."""
    rng = np.random.default_rng(1)
    truth = rng.uniform(-0.5, 0.5, 400)
    means = np.array([np.rint(x + noise * rng.standard_normal(4000)).mean() for x in truth])
    by_noise = (noise**2 + 1 / 12) / 4000
    stated = step_variance(np.ones(3), np.full(3, noise**2))[0]
    assert np.mean((means - truth) ** 2) == pytest.approx(stated, rel=0.12, abs=2 * by_noise)


def test_no_step_and_much_noise_add_nothing() -> None:
    assert not step_variance(np.zeros(3), np.ones(3)).any()
    assert step_variance(np.ones(3), np.full(3, 1.0)) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("noise", [0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4])
def test_a_run_shows_the_noise_on_which_its_steps_depend(noise: float) -> None:
    """Read from 18 poses; never much too sure, and in no run by chance far from what is so."""
    rng = np.random.default_rng(6)
    by_noise, ratio = (noise**2 + 1 / 12) / 500, []
    for _ in range(60):
        truth = rng.uniform(-50, 50, (18, 3))
        values = np.rint(truth[:, None] + noise * rng.standard_normal((18, 500, 3)))
        means, scatter = values.mean(axis=1), values.var(axis=1, ddof=1)
        stated = step_variance_seen(np.ones(3), scatter, means - values[:, 0], np.full(3, 500.0))
        ratio.append(((means - truth) ** 2).mean(axis=0) / (stated + by_noise))
    assert 0.35 < np.mean(ratio) < 1.25
    assert np.quantile(ratio, 0.95) < 2


def test_poses_that_moved_do_not_show_noise_that_hides_the_steps() -> None:
    """Eighteen means at one place between two steps, six of which moved over a step and more."""
    rng = np.random.default_rng(8)
    moved = np.linspace(0, 3, 500) * (np.arange(18) % 3 == 0)[:, None]
    values = np.rint(-0.42 + moved[..., None] + 0.09 * rng.standard_normal((18, 500, 3)))
    means, scatter = values.mean(axis=1), values.var(axis=1, ddof=1)
    stated = step_variance_seen(np.ones(3), scatter, means - values[:, 0], np.full(3, 200.0))
    assert (np.sqrt(stated) > 0.2).all()


def test_the_step_is_found_where_the_log_is_coarser_than_the_data_sheet() -> None:
    rng = np.random.default_rng(2)
    analogue = 5 + rng.standard_normal((500, 3))
    lsb = 20 / 2**15
    counts = np.rint(analogue / lsb)
    assert value_steps(counts) == pytest.approx(1)
    assert value_steps(16 * np.rint(analogue / lsb / 16)) == pytest.approx(16)
    assert value_steps(np.round(analogue, 1)) == pytest.approx(0.1)
    assert (value_steps(analogue) < 1e-3).all()


def test_a_log_of_one_value_says_so_and_what_its_step_is_at_least() -> None:
    sheet = TriadSpec(20.0, 16, "twos-complement")
    assert np.isinf(value_steps(np.full((500, 3), 9.8))).all()
    assert least_steps(np.full((500, 3), 9.8), SI) == pytest.approx(0.1)
    assert least_steps(np.full((500, 3), 9.8125), SI) == pytest.approx(1e-4)
    assert least_steps(np.full((500, 3), 120.0), sheet) == pytest.approx(1)


def coarse(triad: Triad, bits: int, noise_counts: float) -> Triad:
    """The same part behind a converter of ``bits`` with so much white noise, in its counts."""
    share = 2.0 ** (bits - triad.bits)
    return replace(
        triad,
        gain=triad.gain * share,
        offset=triad.offset * share,
        bits=bits,
        white_sd=noise_counts,
        slow_sd=0.0,
        bandwidth_hz=np.inf,
    )


@pytest.mark.parametrize("noise_counts", [0.02, 0.1, 0.3])
def test_twelve_bits_are_explained_and_the_scale_s_sd_holds(noise_counts: float) -> None:
    sensor = mpu6050()
    sensor = replace(sensor, accelerometer=coarse(sensor.accelerometer, 12, noise_counts))
    design = paper_design(sensor).scaled(seconds=0.3)
    whitened, scores = [], []
    for seed in range(8):
        session = simulate(design, 100 + seed)
        poses, _, specs = pose_sets(session)
        found = fit(poses, Model.of(BASE))
        whitened.append(found.chi2 / found.dof)
        parameters = calibrate_triad(found, specs[0]).parameters
        truth = session.accelerometer.scale_counts_per_unit
        scores.append((parameters.scale_counts_per_unit - truth) / parameters.sd[2])
    # The error is uniform or an arc of a sine, not normal: chi-square scatters less than it says.
    assert 0.4 < np.median(whitened) < 1.4
    assert np.mean(np.abs(scores) < 1.96) > 0.9
    assert np.std(scores) < 1.25


def test_a_log_rounded_to_a_tenth_is_known_to_what_that_leaves() -> None:
    """Readings in m/s² with one decimal and noise far below: every pose repeats one value."""
    rng = np.random.default_rng(4)
    quiet = 1e-3
    errors, stated = [], []
    for _ in range(40):
        truth = rng.uniform(-9.8, 9.8, 3)
        values = np.round(truth + quiet * rng.standard_normal((200, 3)), 1)
        mean = average_pose(log_of(values), {"accelerometer": SI})
        elsewhere = average_pose(log_of(values + 0.3), {"accelerometer": SI})
        sd = pose_mean_sd([[mean, elsewhere]], "accelerometer")[0]
        errors.append(mean.accelerometer.mean - truth)
        stated.append(sd)
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(0.1 / np.sqrt(12), rel=0.15)
    assert np.median(stated) == pytest.approx(0.1 / np.sqrt(12), rel=0.15)


def test_the_steps_are_common_to_poses_that_read_alike() -> None:
    """The mean of many poses at rest is known no better than that of one."""
    rng = np.random.default_rng(5)
    wrong, stated = [], []
    for _ in range(40):
        truth = rng.uniform(-9.8, 9.8, 3)
        means = [average_pose(log_of(np.round(truth + 1e-3 * rng.standard_normal((200, 3)), 1)),
                              {"accelerometer": SI}) for _ in range(9)]
        sd = pose_mean_sd([means], "accelerometer")
        wrong.append(np.mean([mean.accelerometer.mean for mean in means], axis=0) - truth)
        stated.append(1 / np.sqrt((1 / sd**2).sum(axis=0)))
    assert np.sqrt(np.mean(np.square(wrong))) == pytest.approx(np.median(stated), rel=0.25)


def log_of(values: FloatArray) -> ImuLog:
    n = len(values)
    return ImuLog("pose", np.arange(n) / 50, values, np.full((n, 3), np.nan))
