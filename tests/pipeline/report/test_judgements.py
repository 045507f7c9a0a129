"""What the page says of a ticked effect, by the fits with and without it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import calibrate_triad
from calib.fit.validation.leave_one_out import compare
from pipeline.report.triad.refit_table import Judgement, judged_effect
from pipeline.report.triad.refitted import Refitted
from tests.calib.made_poses import SPECS, rich_poses, with_noise

POSES = rich_poses("accelerometer")
BENT = with_noise(replace(POSES, reading=POSES.reading + 0.001 * POSES.reading**2
                          - 2e-4 * POSES.reading**3), np.random.default_rng(1))
"""Poses with a quadratic and a cubic nonlinearity, m/s²."""


def refitted(*added: str) -> Refitted:
    """The poses with these effects in the model."""
    fitted = fit(BENT, Model.of((*BASE, *added)))
    return Refitted(calibrate_triad(fitted, SPECS["accelerometer"]), compare(fitted))


def judged(name: str, *beside: str) -> Judgement:
    """The judgement of ``name`` beside others."""
    one = judged_effect(name, refitted(*beside, name), refitted(*beside))
    assert one is not None
    return one


def test_an_effect_that_leaves_much_may_stand_for_another() -> None:
    assert "it is there, or stands for what is still unexplained" in judged("cubic").text(
        in_model=False, ticked=True)
    both = judged("cubic", "quadratic")
    assert not both.leaves_much
    assert ": it is there; leave-one-out falls" in both.text(in_model=False, ticked=True)


def test_the_sds_of_three_parameters_are_those_of_one_normal_number() -> None:
    without, with_it = refitted("quadratic", "cubic"), refitted("quadratic", "cubic", "asymmetry")
    p_value = stats.chi2.sf(without.fit.chi2 - with_it.fit.chi2, 3)
    one = judged_effect("asymmetry", with_it, without)
    assert one is not None
    assert not one.is_there
    assert one.in_sd == pytest.approx(stats.norm.isf(p_value / 2), abs=0.05)
    assert judged("cubic", "quadratic").in_sd > 10
