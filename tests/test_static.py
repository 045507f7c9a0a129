"""The whole tree is clean by ruff and by mypy in strict mode."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.mark.parametrize(
    "checker",
    [["ruff", "check", "--no-cache", "."], ["mypy", "--cache-dir=/dev/null"]],
    ids=["ruff", "mypy"],
)
def test_the_tree_is_clean(checker: list[str]) -> None:
    said = subprocess.run(
        [sys.executable, "-m", *checker], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert said.returncode == 0, said.stdout + said.stderr
