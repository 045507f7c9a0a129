"""Sessions that are made once per process and copied for every case."""

import shutil
from pathlib import Path

import pytest

from tests.sessions import accelerometer_alone, pipeline, quick_session
from tests.world.designs import rich_design
from tests.world.session import simulate
from tests.world.write import write_session


@pytest.fixture(scope="session")
def prepared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session that was run; never written to."""
    config, _ = quick_session(tmp_path_factory.mktemp("prepared"))
    assert pipeline("run", config) == 0
    return config


@pytest.fixture
def copied(prepared: Path, tmp_path: Path) -> Path:
    """The configuration of a copy to spoil."""
    shutil.copytree(prepared.parent, tmp_path / "session")
    return tmp_path / "session" / prepared.name


@pytest.fixture(scope="session")
def prepared_rich(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session of five runs; never written to."""
    session = simulate(rich_design().scaled(sample_rate=0.2), 2)
    return write_session(tmp_path_factory.mktemp("rich"), session, film=False).config


@pytest.fixture
def rich(prepared_rich: Path, tmp_path: Path) -> Path:
    """The configuration of a copy of it to spoil."""
    shutil.copytree(prepared_rich.parent, tmp_path / "session")
    return tmp_path / "session" / prepared_rich.name


@pytest.fixture(scope="session")
def prepared_alone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session of an accelerometer alone that was run; never written to."""
    config = accelerometer_alone(tmp_path_factory.mktemp("alone"))
    assert pipeline("run", config) == 0
    return config


@pytest.fixture
def alone(prepared_alone: Path, tmp_path: Path) -> Path:
    """The configuration of a copy of it to spoil."""
    shutil.copytree(prepared_alone.parent, tmp_path / "session")
    return tmp_path / "session" / prepared_alone.name
