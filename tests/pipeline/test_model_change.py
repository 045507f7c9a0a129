"""Model changes: what is changed, what is refused, and that a refused change leaves the file."""

import re
import shutil
from pathlib import Path

import pytest

from calib.diagnosis.diagnose import Diagnosis
from calib.effects.catalogue import BASE
from calib.errors import CalibrationError, Undetermined
from pipeline.config.load import Config, load_config
from pipeline.errors import ConfigError
from pipeline.model_change import (
    ModelChange,
    change_model,
    edited_config,
    note_on,
    overruled,
    read_target,
    require_addable,
)
from pipeline.next_change import error_falls, next_change
from pipeline.stages.context import RunContext
from pipeline.stages.run import Outcome, run_stages
from tests.sessions import pipeline, results_in
from tests.trials import drawn
from tests.world.bench import Design
from tests.world.designs import paper_design, rich_design
from tests.world.session import simulate
from tests.world.write import write_session

pytestmark = pytest.mark.usefixtures("bare_page")

RICH = rich_design().scaled(sample_rate=0.1)
PAPER = paper_design().scaled(sample_rate=0.1)


def run(config: Config) -> Outcome:
    return run_stages(config, RunContext(config.output_folder))


def never_run(config: Config) -> Outcome:
    raise AssertionError("what is refused must not be run")


def session(folder: Path, design: Design, name: str, size: float, seed: int = 3) -> Path:
    hidden = drawn(name, "gyroscope", size, design, seed)
    assert hidden is not None
    return write_session(folder, simulate(design, seed, (hidden,)), film=False).config


@pytest.fixture(scope="module")
def drifting(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A rich session whose gyro hides a bias drift; copied before it is changed."""
    return session(tmp_path_factory.mktemp("rich"), RICH, "bias_drift", 10.0)


@pytest.fixture(scope="module")
def drift_found(drifting: Path) -> Outcome:
    return run(load_config(drifting))


@pytest.fixture
def copied(drifting: Path, tmp_path: Path) -> Path:
    shutil.copytree(drifting.parent, tmp_path / "session")
    return tmp_path / "session" / drifting.name


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("gyro.cubic", "did you mean 'gyroscope.cubic'"),
        ("gyro.gsens", "did you mean 'gyroscope.g_sensitivity'"),
        ("gyroscope", "Write accelerometer.NAME, gyroscope.NAME"),
        ("rate.slow.once_per_rev", "Write accelerometer.NAME"),
        ("cubic", "as `pipeline diagnose` names them"),
    ],
)
def test_a_target_that_names_nothing_is_answered_with_what_could_be_meant(
    drifting: Path, text: str, says: str
) -> None:
    with pytest.raises(ConfigError, match=says):
        read_target(load_config(drifting), text)


def test_a_target_reads_its_triad_or_its_setting(drifting: Path) -> None:
    config = load_config(drifting)
    triad = read_target(config, "gyroscope.column:supply_v")
    assert (triad.section, triad.name) == (("gyroscope",), "column:supply_v")
    setting = read_target(config, "rate.17rpm.once_per_rev")
    assert (setting.section, setting.name) == (("rate", "17rpm"), "once_per_rev")
    assert setting.default == ("constant_rate",)
    assert str(setting) == "rate.17rpm.once_per_rev"


def test_an_unknown_effect_is_refused_before_anything_runs(copied: Path) -> None:
    config, text = load_config(copied), copied.read_bytes()
    with pytest.raises((ConfigError, CalibrationError), match="quadratc"):
        change_model(config, read_target(config, "gyroscope.quadratc"), never_run)
    assert copied.read_bytes() == text


def test_a_curve_takes_the_place_of_its_straight_line(copied: Path) -> None:
    config = load_config(copied)
    for name in ("temperature_bias", "temperature_bias_curve"):
        config = edited_config(config, read_target(config, f"gyroscope.{name}"), remove=False)
    assert config.gyroscope is not None
    assert config.gyroscope.model == (*BASE, "temperature_bias_curve")


@pytest.mark.parametrize(
    ("name", "remove", "says"), [
        ("bias", False, "is in the model already"),
        ("cubic", True, r"is not in the model, which is \[bias, scale, misalignment\]")])
def test_changes_that_change_nothing_are_refused(
    drifting: Path, name: str, remove: bool, says: str
) -> None:
    config = load_config(drifting)
    with pytest.raises(ConfigError, match=says):
        edited_config(config, read_target(config, f"gyroscope.{name}"), remove)


def test_the_last_effect_cannot_be_taken_out(copied: Path) -> None:
    text = copied.read_text(encoding="utf-8").replace("[bias, scale, misalignment]", "[bias]")
    copied.write_text(text, encoding="utf-8")
    config = load_config(copied)
    with pytest.raises(ConfigError, match="all that the model has"):
        edited_config(config, read_target(config, "gyroscope.bias"), remove=True)


def test_a_change_knows_both_sides_leaves_the_file_alone_and_lowers_the_error_one_way_only(
    copied: Path
) -> None:
    config = load_config(copied)
    seen: list[str] = []

    def watched(asked: Config) -> Outcome:
        seen.append(copied.read_text(encoding="utf-8"))
        return run(asked)

    change = change_model(config, read_target(config, "gyroscope.bias_drift"), watched)
    assert seen == [config.source.text] * 2
    assert copied.read_text(encoding="utf-8") == config.source.text
    assert "bias_drift" in change.after.config.source.text
    assert change.before.triad("gyroscope") is not None
    assert change.after.triad("gyroscope") is not None
    before, after = (run.triad("gyroscope").calibration.fit
                     for run in (change.before, change.after))
    assert after.chi2 / after.dof < 1.4 < before.chi2 / before.dof
    assert after.model.names == (*before.model.names, "bias_drift")
    assert error_falls(change)
    assert not error_falls(
        ModelChange(change.target, before=change.after, after=change.before))


def test_a_change_that_fails_leaves_the_file_as_it_was(copied: Path, drift_found: Outcome) -> None:
    config, text = load_config(copied), copied.read_bytes()

    def fails(asked: Config) -> Outcome:
        raise Undetermined("these poses do not determine it")

    with pytest.raises(Undetermined, match="do not determine"):
        change_model(config, read_target(config, "gyroscope.bias_drift"), fails, before=drift_found)
    assert copied.read_bytes() == text


def test_what_is_named_without_doubt_is_added_next_and_not_tried_again_in_vain(
    drift_found: Outcome
) -> None:
    (change,) = next_change(drift_found, run)
    assert str(change.target) == "gyroscope.bias_drift"
    assert not next_change(drift_found, never_run, refused=[change.target])


def test_a_blind_effect_is_refused_with_its_reason(drift_found: Outcome, drifting: Path) -> None:
    assert drift_found.triad("gyroscope") is not None
    config = load_config(drifting)
    target = read_target(config, "gyroscope.frame_rotation")
    with pytest.raises(Undetermined, match=r"these data cannot see it.*What would allow it"):
        require_addable(drift_found.triad("gyroscope"), target, anyway=True)


def test_any_member_of_a_named_class_is_added_with_a_note(tmp_path: Path) -> None:
    config = load_config(session(tmp_path, PAPER, "quadratic", 12.0))
    before = run(config)
    assert before.triad("gyroscope") is not None
    named = before.triad("gyroscope").diagnosis.named_class("asymmetry")
    assert {"quadratic", "asymmetry"} <= set(named)
    for member in ("quadratic", "asymmetry"):
        target = read_target(config, f"gyroscope.{member}")
        change = change_model(config, target, run, before=before)
        assert error_falls(change)
        for other in set(named) - {member}:
            assert f"'{other}'" in note_on(change)
        assert "What would allow it: record" not in note_on(change)
        assert "record" in note_on(change)


def test_auto_adds_a_stand_in_for_a_class_that_corrects_alike(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A drift and a slow warm-up look the same here, and correct other attitudes alike."""
    path = session(tmp_path, PAPER, "bias_drift", 8.0)
    before = run(load_config(path)).triad("gyroscope")
    assert before is not None
    found = before.diagnosis
    assert found.name is not None
    assert not found.addable
    others = found.named_class(found.name)[1:]
    assert pipeline("add", path, "--auto") == 0
    capsys.readouterr()
    remark = f"{found.name} stands for its class: {', '.join(others)}"
    assert path.read_text(encoding="utf-8").count(f"# {remark}") == 1
    after = results_in(path.with_suffix(".run"))["gyroscope"]
    assert found.name in after["model"]
    assert after["loo_rms"] < before.comparison.loo_rms
    history = (path.with_suffix(".run") / "history.jsonl").read_text(encoding="utf-8")
    assert len(history.splitlines()) == 2
    mark = f"{found.name} of the gyroscope stands for its class: the poses do not tell it from "
    for form in ("python", "kalibr", "px4", "csv", "imu_tk"):
        assert pipeline("export", path.with_suffix(".run"), "--to", form) == 0
        shown = capsys.readouterr()
        assert mark in shown.err
        assert set(others) <= set(re.findall(r"\w+", shown.err))
        if form not in ("csv", "imu_tk"):
            assert mark in Path(shown.out.split("\n")[0]).read_text(encoding="utf-8")


def test_the_history_begins_with_the_model_before_the_first_change(copied: Path) -> None:
    shutil.rmtree(copied.with_suffix(".run"), ignore_errors=True)
    assert pipeline("add", copied, "gyroscope.bias_drift", "--quiet") == 0
    history = (copied.with_suffix(".run") / "history.jsonl").read_text(encoding="utf-8")
    assert [("bias_drift" in line) for line in history.splitlines()][-1]
    assert len(history.splitlines()) == 2


def test_a_guess_and_a_step_that_noise_alone_suggests_are_refused(tmp_path: Path) -> None:
    """The fit chooses the moment, so that the error of poses that were left out falls by chance."""
    config = load_config(write_session(tmp_path, simulate(PAPER, 513), film=False).config)
    found = run(config)
    with pytest.raises(Undetermined, match=r"looks the same as .*'asymmetry'.* --anyway"):
        change_model(config, read_target(config, "gyroscope.quadratic"), never_run, before=found)
    target = read_target(config, "accelerometer.bias_step")
    with pytest.raises(Undetermined, match=r"do not show it: the odds are \S+ : 1 .*--anyway"):
        change_model(config, target, never_run, before=found)
    change = change_model(config, target, run, before=found, anyway=True)
    results = [each.triad("accelerometer") for each in (change.before, change.after)]
    assert results[0] is not None
    assert results[1] is not None
    assert results[1].comparison.predicts_better_than(results[0].comparison)
    assert overruled(change).endswith("against it.")


def test_an_effect_that_predicts_no_better_is_refused_and_may_still_be_tried(
    drifting: Path, drift_found: Outcome, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = load_config(drifting)
    target = read_target(config, "gyroscope.cubic")
    with monkeypatch.context() as no_odds:
        no_odds.setattr(Diagnosis, "is_guess", lambda *_: False)
        with pytest.raises(Undetermined, match=r"no better with it: .* would be .*--anyway"):
            change_model(config, target, run, before=drift_found)
    change = change_model(config, target, run, before=drift_found, anyway=True)
    assert change.after.triad("gyroscope") is not None
    assert "cubic" in change.after.triad("gyroscope").calibration.fit.model.names
    # It does not help, and what is missing is still named.
    assert change.after.triad("gyroscope").diagnosis.name == "bias_drift"


def test_one_effect_or_auto_must_be_asked_for(
    drifting: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("add", drifting) == 2
    assert "--auto" in capsys.readouterr().err
    assert pipeline("add", drifting, "gyroscope.cubic", "--auto") == 2


def test_several_effects_are_added_and_removed_in_one_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = session(tmp_path, PAPER, "quadratic", 12.0)
    before = path.read_text(encoding="utf-8")
    both = ("gyroscope.quadratic", "accelerometer.cubic")
    assert pipeline("add", path, *both) == 4  # the second is not seen: neither is added
    assert "was not changed: accelerometer.cubic is refused" in capsys.readouterr().err
    assert path.read_text(encoding="utf-8") == before
    assert pipeline("add", path, *both, "--anyway") == 0
    model = load_config(path)
    assert model.gyroscope is not None
    assert model.accelerometer is not None
    assert "quadratic" in model.gyroscope.model
    assert "cubic" in model.accelerometer.model
    assert pipeline("remove", path, *both) == 0
    assert path.read_text(encoding="utf-8") == before
