"""A session with something hidden, run once, and its page."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from pipeline.config.load import load_config
from pipeline.report.page import report_html
from pipeline.stages.context import RunContext
from pipeline.stages.run import Outcome, run_stages
from tests.world.designs import rich_design
from tests.world.session import simulate
from tests.world.sizes import draw_effect
from tests.world.write import write_session


@dataclass(frozen=True, eq=False)
class HiddenSession:
    """A gyroscope with ``g_sensitivity`` of ``size`` (3, 3), (rad/s)/(m/s²), and its report."""

    outcome: Outcome
    size: np.ndarray
    html: str
    path: Path


@pytest.fixture(scope="session")
def hidden_session(tmp_path_factory: pytest.TempPathFactory) -> HiddenSession:
    """Two speeds, both directions and plate-stopped poses, each short."""
    folder = tmp_path_factory.mktemp("hidden")
    design = rich_design().scaled(seconds=0.3)
    hidden = draw_effect("g_sensitivity", "gyroscope", 25.0, design, 3)
    written = write_session(folder, simulate(design, 3, (hidden,)), film=False)
    outcome = run_stages(load_config(written.config), RunContext())
    html = report_html(outcome, ())
    path = folder / "report.html"
    path.write_text(html, encoding="utf-8")
    return HiddenSession(outcome, hidden.size.reshape(3, 3), html, path)


@pytest.fixture(scope="session")
def both_missing(tmp_path_factory: pytest.TempPathFactory) -> Outcome:
    """A gyroscope that hides a g-sensitivity, an accelerometer that hides a temperature bias."""
    design = rich_design().scaled(seconds=0.3)
    hidden = (
        draw_effect("g_sensitivity", "gyroscope", 25.0, design, 3),
        draw_effect("temperature_bias", "accelerometer", 12.0, design, 3),
    )
    written = write_session(
        tmp_path_factory.mktemp("both"), simulate(design, 3, hidden), film=False)
    return run_stages(load_config(written.config), RunContext())
