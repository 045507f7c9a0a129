"""What ``--auto`` adds next: what is named together, one of a class; a noise goes again."""

from pathlib import Path

import pytest

from calib.effects.catalogue import BASE
from calib.errors import Undetermined
from pipeline.config.load import Config, load_config
from pipeline.model_change import change_model, read_target
from pipeline.next_change import error_falls, is_noise, next_change, whole, without_noise
from pipeline.stages.context import RunContext
from pipeline.stages.run import Outcome, run_stages
from tests.trials import drawn
from tests.world.bench import Design
from tests.world.designs import paper_design, rich_design
from tests.world.session import simulate
from tests.world.write import write_session

pytestmark = pytest.mark.usefixtures("bare_page")

RICH = rich_design().scaled(sample_rate=0.1)
PAPER = paper_design().scaled(sample_rate=0.1)


class Runs:
    """Runs of one session with other models, whose logs are read once, as in the command."""

    latest: Outcome | None = None

    def __call__(self, config: Config) -> Outcome:
        self.latest = run_stages(config, RunContext(config.output_folder), before=self.latest)
        return self.latest


@pytest.mark.parametrize(
    ("name", "size", "model", "goes"),
    [
        ("bias_drift", 10.0, ("bias_wander",), True),  # the drift is next to come into the model
        ("bias_drift", 10.0, ("bias_drift", "bias_wander"), True),  # nothing is missing without
        ("wander", 20.0, ("bias_wander",), False),
    ],
)
def test_a_noise_goes_where_an_effect_explains_what_it_stood_for(
    tmp_path: Path, name: str, size: float, model: tuple[str, ...], goes: bool
) -> None:
    hidden = drawn(name, "gyroscope", size, RICH, 4)
    assert hidden is not None
    path = write_session(tmp_path, simulate(RICH, 4, (hidden,)), film=False).config
    config, run = load_config(path), Runs()
    for each in model:
        target = read_target(config, f"gyroscope.{each}")
        change = change_model(config, target, run, anyway=True)
        assert is_noise(change) == (each == "bias_wander")
        config = change.after.config
    after = without_noise(change.after, target, run)
    assert (after is not None) == goes
    if after is not None:
        result = after.triad("gyroscope")
        assert result is not None
        assert result.calibration.fit.model.names == (*BASE, *model[:-1])


def hiding(
    folder: Path, design: Design, triad: str, *effects: tuple[str, float], seed: int
) -> Config:
    hidden = tuple(drawn(name, triad, size, design, seed) for name, size in effects)
    assert None not in hidden
    return load_config(write_session(folder, simulate(design, seed, hidden), film=False).config)


def test_effects_that_are_named_together_are_added_together(tmp_path: Path) -> None:
    config = hiding(tmp_path, RICH, "gyroscope", ("bias_drift", 20.0), ("quadratic", 20.0), seed=4)
    run = Runs()
    before = run(config)
    changes = next_change(before, run)
    assert {each.target.name for each in changes} == {"bias_drift", "quadratic"}
    assert changes[1].before is changes[0].after
    assert whole(changes).before is before
    assert error_falls(whole(changes))
    after = whole(changes).after.triad("gyroscope")
    assert after is not None
    assert after.diagnosis.verdict == "nothing_missing"


def test_a_member_of_a_class_that_these_poses_cannot_determine_does_not_keep_out_the_others(
    tmp_path: Path,
) -> None:
    """A curve of nine parameters looks like a line, and passes through all of 18 poses."""
    config = hiding(tmp_path, PAPER, "accelerometer", ("temperature_bias", 30.0), seed=2)
    run = Runs()
    before = run(config)
    result = before.triad("accelerometer")
    assert result is not None
    assert result.diagnosis.group == ("temperature_bias", "warm_up")

    def without_warm_up(config: Config) -> Outcome:
        if config.accelerometer is not None and "warm_up" in config.accelerometer.model:
            raise Undetermined("as many parameters as equations")
        return run(config)

    (change,) = next_change(before, without_warm_up)
    assert str(change.target) == "accelerometer.temperature_bias"


def test_a_plate_that_slows_or_a_gain_that_drifts_is_a_question_and_no_guess(
    tmp_path: Path,
) -> None:
    """One is the sensor's and goes with it, the other stays on the bench."""
    config = hiding(tmp_path, PAPER, "gyroscope", ("reference_drift", 30.0), seed=2)
    run = Runs()
    before = run(config)
    result = before.triad("gyroscope")
    assert result is not None
    assert {*result.diagnosis.group} == {"reference_drift", "scale_drift"}
    assert not next_change(before, run)
