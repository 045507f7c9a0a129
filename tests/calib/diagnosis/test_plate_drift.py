"""A plate that drifts is told however its clips were taken."""

from dataclasses import replace

import numpy as np
import pytest

from calib.diagnosis.diagnose import diagnose
from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.numbers import SECONDS_PER_HOUR
from tests.calib.made_poses import noisy, rich_poses
from tests.trials import hidden_of, poses_of
from tests.world.designs import rich_design
from tests.world.hidden import Hidden

RICH = rich_design().scaled(sample_rate=0.1)


@pytest.mark.parametrize("detail", [{"filmed": 0.1}, {"filmed": 0.9}, {"filmed_s": 1400.0}])
def test_settings_filmed_one_after_another_or_all_at_once(detail: dict[str, float]) -> None:
    for seed, drift in enumerate((-3e-6, 1e-6)):
        hidden = Hidden("reference_drift", "gyroscope", np.array(drift), detail)
        poses = poses_of(RICH, seed, "gyroscope", [hidden])
        found = diagnose(fit(poses, Model.of(BASE)))
        assert (found.verdict, found.name) == ("effect", "reference_drift"), found.text
        assert {*found.group} <= {"reference_drift", "scale_drift"}
        after = fit(poses, Model.of((*BASE, "reference_drift")))
        assert after.chi2 < 1.5 * after.dof
        assert after.theta[-1] == pytest.approx(drift * SECONDS_PER_HOUR, rel=0.1)


def test_beside_an_effect_of_the_sensor_that_hides_the_drift() -> None:
    """The first fit alone has the clips further apart than the session is long."""
    for name, seed in (("g_sensitivity", 501), ("bias_drift", 500)):
        hidden = hidden_of(["reference_drift", name], "gyroscope", 20.0, RICH, seed)
        assert hidden is not None
        hidden[0] = replace(hidden[0], detail={"filmed": 0.4})
        poses = poses_of(RICH, seed, "gyroscope", hidden)
        found = diagnose(fit(poses, Model.of(BASE)))
        assert {*found.names} == {name, "reference_drift"}, found.text


@pytest.mark.parametrize("seed", [406, 414])
def test_rates_that_err_without_a_drift_in_the_runs_are_none(seed: int) -> None:
    """None shows in one evening, and in the other clips would lie too far apart for it."""
    hidden = hidden_of(["reference_offset"], "gyroscope", 6.0, RICH, seed)
    assert hidden is not None
    found = diagnose(fit(poses_of(RICH, seed, "gyroscope", hidden), Model.of(BASE)))
    assert found.name == "reference_offset"
    assert "reference_drift" not in found.group


def test_with_a_clip_for_each_pose_only_the_sensor_drifts() -> None:
    poses = rich_poses("gyroscope", 4)
    gain = 1 + 2e-3 * (poses.time_s / np.ptp(poses.time_s))[:, None]
    reference = replace(
        poses.reference, sd=1e-5 * poses.reference.magnitude, common=np.zeros((len(poses), 0)),
        common_names=(), of_setting=frozenset())
    filmed = noisy(replace(poses, reading=poses.reading * gain, reference=reference), 4)
    found = diagnose(fit(filmed, Model.of(BASE)))
    assert found.group == ("scale_drift",), found.text
    assert "reference_drift" in found.blind
