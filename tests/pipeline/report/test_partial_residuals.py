"""Partial residuals: the picture of an effect shows what an exact fit with that effect finds."""

import re
import shutil
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from calib.effects.catalogue import find_effect
from calib.effects.effect import Effect
from calib.effects.expression import read_expression
from calib.effects.user_defined import user_effect
from calib.errors import CalibrationError
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from pipeline.config.load import load_config
from pipeline.report.triad.axis_charts import axis_charts, lead_panel
from pipeline.report.triad.partial_residuals import Panel, panels
from pipeline.report.triad.refitted import Refits
from pipeline.stages.context import RunContext
from pipeline.stages.run import Outcome, run_stages
from tests.world.designs import rich_design
from tests.world.session import simulate
from tests.world.sizes import draw_effect
from tests.world.write import write_session

SHOWN = {"accelerometer": 1000.0, "gyroscope": np.degrees(1.0)}  #: of one SI unit


@pytest.fixture
def outcome(both_missing: Outcome) -> Outcome:
    return both_missing


def fit_of(outcome: Outcome, triad: str) -> Fit:
    return next(each for each in outcome.triads if each.triad == triad).calibration.fit


def exact(base: Fit, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Parameters of the effect in a fit with it, and their sds, SI."""
    full = fit(base.poses, base.model + find_effect(name))
    where = full.model.slices()[name]
    return full.theta[where], np.sqrt(np.diag(full.cov))[where]


def panels_of(base: Fit, effect: Effect) -> tuple[Panel, ...]:
    """The panels of an effect beside a fit without it, as the page makes them."""
    with suppress(CalibrationError):
        return panels(fit(base.poses, base.model + effect), effect)
    return ()


def in_sds(shown: tuple[Panel, ...], which: str) -> float:
    return float(np.sqrt(np.mean(np.concatenate(
        [getattr(panel, which) / panel.sd for panel in shown])**2)))


@pytest.mark.parametrize(("triad", "name", "per"), [
    ("accelerometer", "temperature_bias", 1.0), ("gyroscope", "g_sensitivity", 9.80665),
])
def test_the_slopes_are_the_parameters_of_the_exact_fit_in_human_units(
    outcome: Outcome, triad: str, name: str, per: float
) -> None:
    base = fit_of(outcome, triad)
    shown = panels_of(base, find_effect(name))
    theta, sd = exact(base, name)
    factor = SHOWN[triad] * per
    slopes = np.array([panel.slope for panel in shown])
    assert slopes == pytest.approx(theta * factor, rel=1e-6)
    stated = np.array([panel.slope_sd for panel in shown])
    assert stated == pytest.approx(sd * factor, rel=1e-6)


@pytest.mark.parametrize(("triad", "name"), [
    ("accelerometer", "temperature_bias"), ("gyroscope", "g_sensitivity"),
])
def test_dots_follow_the_line_and_the_squares_are_noise(
    outcome: Outcome, triad: str, name: str
) -> None:
    base = fit_of(outcome, triad)
    shown = panels_of(base, find_effect(name))
    after, before = in_sds(shown, "after"), in_sds(shown, "before")
    full = fit(base.poses, base.model + find_effect(name))
    assert after < 1.5 * np.sqrt(full.chi2 / full.dof)  # what the exact fit leaves, too
    assert before > 3 * after
    for panel in shown:
        on_line = np.interp(panel.x, *panel.curve)
        largest = float(np.abs(panel.before).max())
        assert panel.before - on_line == pytest.approx(panel.after, abs=1e-6 * largest)


def test_the_wrong_effect_leaves_the_dots_where_they_are(outcome: Outcome) -> None:
    base = fit_of(outcome, "accelerometer")
    right = in_sds(panels_of(base, find_effect("temperature_bias")), "after")
    wrong = in_sds(panels_of(base, find_effect("bias_drift")), "after")
    assert wrong**2 > 2 * right**2


def test_every_panel_has_the_axis_and_the_quantity_that_drive_it(outcome: Outcome) -> None:
    gyroscope, accelerometer = (fit_of(outcome, t) for t in ("gyroscope", "accelerometer"))
    nine = panels_of(gyroscope, find_effect("g_sensitivity"))
    assert [(p.axis, p.against[-1]) for p in nine] == [(k, j) for k in "xyz" for j in "xyz"]
    assert {p.per for p in nine} == {"g"}
    scale = panels_of(accelerometer, find_effect("temperature_scale"))
    assert [(p.axis, p.against, p.unit) for p in scale] == [
        (axis, "temperature", "ppm") for axis in "xyz"]
    curved = panels_of(accelerometer, find_effect("quadratic"))
    assert [p.against for p in curved] == [f"specific force along {axis}" for axis in "xyz"]
    assert all(np.isnan(p.slope) for p in curved)
    assert all(np.isnan(p.slope) for p in panels_of(accelerometer, find_effect("warm_up")))


@pytest.mark.parametrize(("triad", "name"), [
    ("gyroscope", "reference_scale"), ("accelerometer", "frame_rotation")])
def test_what_the_poses_do_not_determine_has_no_panel(
    outcome: Outcome, triad: str, name: str
) -> None:
    assert panels_of(fit_of(outcome, triad), find_effect(name)) == ()


def test_a_logged_column_is_shown_however_far_from_zero_it_is(outcome: Outcome) -> None:
    base = fit_of(outcome, "accelerometer")
    supply = base.poses.columns["supply_v"]
    assert np.ptp(supply) < 0.1 * supply.mean()
    shown = panels_of(base, find_effect("column:supply_v"))
    assert [(p.axis, p.against) for p in shown] == [(axis, "supply_v") for axis in "xyz"]
    for panel in shown:
        assert panel.x == pytest.approx(supply[panel.pose])
        assert panel.slope == pytest.approx(np.ptp(panel.curve[1]) / np.ptp(panel.x)
                                            * np.sign(panel.slope), rel=1e-6)


def test_what_several_conditions_drive_is_shown_against_its_own_column(outcome: Outcome) -> None:
    base = fit_of(outcome, "gyroscope")
    first, *_ = panels_of(base, find_effect("hysteresis"))
    assert (first.against, first.per) == ("memory of the pose before along x", "")
    on_line = np.interp(first.x, *first.curve)
    largest = float(np.abs(first.before).max())
    assert first.before - on_line == pytest.approx(first.after, abs=1e-6 * largest)


def test_an_expression_is_shown_against_the_one_quantity_in_it_or_against_its_text(
    outcome: Outcome
) -> None:
    base = fit_of(outcome, "accelerometer")
    for text, words in (("temperature_c ** 2", "temperature"),
                        ("temperature_c * time_s", "temperature_c * time_s")):
        effect = user_effect("mine", read_expression(text), "axis", "m/s²", None)
        shown = panels_of(base, effect)
        assert [panel.against for panel in shown] == [words] * 3, text
        assert [panel.axis for panel in shown] == ["x", "y", "z"]


def test_of_two_missing_effects_each_is_shown_beside_the_other(tmp_path: Path) -> None:
    design = rich_design().scaled(seconds=0.6, sample_rate=0.5)
    hidden = (draw_effect("hysteresis", "gyroscope", 20.0, design, 3),
              draw_effect("direction_dependent_rate", "gyroscope", 20.0, design, 3))
    written = write_session(tmp_path, simulate(design, 3, hidden), film=False)
    outcome = run_stages(load_config(written.config), RunContext())
    gyroscope = outcome.triad("gyroscope")
    assert gyroscope is not None
    assert {h.name for h in hidden} <= set(gyroscope.diagnosis.names)
    first, second = axis_charts(Refits(gyroscope))[:2]
    assert {first.effect, second.effect} == {h.name for h in hidden}
    for chart in (first, second):
        assert in_sds(chart.panels, "after") < 0.2 * in_sds(chart.panels, "before"), chart.effect


def test_an_effect_on_the_reference_is_shown_run_by_run_in_ppm(tmp_path: Path) -> None:
    design = rich_design().scaled(seconds=0.6, sample_rate=0.5)
    hidden = draw_effect("direction_dependent_rate", "gyroscope", 20.0, design, 4)
    written = write_session(tmp_path, simulate(design, 4, (hidden,)), film=False)
    outcome = run_stages(load_config(written.config), RunContext())
    (panel,) = panels_of(fit_of(outcome, "gyroscope"), find_effect("direction_dependent_rate"))
    assert (panel.axis, panel.unit) == ("reference", "ppm")
    assert [name for _, name in panel.ticks] == ["17rpm", "m17rpm", "33rpm", "m33rpm"]
    assert len(panel.x) == 72
    true = 1e6 * abs(float(hidden.size))
    assert np.ptp(panel.curve[1]) == pytest.approx(2 * true, rel=0.05)
    assert in_sds((panel,), "before") > 5 * in_sds((panel,), "after")


def test_an_effect_in_the_model_shows_the_fitted_size(outcome: Outcome) -> None:
    base = fit_of(outcome, "accelerometer")
    full = fit(base.poses, base.model + find_effect("temperature_bias"))
    slopes = [panel.slope for panel in panels(full, find_effect("temperature_bias"))]
    theta = full.theta[full.model.slices()["temperature_bias"]]
    assert slopes == pytest.approx(1000 * theta, rel=1e-9)


def test_the_report_leads_with_the_effect_of_the_verdict_and_shows_time_too(
    outcome: Outcome
) -> None:
    assert outcome.triad("accelerometer") is not None
    assert outcome.triad("gyroscope") is not None
    for result, name in ((outcome.triad("accelerometer"), "temperature_bias"),
                         (outcome.triad("gyroscope"), "g_sensitivity")):
        charts = axis_charts(Refits(result))
        assert (charts[0].effect, charts[0].leads) == (name, True)
        assert "bias_drift" in {chart.effect for chart in charts[1:]}
        assert len({chart.effect for chart in charts}) == len(charts)


def test_the_first_screen_shows_what_is_missing_and_never_what_the_model_holds(
    outcome: Outcome, tmp_path: Path
) -> None:
    assert outcome.triad("gyroscope") is not None
    gyroscope = outcome.triad("gyroscope")
    lead, effect = lead_panel(gyroscope, axis_charts(Refits(gyroscope)))
    assert lead is not None
    assert effect == "g_sensitivity"
    assert re.match(r"Axis [xyz] errs by .* °/s per g of specific force along [xyz]",
                    lead.title)
    for result in outcome.triads:  # one size of an effect on a page
        quoted = re.search(r"Its largest part is (\S+ ± \S+)", result.diagnosis.explanation.text)
        shown, _ = lead_panel(result, axis_charts(Refits(result)))
        assert quoted is not None
        assert shown is not None
        assert quoted[1] in shown.title.replace("−", "-")
    shutil.copytree(outcome.config.source.path.parent, tmp_path, dirs_exist_ok=True)
    config = tmp_path / "config.yaml"
    head, _, tail = config.read_text(encoding="utf-8").rpartition("misalignment]")
    config.write_text(f"{head}misalignment, g_sensitivity]{tail}", encoding="utf-8")
    with_it = run_stages(load_config(config), RunContext()).triad("gyroscope")
    assert with_it is not None
    charts = axis_charts(Refits(with_it))
    assert (charts[0].effect, charts[0].in_model) == ("g_sensitivity", True)
    assert lead_panel(with_it, charts) == (None, "")
