"""One session on disk, run once, that the tests of this folder look at from all sides; one browser.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.pipeline.report.tab import Browser, started_browser
from tests.sessions import pipeline, quick_session
from tests.world.session import Session


@dataclass(frozen=True, eq=False)
class RunSession:
    """A session that was run: its configuration, its results' folder, its truth."""

    config: Path
    folder: Path
    truth: Session


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> RunSession:
    """Never written to: tests that change something copy it."""
    config, truth = quick_session(tmp_path_factory.mktemp("session"))
    assert pipeline("run", config) == 0
    return RunSession(config, config.with_suffix(".run"), truth)


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """One browser for all tests; each opens a tab of its own."""
    with started_browser(tmp_path_factory.mktemp("browser")) as browser:
        yield browser
