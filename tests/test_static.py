"""The whole tree is clean by ruff, and every bench can be begun.

Types are checked by ``python -m mypy``, which ``.ci/run`` does after the tests: in a fresh clone,
which has no cache, it takes 25 s.
"""

import importlib
import subprocess
import sys

import pytest

from tests.paths import ROOT


def test_the_tree_is_clean() -> None:
    said = subprocess.run([sys.executable, "-m", "ruff", "check", "--no-cache", "."], cwd=ROOT,
                          capture_output=True, text=True, check=False)
    assert said.returncode == 0, said.stdout + said.stderr


@pytest.mark.parametrize("bench", sorted(path.stem for path in (ROOT / "tests/bench").glob("*.py")))
def test_every_bench_goes_with_what_it_measures(bench: str) -> None:
    importlib.import_module(f"tests.bench.{bench}")


def test_every_bench_that_is_run_stands_in_the_table() -> None:
    table = (ROOT / "tests/bench/README.md").read_text(encoding="utf-8")
    benches = {path.stem for path in (ROOT / "tests/bench").glob("*.py")
               if "__main__" in path.read_text(encoding="utf-8")}
    assert {name for name in benches if f"`{name}`" not in table} == set()
