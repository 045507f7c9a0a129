"""Pose means and their sds: honest where samples are correlated, refused where a pose is spoilt."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from calib.errors import Undetermined, UnusableLog
from calib.poses.averaging.average_pose import average_pose
from calib.poses.averaging.drift_within import average_poses
from calib.poses.averaging.mean_noise import pose_mean_sd
from calib.poses.checks import pose_checks
from calib.poses.checks.pose_checks import WANDERS, SensorMoved, is_still, stray_of
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, ImuLog
from calib.poses.samples.batches import batch_variance
from tests.calib.poses.pose_mean_coverage import coverage

RATE_HZ = 100.0
ACC = TriadSpec(20.0, 16, "twos-complement")
GYR = TriadSpec(4.0, 16, "twos-complement")
SPECS = {"accelerometer": ACC, "gyroscope": GYR}
OMEGA = 100 / 180 * np.pi


def log(
    rng: np.random.Generator,
    seconds: float = 8.0,
    acc: FloatArray | None = None,
    gyr: FloatArray | None = None,
    slow_sd: float = 0.0,
    slow_tau_s: float = 0.5,
) -> ImuLog:
    """A pose in counts; ``acc`` and ``gyr`` are added to the noise, in SI units."""
    n = round(seconds * RATE_HZ)
    time_s = np.arange(n) / RATE_HZ
    noise = rng.standard_normal((2, n, 3))
    if slow_sd:
        keep = np.exp(-1 / RATE_HZ / slow_tau_s)
        kick = np.sqrt(1 - keep**2) * rng.standard_normal((2, n + 500, 3))
        noise = noise + slow_sd * lfilter([1.0], [1.0, -keep], kick, axis=1)[:, 500:]
    acc = np.zeros(3) if acc is None else acc
    gyr = np.zeros(3) if gyr is None else gyr
    return ImuLog(
        "pose",
        time_s,
        (0.02 * noise[0] + acc) / ACC.nominal_scale,
        (0.004 * noise[1] + gyr) / GYR.nominal_scale,
        {"temperature_c": 30 + 0.01 * time_s},
    )


def test_batch_means_hold_where_white_noise_over_root_n_does_not() -> None:
    """18 poses of correlated noise, 30 times: the stated variance is that of the means."""
    stated, white, means = [], [], []
    for seed in range(30):
        rng = np.random.default_rng([seed, 1])
        poses = [average_pose(log(rng, slow_sd=0.4), SPECS) for _ in range(18)]
        stated.append(pose_mean_sd([poses], "accelerometer") ** 2)
        white.append([p.accelerometer.scatter / 800 for p in poses])
        means.append([p.accelerometer.mean for p in poses])
    true = np.mean(np.square(means))
    assert np.mean(stated) == pytest.approx(true, rel=0.2)
    assert np.mean(white) < true / 8


def test_batch_means_of_white_noise_state_what_white_noise_gives() -> None:
    rng = np.random.default_rng(3)
    found = np.mean([batch_variance(rng.standard_normal((600, 3)), 6) for _ in range(400)])
    assert found == pytest.approx(1 / 600, rel=0.05)


def test_a_turning_pose_is_averaged_over_whole_turns() -> None:
    """Gravity on a tilted plate comes and goes once per turn and averages to nothing."""
    rng = np.random.default_rng(4)
    time_s = np.arange(2000) / RATE_HZ
    ripple = 0.5 * np.sin(OMEGA * time_s)[:, None] * [1.0, 0.3, 0.0]
    turning = np.tile([0.0, 0.0, OMEGA], (2000, 1))
    mean = average_pose(log(rng, 20.0, ripple, turning), SPECS, OMEGA)
    assert mean.accelerometer.mean == pytest.approx(0, abs=4 * 0.02 / np.sqrt(1800))
    assert mean.duration_s == pytest.approx(5 * 2 * np.pi / OMEGA, abs=0.02)
    # All samples, without regard to turns, are off by ten times that.
    assert abs(ripple.mean(axis=0)[0]) > 10 * 0.02 / np.sqrt(1800)


def test_a_turning_pose_is_averaged_on_one_side_of_a_pause() -> None:
    """The mean over both sides holds a part of the wave: 0.03 m/s² here, and is refused by none."""
    time_s = np.arange(2000) / RATE_HZ
    ripple = 0.5 * np.sin(OMEGA * time_s)[:, None] * [1.0, 0.3, 0.0]
    turning = np.tile([0.0, 0.0, OMEGA], (2000, 1))
    whole = log(np.random.default_rng(4), 20.0, ripple, turning)
    for first, last in ((500, 590), (800, 1200)):
        with_pause = whole.where((time_s < time_s[first]) | (time_s >= time_s[last]))
        mean = average_pose(with_pause, SPECS, OMEGA)
        assert mean.accelerometer.mean == pytest.approx(0, abs=4 * 0.02 / np.sqrt(700))
        side_s = 20.0 - time_s[last]  # the longer one
        assert side_s - 2 * np.pi / OMEGA < mean.duration_s < side_s + 2e-2


def test_what_comes_back_every_turn_does_not_count_as_noise() -> None:
    time_s = np.arange(2000) / RATE_HZ
    ripple = (0.3 * np.cos(OMEGA * time_s) + 0.2 * np.sin(2 * OMEGA * time_s))[:, None]
    turning = np.tile([0.0, 0.0, OMEGA], (2000, 1))
    sds = []
    for add in (0.0, 1.0):
        means = [
            average_pose(
                log(np.random.default_rng(k), 20.0, add * ripple, turning), SPECS, OMEGA
            )
            for k in range(12)
        ]
        sds.append(pose_mean_sd([means], "accelerometer").mean())
    assert sds[1] == pytest.approx(sds[0], rel=0.05)


@pytest.mark.parametrize(("off", "largest"), [
    (0.005, 1.02), (-0.03, 1.02), (0.09, 1.02), (0.2, None)])
def test_gravity_that_goes_round_tells_the_rate_that_is_stated_wrongly(
    off: float, largest: float | None
) -> None:
    """At a rate 0.5 % off its wave was left in the readings and looked like noise."""
    time_s = np.arange(2000) / RATE_HZ
    wave = 1.4 * np.stack([np.cos(OMEGA * time_s), np.sin(OMEGA * time_s), 0 * time_s], axis=1)
    leaning = log(np.random.default_rng(5), 20.0, wave, np.tile([0.0, 0.0, OMEGA], (2000, 1)))
    right = average_pose(leaning, SPECS, OMEGA).accelerometer
    if largest is None:  # another speed of the plate is no error of the rate
        with pytest.raises(Undetermined, match="was moved on the turning plate"):
            average_pose(leaning, SPECS, OMEGA * (1 + off))
        return
    told = average_pose(leaning, SPECS, OMEGA * (1 + off)).accelerometer
    assert (told.scatter < largest * right.scatter).all()


def test_a_plate_that_was_not_yet_at_its_speed_is_told_from_a_sensor_that_moved() -> None:
    start = 1 - 0.3 * np.exp(-np.arange(2000) / RATE_HZ / 1.2)
    logged = log(np.random.default_rng(6), 20.0, gyr=start[:, None] * [0.6 * OMEGA, 0, 0.8 * OMEGA])
    with pytest.raises(Undetermined, match="the plate did not turn steadily"):
        average_pose(logged, SPECS, OMEGA)


@pytest.mark.parametrize("turns", [1, 2, 3, 8])
def test_the_waves_that_few_turns_take_out_do_not_make_a_mean_look_certain(turns: int) -> None:
    """White noise on the turning plate: over one turn its batches showed a third of it."""
    variance, samples = [], round(turns * 2 * np.pi / OMEGA * RATE_HZ)
    for seed in range(60):
        turning = log(np.random.default_rng([seed, 6]), samples / RATE_HZ,
                      gyr=np.array([OMEGA, 0, 0]))
        variance.append(average_pose(turning, SPECS, OMEGA).gyroscope.variance)
    assert np.mean(variance) == pytest.approx(0.004**2 / samples, rel=0.15)


def test_logged_columns_are_averaged_over_the_same_samples() -> None:
    mean = average_pose(log(np.random.default_rng(0)), SPECS)
    assert mean.columns["temperature_c"] == pytest.approx(30 + 0.01 * 3.995)
    assert mean.time_s == pytest.approx(3.995)


def test_a_quiet_minority_of_disturbed_poses_does_not_spoil_the_others() -> None:
    def means(disturbed: int) -> list[object]:
        rng = np.random.default_rng(8)
        poses = []
        for k in range(18):
            shake = 0.2 * rng.standard_normal((800, 3)) if k < disturbed else np.zeros((800, 3))
            poses.append(average_pose(log(rng, acc=shake), SPECS))
        return poses  # type: ignore[return-value]

    calm = pose_mean_sd([means(0)], "accelerometer")  # type: ignore[list-item]
    some = pose_mean_sd([means(2)], "accelerometer")  # type: ignore[list-item]
    assert some[2:].mean() == pytest.approx(calm[2:].mean(), rel=0.25)
    assert some[:2].mean() > 3 * calm[:2].mean()


# --- refusals ----------------------------------------------------------------------------------


def test_a_pose_that_slipped_is_refused() -> None:
    acc = np.where(np.arange(800)[:, None] < 300, 0.0, 0.06) * [1.0, 0, 0]
    with pytest.raises(Undetermined, match=r"the sensor moved: accelerometer x strays by 0\.0"):
        average_pose(log(np.random.default_rng(1), acc=acc), SPECS)


def test_a_plate_that_runs_up_is_refused() -> None:
    gyr = OMEGA * (1 + 0.02 * np.linspace(-1, 1, 2000)[:, None]) * [0, 0, 1.0]
    with pytest.raises(Undetermined, match="the plate sped up during the pose"):
        average_pose(log(np.random.default_rng(1), 20.0, gyr=gyr), SPECS, OMEGA)


def test_a_pose_shorter_than_a_turn_is_refused() -> None:
    gyr = np.tile([0, 0, OMEGA], (200, 1))
    with pytest.raises(Undetermined, match="less than one turn"):
        average_pose(log(np.random.default_rng(1), 2.0, gyr=gyr), SPECS, OMEGA)


def test_a_saturated_axis_is_refused() -> None:
    full = log(np.random.default_rng(1))
    acc = full.accelerometer.copy()
    acc[:40, 1] = 32767
    spoilt = ImuLog("pose_07.csv", full.time_s, acc, full.gyroscope)
    with pytest.raises(Undetermined, match=r"pose_07.csv: accelerometer y is saturated: 5.0 %"):
        average_pose(spoilt, SPECS)


def test_counts_that_the_encoding_cannot_give_are_refused() -> None:
    wrong = TriadSpec(20.0, 16, "offset-binary")
    with pytest.raises(UnusableLog, match="Is the encoding twos-complement"):
        average_pose(log(np.random.default_rng(1), acc=np.array([0, 0, -9.8])),
                     {**SPECS, "accelerometer": wrong})


def test_a_handful_of_samples_is_no_pose() -> None:
    with pytest.raises(Undetermined, match="10 samples, at least 12"):
        average_pose(log(np.random.default_rng(1), 0.1), SPECS)


def test_noise_alone_is_hardly_ever_called_motion() -> None:
    """Three axes and 400 poses of a sensor as slow as an MPU-6050: none is refused."""
    rng = np.random.default_rng(11)
    for _ in range(400):
        average_pose(log(rng, slow_sd=0.3), SPECS)


@pytest.mark.parametrize(("seconds", "tau_s", "white"), [(8, 0.5, 0), (8, 0.5, 3), (8, 0.01, 3)])
def test_the_stated_sds_cover_what_they_say(seconds: float, tau_s: float, white: float) -> None:
    """25 sessions of 26 poses and 3 axes: a share of 95 % is known to 0.7 %, correlation apart."""
    held = coverage(seconds, tau_s, white, sessions=25)
    assert 0.93 < held.covered < 0.97
    assert held.noted == 0


@pytest.mark.parametrize(("seconds", "tau_s"), [(1.5, 0.5), (3, 2.0)])
def test_poses_too_short_for_their_noise_are_told(seconds: float, tau_s: float) -> None:
    assert coverage(seconds, tau_s, 0, sessions=10).noted > 0.7


def test_sds_hold_where_white_noise_hides_slow_noise_of_a_quarter_of_the_pose() -> None:
    """A ratio of batch variances alone takes it for shorter than it is: their spread is 1.12."""
    assert 0.92 < coverage(8, 2.0, 3, sessions=25).spread < 1.05


@pytest.mark.parametrize("step", [0.5, 2, 20])
def test_the_sds_cover_a_converter_of_any_step(step: float) -> None:
    assert coverage(8, 0.01, 0, step, sessions=15).covered > 0.93


def test_no_pose_of_white_noise_strays_by_the_limit_and_some_stray_by_half_of_it() -> None:
    """Samples far noisier than any shift that a pose may have: the noise alone decides."""
    rng = np.random.default_rng(1)
    poses = rng.standard_normal((10_000, 12, 3))
    assert all(is_still(pose, 0.0, 0.0) for pose in poses)
    still = pose_checks.LARGEST_SHIFT_SD / 2
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pose_checks, "LARGEST_SHIFT_SD", still)
        moved = np.mean([not is_still(pose, 0.0, 0.0) for pose in poses])
    assert 0.005 < moved < 0.012


def test_noise_of_any_correlation_strays_by_four_medians_once_in_ten_thousand() -> None:
    rng = np.random.default_rng(1)
    for correlated_over in (0.02, 0.1, 0.5, 3.0, 100.0):  # of the length of a pose
        keep = np.exp(-1 / (correlated_over * 240))
        noise = rng.standard_normal((240, 6000)) * np.sqrt(1 - keep**2)
        noise[0] = rng.standard_normal(6000)
        strays = stray_of(lfilter([1.0], [1.0, -keep], noise, axis=0))
        assert (strays > WANDERS * np.median(strays)).sum() <= 2


@pytest.mark.parametrize("rate", [0.0, OMEGA])
def test_poses_that_all_stray_alike_are_noisy_and_one_that_strays_more_was_moved(
    rate: float,
) -> None:
    rng = np.random.default_rng(7)
    seconds = 20.0 if rate else 8.0
    up = np.array([0.0, 0.0, 9.8])
    logs = [log(rng, seconds, up, rate * up / 9.8, slow_sd=1.8 if rate else 0.8, slow_tau_s=4.0)
            for _ in range(12)]
    alone = 0
    for one in logs:
        try:
            average_pose(one, SPECS, rate)
        except SensorMoved:
            alone += 1
    assert alone > 0  # by itself such a pose looks moved
    assert len(average_poses(logs, SPECS, [rate] * 12)) == 12
    readings = logs[5].accelerometer.copy()
    readings[len(readings) // 2 :, 0] += 0.4 / ACC.nominal_scale  # two degrees, half of the pose
    moved = replace(logs[5], accelerometer=readings)
    with pytest.raises(SensorMoved):
        average_poses([*logs[:5], moved, *logs[6:]], SPECS, [rate] * 12)
