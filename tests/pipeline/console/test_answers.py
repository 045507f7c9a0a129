"""The terminal and the report say the same: one source for verdicts, headline and next command."""

import re
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calib.diagnosis.next_measurement.advice import DIRECTIONS, Advice
from calib.diagnosis.search.entry import Inclusion
from calib.diagnosis.verdict.decision import Code
from calib.effects.effect import Effect
from calib.poses.attitudes import natural_directions
from calib.poses.reference import PlateRate
from pipeline.config.load import load_config
from pipeline.console.answers import RATES, answers_of, headline
from pipeline.console.next_step import next_line, next_lines
from pipeline.console.rate_text import rate_line, rate_verdict
from pipeline.console.run_text import leading_covariate, pose_change_lines
from pipeline.stages.context import RunContext
from pipeline.stages.rate import SettingRate
from pipeline.stages.run import Outcome, run_stages
from pipeline.stages.triads import TriadResult
from tests.paths import DATA
from tests.pipeline.report.html_page import Page
from tests.sessions import pipeline
from tests.world.designs import rich_design
from tests.world.session import simulate
from tests.world.sizes import draw_effect
from tests.world.write import write_session


@pytest.mark.parametrize("turns", ["cw", None])
def test_a_stated_rate_is_printed_with_its_direction(turns: str | None) -> None:
    plate = PlateRate("back", np.full(1, 3.49), np.full(1, 1e-4), direction=turns)
    back = SettingRate("back", plate, (), ())
    shown = f"ppm, {f'{turns}, ' if turns else ''}stated in the configuration"
    assert rate_line(back).endswith(shown)
    assert repr(back).endswith(f" rpm{f', {turns}' if turns else ''})")


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example's configuration with a rate model that lacks the waves of the plate."""
    folder = tmp_path_factory.mktemp("plain") / "example"
    shutil.copytree(DATA / "example", folder, ignore=shutil.ignore_patterns("*.run"))
    config = folder / "config.yaml"
    text = re.sub(r" *model: \[constant_rate.*\n", "", config.read_text(encoding="utf-8"))
    config.write_text(text, encoding="utf-8")
    return config


def test_a_missing_term_of_a_clip_is_said_everywhere_with_the_same_command(
    plain: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("run", plain) == 0
    printed = capsys.readouterr().out
    command = f"pipeline add {plain} rate.17rpm.once_per_rev"
    assert "rate.17rpm: once_per_rev is missing" in printed
    assert f"next: {command}" in printed
    html = (plain.with_suffix(".run") / "report.html").read_text(encoding="utf-8")
    page = Page(html)
    cards = re.findall(r'-sign" aria-hidden="true">[^<]*</span><a href="#(\w+)">', html)
    assert cards == ["accelerometer", "gyroscope", "rates"]  # in the order of the headline
    assert "The rate model of 17rpm lacks once_per_rev." in page.text
    assert command in page.text
    assert "The stated rates do not depend on it" in page.text
    assert pipeline("diagnose", plain) == 0
    assert "rate.17rpm: once_per_rev is missing" in capsys.readouterr().out


def test_the_rate_is_the_same_with_and_without_the_term(plain: Path) -> None:
    context = RunContext(plain.with_suffix(".run") / "cache")
    without = run_stages(load_config(plain), context).rates["17rpm"]
    assert rate_verdict(without).in_the_rate
    whole = DATA / "example" / "config.yaml"
    stated = run_stages(load_config(whole), context).rates["17rpm"]
    assert stated.rate_rad_s == without.rate_rad_s
    assert stated.sd_rad_s == without.sd_rad_s
    assert rate_verdict(stated).complete


@pytest.fixture(scope="module")
def caused(tmp_path_factory: pytest.TempPathFactory) -> Outcome:
    """A gyroscope that follows the supply voltage, an accelerometer that lacks nothing."""
    folder = tmp_path_factory.mktemp("caused")
    design = rich_design().scaled(seconds=0.3, sample_rate=0.5)
    hidden = draw_effect("column:supply_v", "gyroscope", 20.0, design, 8)
    written = write_session(folder, simulate(design, 8, (hidden,)), film=False)
    return run_stages(load_config(written.config), RunContext())


def test_what_no_calibration_takes_away_ends_in_the_measurement_that_leaves_less(
    caused: Outcome,
) -> None:
    result = caused.triad("gyroscope")
    assert result is not None
    words = replace(result.diagnosis.explanation, step="record",
                    following="Film the plate with each pose")
    noise = replace(result.diagnosis, verdict=Code.NOISE, advice=None, explanation=words)
    outcome = replace(caused, triads=tuple(
        replace(each, diagnosis=noise) if each is result else each for each in caused.triads))
    config = caused.config.source.path
    assert next_line(outcome, Path("out")) == (
        f"next: film the plate with each pose; name the clips in the configuration, then: "
        f"pipeline run {config}")


def test_what_both_triads_ask_to_record_stands_in_one_line(caused: Outcome) -> None:
    def asks(number: int, result: TriadResult) -> TriadResult:
        words = replace(result.diagnosis.explanation, step="record", standing="open",
                        following=f"Record block {number} (1 min)")
        return replace(result, diagnosis=replace(result.diagnosis, explanation=words))

    outcome = replace(caused, triads=tuple(map(asks, (1, 2), caused.triads)))
    assert next_line(outcome, Path("out")).startswith(
        "next: for the accelerometer record block 1 (1 min); for the gyroscope record block 2 "
        "(1 min); then bring the new logs into the session: pipeline import LOGS --into ")


def test_before_apply_is_said_what_another_log_does_not_tell(
    caused: Outcome, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def note(triad: str, effects: Sequence[Effect], by_untold: Mapping[str, float]) -> list[str]:
        assert "bias" in [effect.name for effect in effects]
        return [f"{triad}: left out"]

    monkeypatch.setattr("pipeline.console.answers.untold_notes", note)
    assert len(next_line(caused, Path("out")).splitlines()) == 1
    settled = replace(caused, triads=tuple(
        replace(each, diagnosis=replace(each.diagnosis, explanation=replace(
            each.diagnosis.explanation, step="apply", standing="good")))
        for each in caused.triads))
    # `diagnose` writes no results that could be applied.
    assert next_line(settled, tmp_path) == f"next: pipeline run {caused.config.source.path}"
    (tmp_path / "results.json").touch()
    assert next_line(settled, tmp_path).splitlines() == [
        "accelerometer: left out", "gyroscope: left out",
        f"next: pipeline apply {tmp_path} LOG --output FILE"]
    monkeypatch.chdir(tmp_path)
    Path("-c").mkdir()
    Path("-c/results.json").touch()
    assert next_line(settled, Path("-c")).endswith("pipeline apply ./-c LOG --output FILE")


def test_what_is_missing_may_follow_a_column_that_was_not_looked_at(caused: Outcome) -> None:
    (result,) = [each for each in caused.triads if each.diagnosis.explanation.standing != "good"]
    beside = replace(caused, triads=tuple(
        replace(each, diagnosis=replace(each.diagnosis, aside=("mag_x", "mag_y")))
        for each in caused.triads))
    note, line = next_lines(beside, Path("out"))
    assert note.startswith(f"{result.triad}: logged columns that the diagnosis does not use")
    assert "`covariates: [mag_x, mag_y]`" in note
    assert [line] == [*next_lines(caused, Path("out"))]
    chosen = beside.config.model_copy(update={"covariates": ("temperature_c",)})
    assert [line] == [*next_lines(replace(beside, config=chosen), Path("out"))]
    complete = replace(beside, triads=tuple(  # one whose gyroscope never turned is not "good"
        replace(each, diagnosis=replace(each.diagnosis, verdict=Code.NOTHING_MISSING))
        for each in beside.triads))
    assert len([*next_lines(complete, Path("out"))]) == 1


@pytest.mark.parametrize(("verdict", "notes"), [(Code.NOISE, 1), (Code.UNKNOWN, 1),
                                                (Code.EFFECT, 0)])
def test_poses_of_another_day_are_told_from_an_effect(
    caused: Outcome, verdict: Code, notes: int
) -> None:
    result = caused.triads[1]
    fewer = replace(result.comparison, poses=result.comparison.poses[1:])
    before, after = (replace(caused, triads=(replace(
        result, comparison=comparison, diagnosis=replace(result.diagnosis, verdict=code)),))
        for comparison, code in ((fewer, Code.NOTHING_MISSING), (result.comparison, verdict)))
    said = " ".join(pose_change_lines(before, after))
    assert said.count("poses of another time are a session of their own") == notes


@pytest.mark.parametrize(("likely", "offered"), [
    (0.4, "temperature_bias"), (0.1, "warm_up")], ids=["nearly as likely", "nine times less"])
def test_of_causes_that_look_the_same_the_one_that_a_log_tells_is_offered_if_it_is_believed(
    caused: Outcome, likely: float, offered: str
) -> None:
    result = caused.triad("gyroscope")
    assert result is not None
    alike = ("warm_up", "temperature_bias")
    words = replace(result.diagnosis.explanation, step="add")
    open_still = replace(
        result.diagnosis, name="warm_up", names=("warm_up",), group=alike, explanation=words,
        inclusion=(Inclusion("warm_up", alike, 1.0, "listed"),),
        sets=((("warm_up",), 1 - likely), (("temperature_bias",), likely)))
    outcome = replace(caused, triads=tuple(
        replace(each, diagnosis=open_still) if each is result else each for each in caused.triads))
    config = caused.config.source.path
    assert next_line(outcome, Path("out")) == f"next: pipeline add {config} gyroscope.{offered}"


def test_a_step_in_time_is_first_compared_with_what_was_logged(caused: Outcome) -> None:
    (result,) = [each for each in caused.triads if each.triad == "gyroscope"]
    words = replace(result.diagnosis.explanation, step="add", following="Add it")
    step = replace(result, diagnosis=replace(
        result.diagnosis, verdict=Code.EFFECT, name="bias_step", names=("bias_step",),
        explanation=words))
    answer = next(each for each in answers_of(replace(caused, triads=(step,)), "config.run")
                  if each.subject == "gyroscope")
    assert "whether the error rather follows a logged column" in answer.next
    assert [each.split()[1] for each in answer.commands] == ["discover", "add"]


def test_the_worst_comes_first_and_its_command_is_the_next_line(caused: Outcome) -> None:
    first, second = answers_of(caused, "out")
    assert (first.subject, second.subject) == ("gyroscope", "accelerometer")
    assert first.standing == "act"
    assert RATES not in (first.subject, second.subject)
    (command,) = first.commands
    assert next_line(caused, Path("out")) == f"next: {command}"
    assert first.short in headline((first, second)).text


def test_the_misfit_follows_the_cause_and_no_by_product(caused: Outcome) -> None:
    followed = {result.triad: leading_covariate(result) for result in caused.triads}
    assert followed == {"accelerometer": None, "gyroscope": "supply_v"}


def test_an_effect_that_follows_no_covariate_has_none(tmp_path: Path) -> None:
    design = rich_design().scaled(seconds=0.3, sample_rate=0.5)
    hidden = draw_effect("g_sensitivity", "gyroscope", 25.0, design, 3)
    written = write_session(tmp_path, simulate(design, 3, (hidden,)), film=False)
    outcome = run_stages(load_config(written.config), RunContext())
    assert outcome.triad("gyroscope") is not None
    assert outcome.triad("gyroscope").diagnosis.name == "g_sensitivity"
    assert leading_covariate(outcome.triad("gyroscope")) is None


def test_a_session_without_a_latitude_is_told_that_gravity_is_most_of_the_error(
    plain: Path, tmp_path: Path
) -> None:
    folder = shutil.copytree(plain.parent, tmp_path / "anywhere")
    text = plain.read_text(encoding="utf-8")
    told = []
    for site in ("{gravity_m_s2: 9.8067, sd_m_s2: 0.02}", "{latitude_deg: 40.85, height_m: 20}"):
        (folder / "config.yaml").write_text(
            re.sub(r"(?m)^site:.*\n(?: .*\n)*", f"site: {site}\n", text), encoding="utf-8")
        outcome = run_stages(load_config(folder / "config.yaml"),
                             RunContext(plain.with_suffix(".run") / "cache"))
        told.append(next(answer for answer in answers_of(outcome, "config.run")
                         if answer.subject == "accelerometer").good)
    assert "Most of that is gravity, which is known to 20 mm/s²: state your latitude" in told[0]
    assert "gravity" not in told[1]


def test_attitudes_that_both_triads_lack_are_one_list_where_the_same_poses_serve_both(
    caused: Outcome,
) -> None:
    def lacks(places: Sequence[int], result: TriadResult) -> TriadResult:
        wanted = tuple(natural_directions()[i] for i in places)
        assert result.prediction is not None
        advice = Advice(DIRECTIONS, "poses", 1.0)
        words = replace(result.diagnosis.explanation, step="record", standing="open",
                        following=f"Record {places} (1 min)")
        return replace(result, prediction=replace(result.prediction, wanted=wanted),
                       diagnosis=replace(result.diagnosis, advice=advice, explanation=words))

    rest = caused.config.accelerometer.at_rest
    alike = caused.config.gyroscope.model_copy(update={"runs": rest})
    outcome = replace(caused, triads=tuple(map(lacks, ((0, 1), (1, 2)), caused.triads)))
    one = next_line(replace(outcome, config=caused.config.model_copy(
        update={"gyroscope": alike})), Path("out"))
    assert one.startswith("next: record poses with -x up, -y up, -z up (2 min), for both triads; ")
    assert "for the accelerometer record" in next_line(outcome, Path("out"))


def test_a_residual_over_noise_is_one_number_beside_its_chi_square(caused: Outcome) -> None:
    result = caused.triad("gyroscope")
    assert result is not None
    fit = result.calibration.fit
    answer = next(each for each in answers_of(caused, "r") if each.subject == "gyroscope")
    said = re.search(r"(\S+) times what their own noise leaves", answer.good)
    assert said is not None
    assert float(said[1]) == pytest.approx((fit.chi2 / fit.dof) ** 0.5, rel=0.06)
