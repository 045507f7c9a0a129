"""The session with an effect that no catalogue has."""

import shutil
from pathlib import Path

import pytest

from tests.pipeline.conftest import RunSession
from tests.pipeline.stages.user_physics import PAPER, RICH
from tests.trials import drawn
from tests.world.bench import Design
from tests.world.session import simulate
from tests.world.write import write_session


def damp_session(folder: Path, design: Design) -> Path:
    """A session of that design in the folder; its configuration."""
    hidden = drawn("column_squared:humidity_pct", "gyroscope", 8.0, design, 5)
    assert hidden is not None
    return write_session(folder, simulate(design, 5, (hidden,)), film=False).config


@pytest.fixture(scope="module")
def damp(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two speeds, both directions and the plate stopped, where such an effect gets a name."""
    return damp_session(tmp_path_factory.mktemp("damp"), RICH)


@pytest.fixture(scope="module")
def damp_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The paper's session, where the effect can be fitted; two fifths of the poses."""
    return damp_session(tmp_path_factory.mktemp("damp_once"), PAPER)


@pytest.fixture
def session(finished: RunSession, tmp_path: Path) -> Path:
    """A copy of the session to change, without results; its configuration."""
    folder = tmp_path / "session"
    shutil.copytree(finished.config.parent, folder, ignore=shutil.ignore_patterns("*.run"))
    return folder / finished.config.name
