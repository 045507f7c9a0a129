"""Rates of the runs that scatter: the scale's sd contains it, whatever was stated of each rate."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from calib.diagnosis.diagnose import diagnose
from calib.diagnosis.verdict.decision import Code
from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import BETWEEN_RUNS, calibrate_triad, uncertainty_budget
from calib.poses.data_sheet import TriadSpec
from calib.poses.pose_set import PoseSet
from tests.fitting import pose_sets
from tests.world.designs import rich_design
from tests.world.session import Session, simulate

SEEDS = range(12)
DESIGN = rich_design().scaled(sample_rate=0.2)


@cache
def evening(seed: int) -> tuple[Session, PoseSet, TriadSpec]:
    session = simulate(DESIGN, seed)
    _, poses, specs = pose_sets(session)
    return session, poses, specs[1]


def with_other_rates(poses: PoseSet, factors: Mapping[str, float]) -> PoseSet:
    """What is stated of the rates of the runs is off by these factors; stopped ones stay."""
    factor = np.array([factors.get(run, 1.0) for run in poses.run])
    return replace(poses, reference=replace(
        poses.reference, magnitude=poses.reference.magnitude * factor))


def with_stated_sds(poses: PoseSet, relative: float) -> PoseSet:
    """The same relative sd of the rate of each run."""
    reference = poses.reference
    of_runs = [name in reference.of_setting for name in reference.common_names]
    stated = np.where(of_runs, (reference.common > 0) * relative * reference.magnitude[:, None],
                      reference.common)
    return replace(poses, reference=replace(reference, common=stated))


@pytest.mark.parametrize(("scatter", "stated"), [(1e-4, 5e-6), (1e-3, 5e-6), (5e-3, 5e-6),
                                                 (5e-3, 3e-4)])
def test_the_scale_holds_the_truth_where_the_rates_of_the_runs_scatter(
    scatter: float, stated: float
) -> None:
    sds_off = []
    for seed in SEEDS:
        session, poses, spec = evening(seed)
        rng = np.random.default_rng([seed, 99])
        other = with_other_rates(with_stated_sds(poses, stated), {
            name: 1 + scatter * rng.standard_normal() for name in session.rates})
        found = calibrate_triad(fit(other, Model.of(BASE)), spec)
        scale, true = found.parameters.scale_counts_per_unit, session.gyroscope
        sds_off.append((scale - true.scale_counts_per_unit) / found.parameters.sd[2])
        parts = uncertainty_budget(found)
        whole = np.sqrt(sum(part**2 for part in parts.values()))
        assert np.allclose(whole, found.parameters.sd, rtol=1e-6)
        assert BETWEEN_RUNS in parts or scatter < 1e-3
    assert np.sqrt(np.mean(np.square(sds_off))) < 1.35  # 20 and more without it
    assert np.abs(sds_off).max() < 4


def test_runs_that_agree_add_nothing() -> None:
    _, poses, spec = evening(3)
    found = calibrate_triad(fit(poses, Model.of(BASE)), spec)
    assert not found.unaveraged


def with_one_wrong_rate(poses: PoseSet, run: str) -> PoseSet:
    """0.3 % wrong at a stated 0.01 %: the common errors take nearly all of it, at many sds."""
    return with_other_rates(with_stated_sds(poses, 1e-4), {run: 1.003})


@pytest.mark.parametrize("seed", range(2))
def test_of_two_rates_one_that_is_wrong_is_no_noise_of_the_poses(seed: int) -> None:
    _, poses, _ = evening(seed)
    kept = [run in ("17rpm", "33rpm", "stopped") for run in poses.run]
    found = fit(with_one_wrong_rate(poses.take(np.array(kept)), "17rpm"), Model.of(BASE))
    diagnosis = diagnose(found)
    assert (diagnosis.verdict, diagnosis.name) == (Code.NOISE, "rate_scatter")
    assert "the rate 17rpm is 0.1" in diagnosis.explanation.text
    assert "% less than stated" in diagnosis.explanation.text


def test_of_four_rates_one_that_is_wrong_may_also_be_a_function_of_the_rate() -> None:
    _, poses, _ = evening(0)
    diagnosis = diagnose(fit(with_one_wrong_rate(poses, "17rpm"), Model.of(BASE)))
    assert diagnosis.inclusion[0].name == "rate_scatter"
    assert {each.name for each in diagnosis.inclusion} <= {"rate_scatter", "~spin_rad_s"}
