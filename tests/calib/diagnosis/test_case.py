"""What the text of a verdict quotes: sizes of one refit, poses by attitude, p where it counts."""

from dataclasses import replace

import numpy as np
import pytest

from calib.consistency.data_sheet import sds_too_large
from calib.diagnosis.diagnose import diagnose
from calib.diagnosis.finding import find
from calib.diagnosis.next_measurement.advice import pose_in_words
from calib.diagnosis.search.refit import refit
from calib.diagnosis.verdict.decision import Code, Verdict, refit_of
from calib.diagnosis.verdict.explain import explain
from calib.diagnosis.verdict.ranking import rank
from calib.effects.catalogue import BASE, find_effect
from calib.fit.least_squares.solver import Fit, fit
from calib.fit.model import Model
from calib.poses.attitudes import direction_name
from tests.calib.made_poses import noisy, rich_poses
from tests.set_trials import design_of
from tests.trials import hidden_of, poses_of


def hiding(name: str, size: float, seed: int) -> Fit:
    """18 poses of an accelerometer with an effect of so many sds."""
    design = design_of("paper", seed)
    hidden = hidden_of((name,), "accelerometer", size, design, seed)
    assert hidden is not None
    return fit(poses_of(design, seed, "accelerometer", hidden), Model.of(BASE))


@pytest.mark.parametrize(("p_value", "says"), [
    (0.3, "the poses' own noise explains the residual"),
    (0.002, "which makes one so large in one session of 500 "),
])
def test_a_rare_residual_is_not_explained_by_noise(p_value: float, says: str) -> None:
    base = fit(noisy(rich_poses("gyroscope"), 4), Model.of(BASE))
    assert says in explain(
        base, Verdict(Code.NOTHING_MISSING, explains=True), [], p_value, None).text


@pytest.mark.parametrize(("size", "quoted"), [(2.5, False), (30.0, True)])
def test_p_is_quoted_only_where_the_verdict_rests_on_it(size: float, quoted: bool) -> None:
    """Noise could make an effect of a few sds; the fall of chi-square is what speaks for it."""
    base = hiding("quadratic", size, 1)
    found = diagnose(base)
    assert found.verdict != "nothing_missing"
    assert ("p = " in found.text) is quoted
    assert ("chi² falls from" in found.text) is not quoted
    assert f"chi²/dof {base.chi2 / base.dof:.3g}" in found.text


def test_the_size_of_a_named_effect_is_that_of_the_refit_with_what_is_named() -> None:
    """Also where the leading set holds more than the verdict names."""
    design = design_of("rich", 31)
    hidden = hidden_of(("g_sensitivity", "cubic"), "gyroscope", 20.0, design, 31)
    assert hidden is not None
    posterior = find(fit(poses_of(design, 31, "gyroscope", hidden), Model.of(BASE))).posterior
    assert {"g_sensitivity", "cubic"} <= posterior.names(posterior.lead)
    alone = refit(posterior.base, [find_effect("g_sensitivity")])
    assert alone is not None
    assert posterior.lead.refit is not None
    size, of_lead = (one.fit.theta[one.fit.model.slices()["g_sensitivity"]]
                     for one in (alone, posterior.lead.refit))
    assert not np.allclose(size, of_lead, rtol=1e-4)
    ranking = rank(posterior, refit_of(posterior, ["g_sensitivity"]))
    (candidate,) = (one for one in ranking if one.name == "g_sensitivity")
    assert candidate.size == pytest.approx(size)


def test_bad_poses_are_told_by_file_and_attitude() -> None:
    poses = noisy(rich_poses("gyroscope"), 4)
    reading = poses.reading.copy()
    for k in (5, 70):
        reading[k] += 40 * poses.sd[k]
    found = diagnose(fit(replace(poses, reading=reading), Model.of(BASE)))
    for k in (5, 70):
        up = direction_name(poses.force[k] / np.linalg.norm(poses.force[k]))
        assert f"{poses.label[k]} ({up})" in found.text
    (bad,) = (one for one in found.inclusion if one.kind == "bad_pose")
    assert set(bad.details) == {poses.label[5], poses.label[70]}


@pytest.mark.parametrize("sd", [0.4, 1.0, 2.5])
def test_sds_that_are_plainly_too_large_are_remarked_on(sd: float) -> None:
    """Sds stated at so many times what the poses scatter; too small ones are a misfit."""
    poses = noisy(rich_poses("gyroscope", 2), 2)
    said = [*sds_too_large(fit(replace(poses, sd=sd * poses.sd), Model.of(BASE)))]
    assert len(said) == (sd > 1)
    assert all("about 2." in words for words in said)


def test_no_rest_of_a_misfit_is_told_where_noise_alone_makes_it() -> None:
    """Three bad poses under sds that are stated at 2.2 times what the others scatter."""
    poses = noisy(rich_poses("gyroscope", 2), 2)
    sd, reading, bad = 2.2 * poses.sd, poses.reading.copy(), [3, 40, 60]
    reading[bad] += 3.75 * sd[bad] * np.sign(reading[bad])
    found = diagnose(fit(replace(poses, reading=reading, sd=sd), Model.of(BASE)))
    assert found.verdict.value == "bad_pose"
    assert "which noise alone can make" in found.text
    assert "remain" not in found.text


@pytest.mark.parametrize(("sd_g2", "seen"), [(1e-6, False), (0.3, True)])
def test_an_effect_that_shows_only_at_an_absurd_size_is_blind(sd_g2: float, seen: bool) -> None:
    """Vibration of a quiet table, and of an engine, under an accelerometer."""
    poses = noisy(rich_poses("accelerometer", 3), 3)
    shaken = np.random.default_rng(3).uniform(0, sd_g2 * 96.2, poses.vibration.shape)
    found = diagnose(fit(replace(poses, vibration=shaken), Model.of(BASE)))
    assert ("vibration_rectification" in found.blind) is not seen
    ranked = [one.name for one in found.ranking]
    assert ("vibration_rectification" in ranked) is seen


def test_a_size_by_the_data_sheet_s_gain_is_called_so() -> None:
    """A gyroscope at rest, of which the bias alone is fitted: errors of 0.1 °/s per g and less."""
    poses = noisy(rich_poses("gyroscope", 1), 1)
    still = poses.take(np.flatnonzero(poses.reference.is_null))
    shown = still.force @ np.random.default_rng(1).normal(0, 1e-4, (3, 3)).T
    found = diagnose(fit(replace(still, reading=still.reading + shown), Model.of(BASE[:1])))
    assert found.names == ("g_sensitivity",)
    assert "by the gain of the data sheet, which these poses do not measure" in found.text
    assert "data sheet" not in diagnose(hiding("quadratic", 30.0, 1)).text


def test_a_pose_is_named_without_the_folders_beside_that_of_the_session() -> None:
    design = design_of("paper", 1)
    poses = poses_of(design, 1, "accelerometer", ())
    labels = ("../../lab/evening/log.csv 3.1-9.8 s", "rest/pose_02.csv", *poses.label[2:])
    named = fit(replace(poses, label=labels), Model.of(BASE))
    assert pose_in_words(named, labels[0]).startswith("log.csv 3.1-9.8 s (")
    assert pose_in_words(named, labels[1]).startswith("rest/pose_02.csv (")
