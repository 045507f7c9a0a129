"""Poses joined into runs: references, signs, the Earth's rate, and runs that cannot be meant."""

from dataclasses import replace

import numpy as np
import pytest

from calib.earth import EARTH_RATE_RAD_S
from calib.errors import Undetermined
from calib.poses.averaging.pose_mean import PoseMean, TriadMean
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import pose_set
from calib.poses.reference import CommonError, PlateRate, constant_reference, join_references
from calib.poses.runs.reference_runs import (
    GRAVITY,
    TIME_BASE,
    gravity_run,
    stopped_run,
    turning_run,
)

LATITUDE = np.radians(40.0)
VERTICAL = EARTH_RATE_RAD_S * np.sin(LATITUDE)
OMEGA = 1.745
G = 9.8
UP = np.array([[0, 0, 1.0], [0, 1.0, 0], [1.0, 0, 0], [0, 0, -1.0], [0, -1.0, 0], [-1.0, 0, 0]])


def triad_mean(mean: FloatArray) -> TriadMean:
    var = np.full(3, 1e-8)
    return TriadMean(np.asarray(mean, float), var, np.full(3, 1e-4))


def means(spin: float, start_s: float = 0.0, acc: bool = True) -> list[PoseMean]:
    """Six poses on a plate turning at ``spin``, as perfect sensors have them."""
    nothing = TriadMean(*(np.full(3, np.nan) for _ in range(3)))
    return [
        PoseMean(
            f"pose {k + 1}",
            triad_mean(G * up) if acc else nothing,
            triad_mean(spin * up),
            start_s + 30.0 * k,
            20.0,
            {"temperature_c": 30.0 + k},
        )
        for k, up in enumerate(UP)
    ]


def rate(name: str = "slow", value: float = OMEGA, direction: str | None = None) -> PlateRate:
    return PlateRate(name, np.array([value]), np.array([1e-4]), 20e-6, direction)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_earths_rate_adds_counter_clockwise_and_takes_away_clockwise(sign: float) -> None:
    run = turning_run(means(sign * OMEGA), rate(), LATITUDE)
    assert run.reference.magnitude == pytest.approx(OMEGA + sign * VERTICAL, abs=1e-12)
    assert run.spin_rad_s == pytest.approx(sign * OMEGA)


def test_on_the_southern_half_the_earth_turns_the_other_way() -> None:
    run = turning_run(means(OMEGA), rate(), -LATITUDE)
    assert run.reference.magnitude == pytest.approx(OMEGA - VERTICAL, abs=1e-12)


def test_without_latitude_the_earths_rate_is_an_error_of_either_sign() -> None:
    ccw, cw = (turning_run(means(s * OMEGA), rate(), None).reference for s in (1, -1))
    assert ccw.magnitude == pytest.approx(OMEGA)
    column = ccw.common_names.index("Earth rate, latitude not given")
    assert ccw.common[:, column] == pytest.approx(-cw.common[:, column])
    assert np.abs(ccw.common[:, column]) == pytest.approx(EARTH_RATE_RAD_S / np.sqrt(3))


def test_without_an_accelerometer_the_film_tells_the_direction() -> None:
    for filmed, sign in (("ccw", 1.0), ("cw", -1.0), (None, 0.0)):
        run = turning_run(means(OMEGA, acc=False), rate(direction=filmed), LATITUDE)
        assert run.spin_rad_s == pytest.approx(sign * OMEGA)


def test_a_shared_rate_is_a_common_error_and_one_clip_per_pose_is_not() -> None:
    shared = turning_run(means(OMEGA), rate(), LATITUDE).reference
    assert shared.sd == pytest.approx(0)
    assert shared.common_names == (TIME_BASE, "rate slow")
    assert shared.common[0] == pytest.approx([20e-6 * OMEGA, 1e-4])
    each = PlateRate("slow", np.full(6, OMEGA), np.full(6, 3e-4), 20e-6)
    own = turning_run(means(OMEGA), each, LATITUDE).reference
    assert own.sd == pytest.approx(3e-4)
    assert own.common_names == (TIME_BASE,)


def test_common_errors_of_one_name_are_one_error() -> None:
    joined = join_references(
        [
            constant_reference(2, 1.7, [CommonError("clock", 1e-4), CommonError("rate a", 2e-4)]),
            constant_reference(3, 3.5, [CommonError("clock", 2e-4), CommonError("rate b", 3e-4)]),
        ]
    )
    assert joined.common_names == ("clock", "rate a", "rate b")
    assert joined.common[:, 0] == pytest.approx([1e-4, 1e-4, 2e-4, 2e-4, 2e-4])
    assert joined.common[:, 1] == pytest.approx([2e-4, 2e-4, 0, 0, 0])
    assert joined.common[:, 2] == pytest.approx([0, 0, 3e-4, 3e-4, 3e-4])


def test_a_stopped_plate_shows_the_vertical_part_of_the_earths_rate() -> None:
    run = stopped_run("rest", means(0.0), LATITUDE)
    assert run.expected == pytest.approx(VERTICAL * UP, abs=1e-15)
    horizontal = EARTH_RATE_RAD_S * np.cos(LATITUDE)
    assert run.reference.sd == pytest.approx(horizontal / np.sqrt(2))
    assert run.reference.is_null.all()
    blind = stopped_run("rest", means(0.0), None)
    assert blind.expected == pytest.approx(0)
    assert blind.reference.sd == pytest.approx(EARTH_RATE_RAD_S / np.sqrt(3))


def test_gravity_is_common_to_all_poses() -> None:
    run = gravity_run("still", means(0.0), 9.81, 1e-4)
    assert run.reference.common_names == (GRAVITY,)
    assert run.reference.common[:, 0] == pytest.approx(1e-4)
    assert run.spin_rad_s == pytest.approx(0)


def test_a_pose_remembers_the_one_recorded_before_it_in_time() -> None:
    later, earlier = means(OMEGA, 1000.0), means(-OMEGA, 0.0)
    runs = [turning_run(later, rate("b"), 0.0), turning_run(earlier, rate("a"), 0.0)]
    poses = pose_set("gyroscope", runs, 0.0)
    assert poses.before.tolist() == [11, 0, 1, 2, 3, 4, -1, 6, 7, 8, 9, 10]
    at = poses.conditions(poses.reading)
    assert at.previous[0] == pytest.approx(-OMEGA * UP[5])
    assert at.previous[6] == pytest.approx(0)


def test_rest_leaves_no_memory() -> None:
    still = stopped_run("rest", means(0.0, 0.0), LATITUDE)
    runs = [still, turning_run(means(OMEGA, 1000.0), rate(), LATITUDE)]
    previous = pose_set("gyroscope", runs, 0.0).conditions(np.ones((12, 3))).previous
    assert previous[:7] == pytest.approx(0)
    assert previous[7:] == pytest.approx(1)


def test_clocks_that_start_anew_in_every_file_leave_the_order_unknown() -> None:
    runs = [turning_run(means(OMEGA, 0.0), rate(), 0.0),
            turning_run(means(-OMEGA, 0.0), rate("b"), 0.0)]
    poses = pose_set("gyroscope", runs, 0.0)
    assert np.isnan(poses.time_s).all()
    assert np.isnan(poses.conditions(poses.reading).previous).all()


def test_only_columns_that_every_pose_has_are_kept() -> None:
    some = means(OMEGA)
    some[2] = replace(some[2], columns={})
    assert pose_set("gyroscope", [turning_run(some, rate(), 0.0)], 0.0).columns == {}
    kept = pose_set("gyroscope", [turning_run(means(OMEGA), rate(), 0.0)], 0.0).columns
    assert kept["temperature_c"] == pytest.approx(30 + np.arange(6))


# --- refusals ----------------------------------------------------------------------------------


def test_a_run_called_turning_that_does_not_turn_is_refused() -> None:
    with pytest.raises(Undetermined, match=r"slow: in pose 1 .*plate was not turning"):
        turning_run(means(0.01), rate(), LATITUDE)


def test_a_run_called_stopped_that_turns_is_refused_with_its_rate() -> None:
    with pytest.raises(Undetermined, match=r"do not read as at rest.*name its rate instead"):
        stopped_run("rest", means(OMEGA), LATITUDE)


def test_an_accelerometer_with_the_wrong_full_scale_is_refused() -> None:
    with pytest.raises(Undetermined, match=r"reads 9.8 m/s² in a typical pose, where 32"):
        gravity_run("still", means(0.0), 32.0, 0.0)


def test_clips_and_poses_must_pair() -> None:
    with pytest.raises(Undetermined, match="4 clips for 6 poses"):
        turning_run(means(OMEGA), PlateRate("s", np.full(4, OMEGA), np.full(4, 1e-4)), LATITUDE)


def test_a_pose_without_gyro_columns_is_refused_by_its_name() -> None:
    some = means(OMEGA)
    some[3] = replace(some[3], gyroscope=TriadMean(*(np.full(3, np.nan) for _ in range(3))))
    with pytest.raises(Undetermined, match=r"slow: pose 4 has no gyroscope columns"):
        turning_run(some, rate(), LATITUDE)


def test_an_axis_that_never_changes_is_called_stuck() -> None:
    stuck = [
        replace(m, gyroscope=TriadMean(np.array([1.5, *m.gyroscope.mean[1:]]),
                                       m.gyroscope.variance,
                                       np.array([0.0, 1e-4, 1e-4])))
        for m in means(OMEGA)
    ]
    with pytest.raises(Undetermined, match="slow: gyroscope x is stuck"):
        pose_set("gyroscope", [turning_run(stuck, rate(), 0.0)], 0.0)


def test_an_axis_with_less_noise_than_a_count_at_rest_and_that_turns_is_not_stuck() -> None:
    quiet = [replace(m, gyroscope=TriadMean(np.zeros(3), m.gyroscope.variance, np.zeros(3)))
             for m in means(0.0)]
    runs = [stopped_run("still", quiet, 0.0), turning_run(means(OMEGA), rate(), 0.0)]
    assert len(pose_set("gyroscope", runs, 0.0).reading) == 2 * len(quiet)
