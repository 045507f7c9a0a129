"""A session with something hidden, run once, and its page."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from pipeline.config.load import load_config
from pipeline.report.page import report_html
from pipeline.stages.context import RunContext
from pipeline.stages.run import Outcome, run_stages
from tests.pipeline.report.tab import Browser, started_browser
from tests.world.designs import rich_design
from tests.world.session import simulate
from tests.world.sizes import draw_effect
from tests.world.write import write_session


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """One browser for all tests; each opens a tab of its own."""
    with started_browser(tmp_path_factory.mktemp("browser")) as browser:
        yield browser


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
