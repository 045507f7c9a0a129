"""One calibrated session per process, copied for every case."""

import shutil
from pathlib import Path

import pytest

from tests.sessions import pipeline, quick_session


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
