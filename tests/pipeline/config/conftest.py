"""A folder with the files that the complete configuration names."""

from pathlib import Path

import pytest


@pytest.fixture
def session(tmp_path: Path) -> Path:
    """A folder with the files that ``GOOD`` names."""
    for name in ("clip.mp4", "acc/pose_1.csv", "acc/pose_2.csv", "acc/pose_10.csv",
                 "gyr/a.csv", "gyr/b.csv", "run/a.csv", "run/b.csv", "long/a.csv",
                 "long/b.csv"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.touch()
    return tmp_path
