"""Model beside measurements: leave-one-out in closed form, and which pose is worst."""

from dataclasses import replace

import numpy as np
import pytest

from calib.effects.catalogue import BASE
from calib.fit.leave_one_out import compare
from calib.fit.model import Model
from calib.fit.residuals import Equations
from calib.fit.solver import fit
from tests.calib.made_poses import FAST, SLOW, chosen, made_poses, noisy

MODEL = Model.of(BASE)


@pytest.mark.parametrize("pose", [0, 9, 20, 40])
def test_leaving_one_out_in_closed_form_is_refitting_without_it(pose: int) -> None:
    """Magnitude rows and the three rows of a pose at rest alike."""
    read = noisy(made_poses("gyroscope", (SLOW, FAST, 0.0), shared_sd=1e-4), 3)
    compared = compare(fit(read, MODEL)).poses[pose]
    rest = [i for i in range(len(read)) if i != pose]
    without = fit(chosen(read, rest), MODEL)
    rows = Equations(read, MODEL).rows(without.theta, without.eta, {})
    equations = Equations(read, MODEL)
    mine = equations.row_pose == pose
    left_out = (rows.residual[: equations.data_count] * equations.row_sd)[mine]
    if read.reference.is_null[pose]:
        assert compared.left_out == pytest.approx(np.linalg.norm(left_out), rel=2e-3)
    else:
        assert compared.left_out == pytest.approx(left_out[0], rel=5e-3, abs=1e-8)


def test_the_pose_that_was_spoilt_is_the_worst() -> None:
    read = noisy(made_poses("gyroscope", (SLOW, -SLOW)), 5)
    reading = read.reading.copy()
    reading[11] *= 1.01
    worst = compare(fit(replace(read, reading=reading), MODEL)).worst(1)[0]
    assert worst.label == "pose 12"
    assert worst.in_sd > 10
    assert worst.left_out > worst.residual


def test_the_root_mean_squares_are_those_of_the_rows() -> None:
    found = fit(noisy(made_poses("gyroscope", (SLOW, 0.0)), 6), MODEL)
    compared = compare(found)
    assert compared.residual_rms == pytest.approx(np.sqrt(np.mean(found.residual_si**2)))
    assert compared.loo_rms > compared.residual_rms
    assert len(compared.poses) == 36
    signed = [pose.residual for pose in compared.poses[:18]]
    assert min(signed) < 0 < max(signed)
    lengths = [pose.residual for pose in compared.poses[18:]]
    assert min(lengths) > 0
