"""Common errors beside a misfit: no gain is lost to them, and a widening leaves them alone."""

from dataclasses import replace

import numpy as np
import pytest

from calib.diagnosis.diagnose import diagnose
from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import calibrate_triad, uncertainty_budget
from calib.poses.pose_set import PoseSet
from tests.calib.made_poses import GRAVITY, MODEL, SLOW, SPECS, base_theta, made_poses, noisy

CLOCK = 5000e-6


def misfitting(clock: float, strength: float) -> PoseSet:
    """26 poses of one speed, axis x bent by so many sds, and the relative sd of the clock."""
    poses = noisy(made_poses("gyroscope", (SLOW,), corners=True, shared_sd=1e-9), 3)
    bent = poses.reading.copy()
    bent[:, 0] += strength * poses.sd[:, 0] * (bent[:, 0] / SLOW) ** 3
    reference = poses.reference
    common = clock * reference.magnitude[:, None]
    return replace(poses, reading=bent, reference=replace(reference, common=common))


def test_a_misfit_does_not_turn_into_gain_by_way_of_the_clock() -> None:
    """A misfit of a hundred sds beside a clock of 5000 ppm (Peelle's puzzle)."""
    known = fit(misfitting(0.0, 300.0), MODEL)
    doubtful = fit(misfitting(CLOCK, 300.0), MODEL)
    assert known.chi2 / known.dof > 300
    assert doubtful.theta[3:6] == pytest.approx(known.theta[3:6], abs=1e-5)
    assert np.abs(doubtful.eta).max() < 0.01
    # The clock's own uncertainty stands in the scale all the same.
    sd = np.sqrt(np.diag(doubtful.cov))[3:6]
    alone = np.sqrt(np.diag(known.cov))[3:6]
    assert sd == pytest.approx(np.hypot(alone, CLOCK), rel=0.05)


def at_rest_too(clock: float) -> PoseSet:
    """One speed and the plate stopped, a g-sensitivity of 0.1 °/s per g in every element."""
    poses = noisy(made_poses("gyroscope", (SLOW, 0.0), shared_sd=1e-9), 1)
    size = np.radians(0.1) / GRAVITY * np.random.default_rng(3).choice([-1.0, 1.0], (3, 3))
    reference = poses.reference
    return replace(poses, reading=poses.reading + poses.force @ size.T,
                   reference=replace(reference, common=clock * reference.magnitude[:, None]))


@pytest.mark.parametrize("clock", [CLOCK, 0.01, 0.03])
def test_a_misfit_at_rest_does_not_turn_into_gain_either(clock: float) -> None:
    """A gain that shrinks with the clock would shrink what a g-sensitivity leaves at rest."""
    known = fit(at_rest_too(0.0), MODEL)
    doubtful = fit(at_rest_too(clock), MODEL)
    assert known.chi2 / known.dof > 20
    assert doubtful.theta[3:6] == pytest.approx(known.theta[3:6], abs=0.01 * clock)
    assert np.abs(doubtful.eta).max() < 0.01
    named = diagnose(doubtful)
    assert named.names == ("g_sensitivity",)
    added = fit(at_rest_too(clock), Model.of([*BASE, "g_sensitivity"]))
    assert added.p_value > 0.01


def test_two_settings_that_disagree_by_a_clock_still_pull_it() -> None:
    """What the data do say of a common error is still heard."""
    poses = noisy(made_poses("gyroscope", (SLOW, 2 * SLOW), shared_sd=1e-3), 5)
    reference = poses.reference
    off = np.where(np.array(poses.run) == "run 1", 1.002, 1.0)
    wrong = replace(poses, reference=replace(reference, magnitude=reference.magnitude * off))
    assert np.abs(fit(wrong, MODEL).eta).max() > 0.5


def test_a_widening_leaves_the_priors_as_they_were_stated() -> None:
    calibration = calibrate_triad(fit(misfitting(500e-6, 100.0), MODEL), SPECS["gyroscope"])
    assert calibration.widening > 5
    budget = uncertainty_budget(calibration)
    scale = calibration.parameters.scale_counts_per_unit
    for name, sds in budget.items():
        if name == "noise":
            assert (sds[2] / scale > 5 * 3e-5).all()
            continue
        assert sds[2] / scale == pytest.approx(500e-6, rel=0.05)
    variance = sum(sd**2 for sd in budget.values())
    assert variance == pytest.approx(np.array(calibration.parameters.sd) ** 2, rel=1e-9)


def test_without_a_misfit_the_stated_sd_of_the_scale_holds() -> None:
    """60 evenings whose clock is off by a draw of its sd."""
    model = Model.of(BASE)
    truth = base_theta(model, "gyroscope")
    scores = []
    for seed in range(60):
        found = fit(noisy(made_poses("gyroscope", (SLOW,), seed=seed, shared_sd=1e-3), seed), model)
        scores.append(((found.theta - truth) / np.sqrt(np.diag(found.cov)))[3:6].mean())
    assert np.std(scores) == pytest.approx(1.0, abs=0.25)
