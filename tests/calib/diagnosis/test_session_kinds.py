"""What is asked for next fits the session: nobody lays corners in a thermal chamber."""

from dataclasses import replace

import numpy as np

from calib.diagnosis.diagnose import diagnose
from calib.diagnosis.next_measurement.advice import block_called, settling_block
from calib.diagnosis.next_measurement.chance import Rival, chance_of_a_name
from calib.diagnosis.next_measurement.kind import at_one_speed, in_a_chamber
from calib.diagnosis.next_measurement.pose_blocks import menu
from calib.effects.catalogue import BASE, find_effect
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from calib.poses.reference import constant_reference
from tests.calib.made_poses import GRAVITY, SLOW, made_poses, noisy, rich_poses

BASE_MODEL = Model.of(BASE)
SD = 1e-4


def chamber(course: FloatArray, drift: float = 0.0) -> PoseSet:
    """A gyroscope at rest in one attitude while the temperature takes ``course`` (n,), °C."""
    n, rng = len(course), np.random.default_rng(7)
    time_s = 60.0 * np.arange(n)
    reading = 1e-4 * (course - 25.0)[:, None] + drift * time_s[:, None] + np.zeros((n, 3))
    like = noisy(made_poses("gyroscope", (0.0,)), 1)
    force = np.tile([0.1, 0.2, GRAVITY], (n, 1))
    return PoseSet(
        triad="gyroscope", label=tuple(f"rest {i}" for i in range(n)), run=("stopped",) * n,
        reading=reading + SD * rng.standard_normal((n, 3)), sd=np.full((n, 3), SD), force=force,
        vibration=np.tile(like.vibration[0], (n, 1)), spin_rad_s=np.zeros(n), time_s=time_s,
        expected=np.zeros((n, 3)), reference=constant_reference(n, 0.0, []),
        columns={"temperature_c": course},
    )


RISING = np.linspace(10.0, 50.0, 30)


def test_a_sweep_that_only_rises_is_asked_to_fall_and_not_for_corners() -> None:
    poses = chamber(RISING)
    assert in_a_chamber(poses)
    said = diagnose(fit(poses, Model.of(("bias",))))
    assert {"temperature_bias", "bias_drift"} <= {*said.group}
    assert said.record_next is not None
    assert "falling as well as rising" in said.record_next
    assert "corner" not in said.text
    assert "random order" not in said.explanation.following


def test_what_is_asked_for_tells_temperature_from_time() -> None:
    there_and_back = np.concatenate([RISING, RISING[::-1]])
    said = diagnose(fit(chamber(there_and_back), Model.of(("bias",))))
    assert said.names == ("temperature_bias",)
    assert said.group == ("temperature_bias",)


def test_poses_in_many_attitudes_or_at_one_temperature_are_no_chamber() -> None:
    poses = rich_poses("gyroscope")
    assert not in_a_chamber(poses)
    still = chamber(RISING)
    assert not in_a_chamber(replace(still, columns={"temperature_c": 25.0 + 0.01 * RISING}))
    assert not in_a_chamber(replace(still, columns={}))
    fitted = fit(noisy(rich_poses("accelerometer"), 2), Model.of(("bias", "scale", "misalignment")))
    assert "repeat" in {block.code for block in menu(fitted)}


def test_a_session_at_one_speed_is_asked_for_another_and_not_for_more_of_the_same() -> None:
    poses = noisy(made_poses("gyroscope", (SLOW,)), 2)
    assert at_one_speed(poses)
    codes = {block.code for block in menu(fit(poses, BASE_MODEL))}
    assert {"speed", "stopped"} <= codes
    assert not {"corners", "repeat"} & codes
    assert not at_one_speed(rich_poses("gyroscope"))


def test_a_plate_that_may_drift_is_asked_for_a_clip_with_each_pose() -> None:
    """A drift of the plate and of all gains differ where each pose has a rate of its own."""
    poses = noisy(rich_poses("gyroscope"), 2)
    shared = replace(poses, reference=replace(
        poses.reference, common=1e-5 * poses.reference.magnitude[:, None],
        common_names=("rate slow",), of_setting=frozenset({"rate slow"})))
    fitted = fit(shared, BASE_MODEL)
    drift = np.full(3, 0.05)
    rivals = [Rival(find_effect("reference_drift"), drift[:1]),
              Rival(find_effect("scale_drift"), drift)]
    advice = settling_block(fitted, lambda then: chance_of_a_name(then, rivals))
    assert advice is not None
    assert advice.block == "clips"
    assert "clip" in advice.instruction
    film = block_called(fitted, "clips")
    assert film is not None
    assert film.block == "clips"
    # Poses with rates of their own may still share the Earth's, where no latitude is given.
    own = replace(poses.reference, common=np.full((len(poses), 1), 4e-5),
                  common_names=("Earth rate, latitude not given",), of_setting=frozenset())
    filmed = fit(replace(poses, reference=own), BASE_MODEL)
    assert block_called(filmed, "clips") is None
    assert "clips" not in {block.code for block in menu(filmed)}
