"""Scatter of the rate against scatter of the poses, and effects that are less than noise."""

from dataclasses import replace

import numpy as np
import pytest

from calib.assess import assess
from calib.diagnosis.diagnose import diagnose
from calib.diagnosis.finding import find
from calib.diagnosis.hypotheses.courses import scattering_rates
from calib.diagnosis.search.entry import Inclusion
from calib.diagnosis.verdict.decision import Code, Verdict
from calib.diagnosis.verdict.explain import explain
from calib.diagnosis.verdict.ranking import rank
from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from tests.calib.made_poses import (
    FAST,
    SLOW,
    SPECS,
    base_theta,
    made_poses,
    noisy,
    read_through,
    rich_poses,
)


@pytest.mark.parametrize(("drawn", "kind"), [("bias", "pose_scatter"), ("rate", "rate_scatter")])
def test_a_plate_scatters_only_where_the_poses_at_rest_do_not(drawn: str, kind: str) -> None:
    """Poses at rest are shorter, so that the same scatter of the bias shows less in them."""
    for seed in (1, 2):
        poses, rng = noisy(rich_poses("gyroscope"), seed), np.random.default_rng(seed)
        turns = ~poses.reference.is_null[:, None]
        sd = poses.sd * np.where(turns, 1.0, 1.5)
        draw = 1.2 * np.median(sd) * rng.normal(size=sd.shape)
        if drawn == "rate":
            length = np.linalg.norm(poses.reading, axis=1, keepdims=True)
            draw = 2 * draw[:, :1] * np.where(turns, poses.reading / length, 0.0)
        reading = poses.reading + draw
        found = diagnose(fit(replace(poses, sd=sd, reading=reading), Model.of(BASE)))
        assert (found.verdict, found.name) == ("noise", kind), found.text


def test_a_wrong_rate_of_a_run_is_no_noise_of_its_poses() -> None:
    poses = made_poses("gyroscope", (SLOW, -SLOW, FAST, -FAST, 0.0), seed=3, shared_sd=1e-3)
    wrong = np.isin(poses.run, ["run 2"])[:, None]
    noise = 1.4 * poses.sd * np.random.default_rng(3).standard_normal(poses.sd.shape)
    found = diagnose(fit(replace(
        poses, reading=poses.reading * np.where(wrong, 1.02, 1.0) + noise), Model.of(BASE)))
    assert (found.verdict, found.name) == ("noise", "rate_scatter"), found.text
    assert "from run to run" in found.text


def test_a_factor_that_all_rates_have_in_common_is_no_scatter_of_rates() -> None:
    """Beside other effects it would be all that a gain of the sensor hides, whatever its size."""
    poses = made_poses("gyroscope", (SLOW, FAST, -FAST, 0.0), seed=3, shared_sd=1e-3)
    scatter = next(h for h in scattering_rates(fit(poses, Model.of(BASE))) if h.detail)
    assert scatter.course is not None
    in_sd = np.array([1 / sd if sd else 0.0 for sd in np.abs(
        poses.reference.common / np.maximum(poses.reference.magnitude, 1e-9)[:, None]).max(axis=0)])
    columns = scatter.course.values[:, :, 0]
    assert np.abs(columns).max() > 0.1
    assert columns @ in_sd == pytest.approx(0.0, abs=1e-9 * in_sd.max())


def test_an_effect_that_shows_by_its_shape_is_named_where_the_noise_is_less_than_stated() -> None:
    true = rich_poses("gyroscope")
    size = 4 * np.median(true.sd) / np.ptp(true.time_s) * np.array([1.0, -0.7, 0.5])
    poses = noisy(true, 1)
    reading = poses.reading + size * (poses.time_s - poses.time_s.mean())[:, None]
    base = fit(replace(poses, reading=reading, sd=1.6 * poses.sd), Model.of(BASE))
    found = diagnose(base)
    assert base.chi2 < base.dof
    assert (found.verdict, found.name) == ("effect", "bias_drift"), found.text


def test_a_noise_that_looks_the_same_is_not_told_once_more_with_odds() -> None:
    base = fit(noisy(rich_poses("gyroscope"), 1), Model.of(BASE))
    plate = Inclusion("rate_scatter", ("rate_scatter",), 0.995, "drawn")
    several = Inclusion("quadratic", ("quadratic", "asymmetry"), 0.6, "listed")
    verdict = Verdict(Code.NOISE, "extra_noise", group=("extra_noise", "rate_scatter"),
                      beside=(plate, several))
    said = explain(base, verdict, rank(find(base).posterior), 1e-9, None)
    assert "'rate_scatter' looks the same" in said.text
    assert "It may be one of 'quadratic' and 'asymmetry' (6 in 10) instead" in said.text


@pytest.mark.parametrize(("scatter", "name"), [(0.003, "rate_scatter"), (0.03, "spin_rad_s")])
def test_a_scattering_rate_is_told_and_in_the_sds_at_every_size(scatter: float, name: str) -> None:
    """In proportion to the rate; and columns at the readings would make up so large a misfit."""
    model = Model.of(BASE)
    theta, deviations = base_theta(model, "gyroscope"), []
    poses = read_through(rich_poses("gyroscope"), model, theta)
    turning = ~poses.reference.is_null[:, None]
    for seed in (5, 7):
        rng = np.random.default_rng(seed)
        noise = poses.sd * rng.standard_normal(poses.sd.shape)
        share = scatter * rng.standard_normal((len(poses), 1)) * turning
        reading = poses.reading + share * (poses.reading - theta[:3]) + noise
        said = assess(replace(poses, reading=reading), model, SPECS["gyroscope"])
        assert said.diagnosis.name == name, said.diagnosis.text
        assert ("no plate that turns evenly" in said.diagnosis.text) == (name != "rate_scatter")
        fitted = said.calibration.fit
        deviations.append((fitted.theta - theta) / np.sqrt(np.diag(fitted.cov)))
    assert np.abs(deviations).max() < 4
