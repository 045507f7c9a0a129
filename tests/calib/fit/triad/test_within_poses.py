"""Readings that change alike within every pose: told, and the sds of the parameters contain it."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from calib.assess import assess
from calib.diagnosis.verdict.decision import Code
from calib.effects.catalogue import BASE, find_effect
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import TriadCalibration, calibrate_triad
from calib.fit.triad.within_poses import at_one_length, courses_within
from tests.fitting import pose_sets
from tests.world.designs import paper_design, rich_design
from tests.world.imu import FloatArray
from tests.world.session import RunLog, Session, simulate

DESIGN = paper_design().scaled(sample_rate=0.5)
ACCELEROMETER, GYROSCOPE = 0.1, np.radians(0.3)  #: m/s² and rad/s by which a warm-up settles

Course = Callable[[FloatArray, RunLog, str], FloatArray]
"""What a triad's counts have more, (p, t, 3), at times (p, t) since each pose began."""


def with_course(session: Session, course: Course) -> Session:
    """The session whose readings have a course within each pose."""
    runs = []
    for log in session.runs:
        since = log.time_s - log.time_s[:, :1]
        runs.append(replace(log, **{
            triad: np.rint(getattr(log, triad) + course(since, log, triad)).astype(np.int64)
            for triad in ("accelerometer", "gyroscope")}))
    return replace(session, runs=tuple(runs))


@cache
def evening(seed: int) -> Session:
    return simulate(DESIGN, seed)


def settling(seed: int, tau_s: float, session: Session | None = None) -> Session:
    """A sensor that is switched on for each pose."""
    rng, session = np.random.default_rng([seed, 5]), session or evening(seed)
    sensor = session.design.sensor
    counts = {triad: size * rng.standard_normal(3) * getattr(sensor, triad).gain
              for triad, size in (("accelerometer", ACCELEROMETER), ("gyroscope", GYROSCOPE))}
    return with_course(session, lambda since, _, triad: (
        np.exp(-since / tau_s)[..., None] * counts[triad]))


def slowing(seed: int, share: float) -> Session:
    """A plate that slows by ``share`` of its rate within each pose."""

    def course(since: FloatArray, log: RunLog, triad: str) -> FloatArray:
        if log.run.motion is None or triad == "accelerometer":
            return np.zeros((*since.shape, 3))
        rate = (log.gyroscope - DESIGN.sensor.gyroscope.offset).mean(axis=1, keepdims=True)
        return np.asarray(-share * rate * (since / since.max())[..., None])

    return with_course(evening(seed), course)


def calibrated(session: Session) -> tuple[TriadCalibration, TriadCalibration]:
    accelerometer, gyroscope, specs = pose_sets(session)
    found = [calibrate_triad(fit(poses, Model.of(BASE)), spec)
             for poses, spec in zip((accelerometer, gyroscope), specs, strict=True)]
    return found[0], found[1]


@pytest.mark.parametrize("tau_s", [2.0, 20.0])
def test_the_bias_of_a_sensor_that_settles_in_each_pose_is_within_its_sds(tau_s: float) -> None:
    off = []
    for seed in range(8):
        session = settling(seed, tau_s)
        for found, true in zip(calibrated(session), (session.accelerometer, session.gyroscope),
                               strict=True):
            off.append((found.parameters.bias_counts - true.bias_counts) / found.parameters.sd[1])
    assert 0.3 < np.sqrt(np.mean(np.square(off))) < 1.5  # 30 and more without it
    assert np.abs(off).max() < 4


@pytest.mark.parametrize("share", [0.002, 0.004])
def test_the_scales_of_a_plate_that_slows_in_each_pose_are_within_their_sds(share: float) -> None:
    off = []
    for seed in range(8):
        session = slowing(seed, share)
        found = calibrated(session)[1]
        scale, true = found.parameters.scale_counts_per_unit, session.gyroscope
        off.append((scale - true.scale_counts_per_unit) / found.parameters.sd[2])
    assert np.abs(off).max() < 2.5  # 7 and more without it


def test_sound_poses_and_a_steady_drift_of_the_session_have_no_course() -> None:
    assert not [course for seed in range(12) for found in calibrated(evening(seed))
                for course in courses_within(found.fit)]


def test_a_model_that_follows_the_clock_or_a_column_has_its_own_course() -> None:
    poses = pose_sets(settling(1, 5.0))[0]
    for name in ("temperature_bias", "bias_drift"):
        assert list(courses_within(fit(poses, Model.of(BASE))))
        assert not list(courses_within(fit(poses, Model.of(BASE) + find_effect(name))))


def test_one_pose_that_moves_makes_no_course() -> None:
    session = evening(2)
    (still, *others) = session.runs
    counts = still.accelerometer.copy()
    counts[4] += np.linspace(0, 9, counts.shape[1]).astype(np.int64)[:, None]
    moved = replace(session, runs=(replace(still, accelerometer=counts), *others))
    poses, _, _ = pose_sets(moved)
    calm, _, _ = pose_sets(session)
    assert not list(courses_within(fit(poses, Model.of(BASE))))
    others_of = np.arange(len(poses)) != 4
    assert poses.sd[others_of] == pytest.approx(calm.sd[others_of], rel=0.25)
    assert (poses.sd[4] > 1.2 * calm.sd[4]).all()


def test_the_verdict_says_that_the_readings_had_not_settled() -> None:
    poses, _, specs = pose_sets(settling(1, 5.0))
    found = assess(poses, Model.of(BASE), specs[0]).diagnosis.explanation
    assert found.standing == "open"
    assert "the sensor settles after each start" in found.text
    assert found.following.startswith("Leave sensor and logger running")


def test_poses_of_two_lengths_settle_differently_and_nothing_else_is_named() -> None:
    """At rest it has settled less than on the plate, whose poses are longer."""
    session = simulate(rich_design().scaled(sample_rate=0.5), 3)
    _, poses, specs = pose_sets(settling(3, 5.0, session))
    misfit = fit(poses, Model.of(BASE)).chi2
    found = assess(poses, Model.of(BASE), specs[1])
    assert found.calibration.fit.chi2 < misfit / 5
    assert found.diagnosis.verdict == Code.NOTHING_MISSING
    assert found.diagnosis.explanation.following.startswith("Leave sensor and logger running")
    length = poses.duration_s
    assert length is not None
    tabled = replace(poses, duration_s=np.where(np.arange(len(poses)) < 5, 0.0, length))
    assert (at_one_length(tabled, Model.of(BASE)).reading[:5] == poses.reading[:5]).all()
    sound = pose_sets(session)[1]
    as_it_was = at_one_length(sound, Model.of(BASE)).reading
    assert as_it_was == pytest.approx(sound.reading, abs=0.02 * float(sound.sd.min()))


def test_noise_of_the_poses_is_told_apart_from_their_course() -> None:
    """The sds of the pose means are those of a sensor that does not settle."""
    sound, settles = (pose_sets(session)[0].sd for session in (evening(1), settling(1, 5.0)))
    assert settles == pytest.approx(sound, rel=0.15)  # twice to five times it without
