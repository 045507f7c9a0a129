"""What not every session has in its report: certificate, mounting, many clips, own effects."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calib.diagnosis.search.entry import Inclusion
from pipeline.config.load import load_config
from pipeline.console.run_text import limit_rows, unseen_text
from pipeline.report.page import report_html
from pipeline.report.plate.rate_charts import rate_view
from pipeline.report.triad.charts import residual_figure
from pipeline.report.triad.pose_sphere import coverage_of, up_directions
from pipeline.report.triad.tables import budget_rows, candidate_rows
from pipeline.stages.context import RunContext
from pipeline.stages.rate import measure_setting
from pipeline.stages.run import Outcome, run_stages
from tests.pipeline.conftest import RunSession
from tests.pipeline.report.html_page import Page
from tests.vision.phase_tracks import RPM, phase_track, steady
from vision.rate.timebase import Timebase

MORE = """
certificate:
  accelerometer:
    bias_counts: [33652, 33395, 32034]
    scale_counts_per_unit: [549.7, 552.7, 550.4]
installation: {log: accelerometer/pose_05.csv}
effects:
  warmth_squared: {expression: temperature_c ** 2, per: axis, unit: m/s² per °C²}
"""


@pytest.fixture(scope="module")
def outcome(finished: RunSession, tmp_path_factory: pytest.TempPathFactory) -> Outcome:
    """The session with a certificate, a mounting, an effect of the user's own, and one added."""
    folder = tmp_path_factory.mktemp("more")
    shutil.copytree(finished.config.parent, folder, dirs_exist_ok=True)
    config = folder / finished.config.name
    head, _, tail = config.read_text(encoding="utf-8").rpartition("misalignment]")
    config.write_text(f"{head}misalignment, bias_drift]{tail}{MORE}", encoding="utf-8")
    return run_stages(load_config(config), RunContext())


@pytest.fixture(scope="module")
def page(outcome: Outcome) -> Page:
    return Page(report_html(outcome, ()))


def test_a_certificate_stands_beside_the_estimate_with_the_difference_in_sds(page: Page) -> None:
    assert page.open == []
    for words in ("certificate", "difference [sd]", "33652", "549.7"):
        assert words in page.text


def test_the_mounting_is_said_with_its_forces(page: Page, outcome: Outcome) -> None:
    assert outcome.installation is not None
    assert "Mounting" in page.text
    assert "roll" in page.text
    for force in (*outcome.installation.before, *outcome.installation.after):
        assert f"{round(force, 4) + 0.0:.4f}".replace("-", "−") in page.text
    assert "(used)" in page.text
    for trial in outcome.installation.orders:
        assert f"{1e3 * trial.residual_m_s2:.2f}" in page.text
    assert "Readings in the vehicle's axes" in page.text


def test_an_effect_in_the_model_and_one_of_the_user_s_own_have_boxes(outcome: Outcome) -> None:
    result = outcome.triad("gyroscope")
    assert result is not None
    page = Page(report_html(outcome, ()))
    boxes = {box["data-effect"]: box for box in page.all("input")}
    assert "checked" in boxes["bias_drift"]
    assert "warmth_squared" in boxes


def test_the_causes_of_an_uncertainty_add_up_to_it(outcome: Outcome) -> None:
    result = outcome.triad("gyroscope")
    assert result is not None
    rows = budget_rows(result)
    assert rows[0][0].startswith("noise")
    assert "time base of the camera" not in dict(r[:2] for r in rows)  # the rate was stated
    by_cause = [float(row[2].split()[0]) for row in rows]
    sd = result.calibration.parameters.sd[1]
    assert sum(v**2 for v in by_cause) == pytest.approx(float((sd**2).mean()), rel=0.1)


def test_poses_at_rest_have_no_directions_to_cover_and_cannot_scatter_about_zero(
    finished: RunSession, tmp_path: Path
) -> None:
    shutil.copytree(finished.config.parent, tmp_path, dirs_exist_ok=True)
    config = tmp_path / finished.config.name
    head, section, _ = config.read_text(encoding="utf-8").partition("gyroscope:  #")
    assert section
    config.write_text(
        head + "gyroscope:\n  runs: [{poses: accelerometer/pose_*.csv, rate: stopped}]\n"
        "  model: [bias]\n", encoding="utf-8")
    outcome = run_stages(load_config(config), RunContext())
    assert outcome.triad("gyroscope") is not None
    assert outcome.triad("accelerometer") is not None
    assert "about zero" not in residual_figure(outcome.triad("gyroscope")).good
    assert "about zero" in residual_figure(outcome.triad("accelerometer")).good
    _, covered = coverage_of(up_directions(outcome.triad("accelerometer")))
    assert "18 poses cover 18 of the 18 faces and edges" in covered
    page = Page(report_html(outcome, ()))
    assert page.open == []
    assert "0 of the 18" not in page.text


# --- plate settings ----------------------------------------------------------------------------


def test_one_clip_per_pose_shows_every_rate_and_the_least_steady_clip() -> None:
    tracks = [phase_track(*steady(), noise_rad=noise, seed=i)
              for i, noise in enumerate((1e-4, 5e-4, 1e-4))]
    view = rate_view(measure_setting("slow", tracks, Timebase()))
    assert [figure.title for figure in view.figures][-1] == "Rate of every clip"
    assert "the largest residual of 3 clips" in view.frame_caption
    assert view.frame.startswith("data:image/png;base64,")
    assert dict(view.facts)["turns"]


def test_wow_flutter_and_drift_of_the_plate_stand_among_the_numbers() -> None:
    time, angle = steady()
    rate = 33.3 * RPM
    wave = 3e-3 * rate / (2 * np.pi * 1.3) * np.sin(2 * np.pi * 1.3 * time)
    speeding = 0.5 * 1e-4 / 60 * rate * time**2  # by 100 ppm per minute
    uneven = phase_track(time, angle + wave, noise_rad=1e-5, seed=1)
    facts = dict(rate_view(measure_setting("slow", [uneven], Timebase())).facts)
    assert facts["wow and flutter, unweighted"].startswith("± 0.301 % (two sigma)")
    faster = phase_track(time, angle + speeding, noise_rad=1e-4, seed=1)
    facts = dict(rate_view(measure_setting("slow", [faster], Timebase())).facts)
    assert abs(float(facts["drift of the rate"].split()[0]) - 100) < 10
    even = phase_track(time, angle, noise_rad=1e-4, seed=1)
    facts = dict(rate_view(measure_setting("slow", [even], Timebase())).facts)
    assert "mostly noise, which is" in facts["wow and flutter, unweighted"]
    short = phase_track(*steady(seconds=4), noise_rad=1e-4, seed=1)
    facts = dict(rate_view(measure_setting("slow", [short], Timebase())).facts)
    assert "drift of the rate" not in facts


def test_long_clips_are_thinned_and_say_so() -> None:
    track = phase_track(*steady(), noise_rad=1e-4, seed=1)
    view = rate_view(measure_setting("slow", [track], Timebase()))
    drawing = view.figures[0].drawing
    assert drawing.count("h0") <= 500
    assert f"of {len(track.time_s)} frames" in view.figures[0].caption


def test_a_stated_rate_needs_no_pictures(finished: RunSession) -> None:
    outcome = run_stages(load_config(finished.config), RunContext())
    view = rate_view(next(iter(outcome.rates.values())))
    assert (view.frame, view.figures) == ("", ())
    assert "not measured from a clip" in view.verdict.text


def test_a_probability_that_a_class_shares_is_not_told_as_that_of_each(outcome: Outcome) -> None:
    result = outcome.triad("gyroscope")
    assert result is not None
    one, other, alone = [c.name for c in result.diagnosis.ranking if c.kind == "listed"][:3]
    shared = replace(result.diagnosis, inclusion=(Inclusion(one, (one, other), 0.9, "listed"),))
    told = {row["name"]: row["probability"] for row in candidate_rows(
        replace(result, diagnosis=shared))}
    assert told[one].startswith("one of 2: ")
    assert told[other].startswith("one of 2: ")
    assert "one of" not in told[alone]


def test_a_size_that_no_part_has_is_told_in_words(outcome: Outcome) -> None:
    result = outcome.triad("gyroscope")
    assert result is not None
    first = next(c for c in result.diagnosis.ranking if c.name == "scale_drift")
    sizes = []
    for size in (1e-9, 1e3):  # of itself per second
        one = replace(first, size=np.array([size]), sd=np.array([0.3 * size]))
        (row,) = candidate_rows(
            replace(result, diagnosis=replace(result.diagnosis, ranking=(one,))))
        sizes.append(row["size"])
    assert "±" in sizes[0]
    assert sizes[1] == "larger than any part has"


def test_a_limit_that_no_part_reaches_is_not_listed(outcome: Outcome) -> None:
    result = outcome.triad("accelerometer")
    diagnosis = result.diagnosis
    one = next(each for each in diagnosis.ranking if each.name == "cubic")
    vague = tuple(replace(one, sd=1e9 * one.sd) if each is one else each
                  for each in diagnosis.ranking)
    listed = dict(limit_rows(result))
    kept = dict(limit_rows(replace(result, diagnosis=replace(diagnosis, ranking=vague))))
    assert listed.keys() - kept.keys() == {"cubic"}


def test_what_the_unseen_hardly_moves_is_not_said(outcome: Outcome) -> None:
    result = outcome.triad("gyroscope")
    moved = 0.5 * np.array(result.calibration.parameters.sd) * np.array([[1e-10], [1e-12], [1.0]])
    said = unseen_text(replace(result, unseen={"reference_scale": moved}))
    assert "a scale by up to" in said
    assert "bias" not in said
    assert "misalignment" not in said
