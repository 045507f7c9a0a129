"""The simulated sensor against first principles: converter, noise, implied parameters."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.world.designs import paper_design, rich_design
from tests.world.imu import (
    MTI_SPREAD,
    Sensor,
    Triad,
    another_unit,
    gauss_markov,
    low_pass,
    mpu6050,
    mti,
)
from tests.world.physics import live_through
from tests.world.session import simulate
from tests.world.truth import (
    g_sensitivity_seen,
    gyroscope_to_accelerometer,
    gyroscope_to_accelerometer_rad,
    parameters,
)


@pytest.mark.parametrize("sensor", [mti(), mpu6050()], ids=lambda sensor: sensor.name)
def test_the_implied_parameters_invert_the_sensor_up_to_a_rotation(sensor: Sensor) -> None:
    vectors = np.random.default_rng(5).standard_normal((50, 3))
    for triad in (sensor.accelerometer, sensor.gyroscope):
        found = parameters(triad)
        counts = vectors @ (triad.gain[:, None] * triad.axes).T + triad.offset
        x, y, z = ((counts - found.bias_counts) / found.scale_counts_per_unit).T
        ax, ay, az = found.misalignment_rad
        corrected = np.stack([x + az * y + ay * z, y + ax * z, z], axis=1)
        assert corrected == pytest.approx(vectors @ found.case_to_orthogonal.T, abs=1e-12)
        assert np.linalg.det(found.case_to_orthogonal) == pytest.approx(1)
        error = np.array([0.1, -0.2, 0.3])
        moved = found.reading_to_orthogonal @ error
        shift = error * triad.gain / found.scale_counts_per_unit
        assert moved == pytest.approx(
            [shift[0] + az * shift[1] + ay * shift[2], shift[1] + ax * shift[2], shift[2]]
        )


def test_the_mti_has_the_published_gains_offsets_and_misalignment() -> None:
    found = parameters(mti().accelerometer)
    assert found.misalignment_rad == pytest.approx([-0.0135, -0.0036, 0.0005], abs=1e-5)
    assert found.scale_counts_per_unit == pytest.approx([549.7, 552.7, 550.4], rel=1e-4)
    assert found.bias_counts == pytest.approx([33652, 33395, 32034])
    found = parameters(mti().gyroscope)
    assert found.misalignment_rad == pytest.approx([-0.0089, -0.0026, 0.0130], abs=2e-4)
    assert found.scale_counts_per_unit == pytest.approx([9651, 9402, 9417], rel=2e-4)


def test_both_orthogonal_frames_differ_by_the_stated_rotation() -> None:
    sensor, vector = mpu6050(), np.array([0.3, -1.1, 0.7])
    as_gyroscope = parameters(sensor.gyroscope).case_to_orthogonal @ vector
    as_accelerometer = parameters(sensor.accelerometer).case_to_orthogonal @ vector
    assert gyroscope_to_accelerometer(sensor) @ as_gyroscope == pytest.approx(as_accelerometer)
    turned = Rotation.from_rotvec(gyroscope_to_accelerometer_rad(sensor)).apply(as_gyroscope)
    assert turned == pytest.approx(as_accelerometer)


def test_g_sensitivity_between_the_orthogonal_frames_gives_the_same_reading_error() -> None:
    sensor, force = mpu6050(), np.array([4.0, -5.0, 7.0])
    size = np.arange(1.0, 10.0).reshape(3, 3) * 1e-4
    gyr, acc = parameters(sensor.gyroscope), parameters(sensor.accelerometer)
    seen = g_sensitivity_seen(sensor, size) @ (acc.case_to_orthogonal @ force)
    assert seen == pytest.approx(gyr.reading_to_orthogonal @ (size @ force))


def test_counts_are_whole_and_stop_at_the_rails() -> None:
    design = rich_design(mti())  # 200 °/s is beyond this unit
    session = simulate(design.scaled(seconds=0.2), 6)
    fast = next(log for log in session.runs if log.run.name == "33rpm")
    assert fast.gyroscope.dtype == np.int64
    assert fast.gyroscope.max() == 2**16 - 1
    assert fast.accelerometer.min() > 0
    assert mpu6050().gyroscope.rails == (-32768, 32767)
    slow = next(log for log in session.runs if log.run.name == "17rpm")
    assert slow.gyroscope.max() < 2**16 - 1


def test_without_noise_a_count_is_the_rounded_physics() -> None:
    design = paper_design(mti().with_noise(0.0))
    log = simulate(design, 7).runs[0]
    physics = next(live_through(design, 7))
    triad = design.sensor.accelerometer
    exact = physics.true["accelerometer"] * triad.gain + triad.offset
    assert np.abs(log.accelerometer - exact).max() <= 0.5


def test_slow_noise_has_its_sd_and_its_time_constant_also_across_pauses() -> None:
    rng = np.random.default_rng(8)
    time = np.arange(4000)[:, None] * 1.5 + np.arange(50) * 0.02  # pause of 0.52 s
    x = gauss_markov(time, sd=3.0, tau_s=0.5, rng=rng)
    assert x.std() == pytest.approx(3.0, rel=0.02)
    for lag in (1, 10, 25):
        within = (x[:, lag:] * x[:, :-lag]).mean() / 9
        assert within == pytest.approx(np.exp(-lag * 0.02 / 0.5), abs=0.03)
    across = (x[1:, 0] * x[:-1, -1]).mean() / 9
    assert across == pytest.approx(np.exp(-0.52 / 0.5), abs=0.03)


def test_the_low_pass_keeps_the_mean_and_damps_a_sine_by_its_corner() -> None:
    time = np.arange(20_000) / 1000.0
    sine = np.sin(2 * np.pi * 10 * time)[None, :, None]
    passed = low_pass(sine + 5.0, corner=10 / 1000.0)
    assert passed.mean() == pytest.approx(5.0, abs=1e-3)
    assert passed[0, 1000:].std() == pytest.approx(0.5, rel=0.05)  # sine's 0.707, down by 3 dB


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_pose_means_scatter_as_stated_and_far_more_than_white_noise(triad: str) -> None:
    sensor = mti()
    part: Triad = getattr(sensor, triad)
    time = np.arange(400)[:, None] * 30.0 + np.arange(800) / 100
    counts = part.convert(np.zeros((400, 800, 3)), time, np.random.default_rng(9))
    scatter = (counts.mean(axis=1) / part.gain).std(axis=0)
    assert scatter == pytest.approx(part.pose_mean_sd(800, 0.01), rel=0.12)
    white = part.white_sd / part.gain / np.sqrt(800)
    ratio = {"accelerometer": 3.1, "gyroscope": 1.2}[triad]
    assert np.mean(scatter / white) == pytest.approx(ratio, rel=0.1)


def test_another_unit_differs_by_the_spread_of_production() -> None:
    rng = np.random.default_rng(10)
    units = [another_unit(mti(), MTI_SPREAD, rng) for _ in range(400)]
    gains = np.array([unit.gyroscope.gain for unit in units]) / mti().gyroscope.gain
    assert gains.std() == pytest.approx(MTI_SPREAD.gain, rel=0.1)
    alphas = np.array([parameters(unit.accelerometer).misalignment_rad for unit in units])
    assert alphas.std(axis=0) == pytest.approx(MTI_SPREAD.tilt_rad, rel=0.12)
