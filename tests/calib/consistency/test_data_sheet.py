"""Warnings where the data sheet or the clips are contradicted, on arrays."""

from dataclasses import replace

import numpy as np

from calib.consistency.data_sheet import (
    direction_against_clip,
    gain_off_the_sheet,
    range_by_gain,
    turning_while_still,
)
from calib.fit.parameters import TriadParameters
from calib.poses.data_sheet import TriadSpec
from tests.calib.made_poses import FAST, SLOW, made_poses

SPEC = TriadSpec(4.0, 16, "twos-complement")


def gains(*ratio: float, sd: float = 1.0) -> TriadParameters:
    return TriadParameters(np.zeros(3), np.zeros(3), np.array(ratio) / SPEC.nominal_scale,
                           np.full((9, 9), sd**2))


def test_a_gain_far_from_the_data_sheet_is_said_with_both_reasons() -> None:
    (said,) = gain_off_the_sheet(gains(1.02, 2.01, 1.99), SPEC, "gyroscope")
    assert "gain on y is 2.01 times the data sheet's" in said
    assert "or the rate of the plate is wrong by that factor" in said


def test_gains_within_a_third_and_gains_that_were_not_fitted_are_not_said() -> None:
    assert not [*gain_off_the_sheet(gains(1.28, 0.75, 1.0), SPEC, "gyroscope")]
    assert not [*gain_off_the_sheet(gains(3.0, 3.0, 3.0, sd=np.inf), SPEC, "gyroscope")]
    for gain in (6, 7, 8):
        of_one = gains(3.0, 3.0, 3.0)
        of_one.cov[gain, gain] = np.inf
        assert not [*gain_off_the_sheet(of_one, SPEC, "gyroscope")]
    of_bias = gains(3.0, 3.0, 3.0)
    of_bias.cov[5, 5] = np.inf
    assert [*gain_off_the_sheet(of_bias, SPEC, "gyroscope")]


def test_poses_of_the_accelerometer_on_the_turning_plate_are_counted() -> None:
    poses = made_poses("accelerometer", (0.0, SLOW))
    (said,) = turning_while_still(poses)
    assert f"{len(poses) // 2} of the {len(poses)} poses" in said
    assert f"a centripetal {SLOW**2 * 0.01:.2g} m/s²" in said
    assert not [*turning_while_still(made_poses("accelerometer", (0.0,)))]
    assert not [*turning_while_still(made_poses("gyroscope", (SLOW,)))]


def test_a_run_that_turns_against_its_clip_is_named_and_one_odd_pose_is_not() -> None:
    poses = made_poses("gyroscope", (SLOW, -FAST))
    filmed = ["ccw" if run == "run 0" else "cw" for run in poses.run]
    assert not [*direction_against_clip(poses, filmed)]
    spin = poses.spin_rad_s.copy()
    spin[0] *= -1
    assert not [*direction_against_clip(replace(poses, spin_rad_s=spin), filmed)]
    (said,) = direction_against_clip(poses, ["ccw"] * len(poses))
    assert "run run 1" in said
    assert "Change the sign of a stated rate" in said


def test_poses_at_rest_and_runs_without_a_clip_say_nothing_of_the_direction() -> None:
    poses = made_poses("gyroscope", (SLOW, -FAST))
    spin = np.where(np.arange(len(poses)) % 3 == 0, poses.spin_rad_s, 0.0)
    resting = replace(poses, spin_rad_s=spin)
    right = ["ccw" if run == "run 0" else "cw" for run in poses.run]
    assert not [*direction_against_clip(resting, right)]
    assert not [*direction_against_clip(poses, [None] * len(poses))]
    assert len([*direction_against_clip(resting, ["cw"] * 18 + ["ccw"] * 18)]) == 2


def test_a_refuted_range_is_replaced_by_that_of_the_gain() -> None:
    """At ±8 instead of ±4 a count is twice as large, and a unit gives half as many."""
    assert range_by_gain(gains(0.49, 0.51, 0.5).scale_counts_per_unit, SPEC) == 8.0
    assert range_by_gain(gains(1.28, 0.75, 1.0).scale_counts_per_unit, SPEC) is None
