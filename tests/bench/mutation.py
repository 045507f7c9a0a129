"""The share of small faults, put into a module one at a time, that its tests notice.

    python -m tests.bench.mutation --each 12 [--module calib.consistency.force]

A mutant has one comparison turned around, one sum made a difference, one product a quotient, one
condition negated, or one number changed by a tenth and one. It lives in the memory of the process
that runs the tests of the module; no file is changed. Drawn by a seed are so many of each module.
"""

import argparse
import ast
import importlib.abc
import importlib.machinery
import importlib.util
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import CodeType

import numpy as np

from tests.paths import ROOT

TESTED = {
    "calib.consistency.certificate": "tests/calib/consistency/test_certificate.py",
    "calib.consistency.clock": "tests/calib/consistency/test_clock.py",
    "calib.consistency.clock_ratio": "tests/calib/consistency/test_clock_ratio.py",
    "calib.consistency.common_mistakes": "tests/calib/consistency/test_mistakes.py",
    "calib.consistency.data_sheet": "tests/calib/consistency/test_data_sheet.py",
    "calib.consistency.force": "tests/calib/consistency/test_force.py",
    "calib.consistency.mistakes": "tests/calib/consistency/test_mistakes.py",
    "calib.consistency.plate_axes": "tests/calib/consistency/test_plate_axes.py",
    "calib.fit.validation.odd_poses": "tests/calib/fit/validation/test_odd_poses.py",
    "calib.consistency.raw_samples": "tests/calib/consistency",
    "calib.consistency.repeats": "tests/calib/consistency/test_repeats.py",
    "calib.consistency.signed_axes": "tests/calib/consistency/test_plate_axes.py",
    "pipeline.files": "tests/pipeline/test_files.py",
}
#: What is put in place of an operator.
OTHERS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.And: ast.Or, ast.Or: ast.And, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd,
}
LONGEST_S = 120  #: of a mutant's tests; one that hangs is noticed


def places(tree: ast.Module) -> Iterator[tuple[ast.AST, str]]:
    """What can be changed, with the name of the field; not in messages and annotations."""
    skipped = {id(inner) for node in ast.walk(tree) if isinstance(node, ast.Raise | ast.arg)
               for inner in ast.walk(node)}
    skipped |= {id(inner) for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)
                and node.returns is not None for inner in ast.walk(node.returns)}
    for node in ast.walk(tree):
        if id(node) in skipped:
            continue
        if isinstance(node, ast.BinOp | ast.BoolOp) and type(node.op) in OTHERS:
            yield node, "op"
        elif isinstance(node, ast.Compare) and type(node.ops[0]) in OTHERS:
            yield node, "ops"
        elif isinstance(node, ast.Constant) and type(node.value) in (int, float):
            yield node, "value"


def mutated(tree: ast.Module, number: int) -> str:
    """Change the place ``number`` of ``tree``; the change in words."""
    node, field = list(places(tree))[number]
    before = ast.unparse(node)
    if field == "value":
        node.value = node.value * 1.1 + 1 if isinstance(node.value, float) else node.value + 1  # type: ignore[attr-defined]
    elif field == "op":
        node.op = OTHERS[type(node.op)]()  # type: ignore[attr-defined]
    else:
        node.ops[0] = OTHERS[type(node.ops[0])]()  # type: ignore[attr-defined]
    return f"line {node.lineno}: {before}  ->  {ast.unparse(node)}"  # type: ignore[attr-defined]


class Loader(importlib.machinery.SourceFileLoader):
    """The loader of one module, with one change."""

    number = -1

    def get_code(self, fullname: str) -> CodeType:
        """The code of the mutant; nothing is cached."""
        tree = ast.parse(Path(self.path).read_text(encoding="utf-8"))
        mutated(tree, self.number)
        return compile(ast.fix_missing_locations(tree), self.path, "exec")


class Finder(importlib.abc.MetaPathFinder):
    """Finds the one module that is changed."""

    def __init__(self, module: str, number: int) -> None:
        self._module, self._number = module, number

    def find_spec(self, name: str, _path: object, _target: object = None) -> (
            importlib.machinery.ModuleSpec | None):
        """The specification of the module; None for every other one."""
        if name != self._module:
            return None
        loader = Loader(name, str(path_of(name)))
        loader.number = self._number
        return importlib.util.spec_from_file_location(name, path_of(name), loader=loader)


def path_of(module: str) -> Path:
    """The file of a module."""
    return ROOT / f"{module.replace('.', '/')}.py"


def run_mutant(module: str, number: int) -> int:
    """Run the tests of a module with one change in it; pytest's exit code."""
    import pytest

    sys.meta_path.insert(0, Finder(module, number))
    return int(pytest.main(["-x", "-q", "-n", "0", "-p", "no:cacheprovider", TESTED[module]]))


def is_noticed(module: str, number: int) -> bool:
    """Whether the tests fail, or do not end, with the change."""
    command = [sys.executable, "-m", "tests.bench.mutation", "--module", module,
               "--mutant", str(number)]
    try:
        return subprocess.run(command, cwd=ROOT, capture_output=True, timeout=LONGEST_S,
                              check=False).returncode != 0
    except subprocess.TimeoutExpired:
        return True


def main() -> None:
    """Print the mutants that nobody notices, and the share that is noticed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--each", type=int, default=12)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--module", choices=[*TESTED])
    parser.add_argument("--mutant", type=int)
    options = parser.parse_args()
    if options.mutant is not None:
        raise SystemExit(run_mutant(options.module, options.mutant))
    noticed = drawn = 0
    for module in [options.module] if options.module else TESTED:
        source = path_of(module).read_text(encoding="utf-8")
        count = len(list(places(ast.parse(source))))
        chosen = np.random.default_rng(options.seed).permutation(count)[: options.each]
        alive = [number for number in map(int, chosen) if not is_noticed(module, number)]
        noticed, drawn = noticed + len(chosen) - len(alive), drawn + len(chosen)
        print(f"{module}: {len(chosen) - len(alive)} of {len(chosen)}, {count} places", flush=True)
        for number in alive:
            print(f"    {mutated(ast.parse(source), number)}", flush=True)
    print(f"noticed: {noticed} of {drawn} ({100 * noticed / drawn:.0f} %)")


if __name__ == "__main__":
    main()
