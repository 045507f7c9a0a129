"""The noise that ``--auto`` adds goes again once effects explain what it stood for."""

from pathlib import Path

import pytest

from calib.effects.catalogue import BASE
from pipeline.config.load import Config, load_config
from pipeline.model_change import change_model, read_target
from pipeline.next_change import is_noise, without_noise
from pipeline.stages.context import RunContext
from pipeline.stages.run import Outcome, run_stages
from tests.trials import drawn
from tests.world.designs import rich_design
from tests.world.session import simulate
from tests.world.write import write_session

pytestmark = pytest.mark.usefixtures("bare_page")

RICH = rich_design().scaled(sample_rate=0.1)


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
