"""The whole tree is clean by ruff and by mypy in strict mode, and every bench can be begun."""

import importlib
import subprocess
import sys

import pytest

from tests.paths import ROOT


@pytest.mark.parametrize(
    "checker",
    [["ruff", "check", "--no-cache", "."], ["mypy"]],
    ids=["ruff", "mypy"],
)
def test_the_tree_is_clean(checker: list[str]) -> None:
    said = subprocess.run(
        [sys.executable, "-m", *checker], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert said.returncode == 0, said.stdout + said.stderr


@pytest.mark.parametrize("bench", sorted(path.stem for path in (ROOT / "tests/bench").glob("*.py")))
def test_every_bench_goes_with_what_it_measures(bench: str) -> None:
    importlib.import_module(f"tests.bench.{bench}")


def test_every_bench_that_is_run_stands_in_the_table() -> None:
    table = (ROOT / "tests/bench/README.md").read_text(encoding="utf-8")
    benches = {path.stem for path in (ROOT / "tests/bench").glob("*.py")
               if "__main__" in path.read_text(encoding="utf-8")}
    assert {name for name in benches if f"`{name}`" not in table} == set()
