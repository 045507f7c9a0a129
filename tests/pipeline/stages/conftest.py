"""The session with an effect that no catalogue has."""

import shutil
from pathlib import Path

import pytest

from tests.pipeline.conftest import RunSession
from tests.pipeline.stages.user_physics import RICH
from tests.trials import drawn
from tests.world.session import simulate
from tests.world.write import write_session


@pytest.fixture(scope="module")
def damp(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session with an effect that no catalogue has."""
    hidden = drawn("column_squared:humidity_pct", "gyroscope", 8.0, RICH, 5)
    assert hidden is not None
    folder = tmp_path_factory.mktemp("damp")
    return write_session(folder, simulate(RICH, 5, (hidden,)), film=False).config


@pytest.fixture
def session(finished: RunSession, tmp_path: Path) -> Path:
    """A copy of the session to change, without results; its configuration."""
    folder = tmp_path / "session"
    shutil.copytree(finished.config.parent, folder, ignore=shutil.ignore_patterns("*.run"))
    return folder / finished.config.name
