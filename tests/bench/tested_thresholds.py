"""Which tests fail with a threshold halved, doubled, or switched off.

    python -m tests.bench.tested_thresholds [--only MODULE[.NAME] ...] [--tests PATH ...]
                                            [--seconds 5] [--keep FILE]

The tests run once, and for each it is noted which functions of the product it calls. A threshold is
then judged by the tests that call a function which reads it, the quickest first, for ``--seconds``
of tests. Tests are real cases with an answer that is known otherwise; one that fails may mean that
the answer is wrong, or that a message states the threshold. "No case" means that no test reads it.
A threshold is switched off at zero or at infinity (a count at a million): of the two the one with
which fewer tests fail stands under "off", since the other leaves the condition always true. Where
neither fails a test, it is neither halved nor doubled. ``--keep`` holds what the first run noted.
"""

import argparse
import math
import os
import pickle
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import pytest

from tests.bench.threshold_records import FACTORS
from tests.paths import ROOT
from tests.source_tree import FILES, begins, imports, tree_of
from tests.thresholds import Threshold, thresholds

MANY = 1_000_000  #: in the place of infinity where a threshold is a count
LONGEST_S = 60  #: a test that takes longer with another value counts as failed
PACKAGES = ("calib", "pipeline")
Place = tuple[str, int]  #: of a function: its file and first line


@dataclass
class Calls:
    """A test: how long it takes and the functions of the product that it calls."""

    seconds: float = 0.0
    places: set[Place] = field(default_factory=set)


class Noted:
    """What each test calls, noted by the interpreter's profiler."""

    def __init__(self) -> None:
        self.of: dict[str, Calls] = {}
        self.inside = tuple(str(ROOT / each) + os.sep for each in PACKAGES)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Called by pytest around each test with its fixtures."""
        codes: set[CodeType] = set()

        def note(frame: FrameType, event: str, _: Any) -> None:
            if event == "call":
                codes.add(frame.f_code)

        start = time.perf_counter()
        sys.setprofile(note)
        try:
            return (yield)
        finally:
            sys.setprofile(None)
            self.of[item.nodeid] = Calls(time.perf_counter() - start, {
                (code.co_filename, code.co_firstlineno) for code in codes
                if code.co_filename.startswith(self.inside)})


class Counted:
    """How many tests ran, and the names of those that failed."""

    def __init__(self) -> None:
        self.count = 0
        self.failed: list[str] = []

    @property
    def words(self) -> str:
        """How many tests failed, as a cell of the table."""
        failed = len(self.failed) or "none"
        return f"{failed} of {self.count} cases {'fails' if failed in (1, 'none') else 'fail'}"

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self) -> Iterator[None]:
        """Called by pytest around each test."""
        signal.alarm(LONGEST_S)
        try:
            return (yield)
        finally:
            signal.alarm(0)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Called by pytest for each part of each test."""
        self.count += report.when == "setup"
        if report.failed:
            self.failed.append(report.nodeid)


def run(tests: Sequence[str], plugin: Any) -> None:
    """Run tests in this process, silently."""
    with open(os.devnull, "w", encoding="utf-8") as nowhere, redirect_stdout(nowhere):
        pytest.main(["--numprocesses=0", *(str(ROOT / each) for each in tests)], plugins=[plugin])


def holders(path: str, name: str) -> list[str]:
    """The modules that have a constant: its own, and those that import it."""
    return [path, *(each for each in FILES if (path, name) in imports(tree_of(each)))]


def readers(path: str, name: str) -> set[Place]:
    """The functions that read a constant."""
    places = set()
    for module in holders(path, name):
        source = FILES[module]
        pending = [compile(source.read_text(encoding="utf-8"), str(source), "exec")]
        while pending:
            code = pending.pop()
            pending += [each for each in code.co_consts if isinstance(each, CodeType)]
            if name in code.co_names and code.co_name != "<module>":
                places.add((code.co_filename, code.co_firstlineno))
    return places


def multiplied(value: Any, factor: float) -> Any:
    """A number, or each number of several, times ``factor``."""
    if isinstance(value, dict):
        return {key: multiplied(each, factor) for key, each in value.items()}
    if isinstance(value, tuple):
        return tuple(multiplied(each, factor) for each in value)
    return type(value)(value * factor)


def switched_off(value: Any, *, high: bool) -> Any:
    """A threshold that nothing exceeds, or that everything does."""
    if isinstance(value, dict):
        return {key: switched_off(each, high=high) for key, each in value.items()}
    if isinstance(value, tuple):
        return tuple(switched_off(each, high=high) for each in value)
    largest = MANY if isinstance(value, int) else math.inf
    return largest if high else type(value)(0)


@contextmanager
def changed(path: str, name: str, new: Any) -> Iterator[None]:
    """Another value of a constant, in every module that has it."""
    modules = [import_module(each) for each in holders(path, name)]
    value = getattr(modules[0], name)
    try:
        for each in modules:
            setattr(each, name, new)
        forget()
        yield
    finally:
        for each in modules:
            setattr(each, name, value)
        forget()


def forget() -> None:
    """Empty all caches of the product."""
    for path, module in list(sys.modules.items()):
        if path.split(".")[0] in PACKAGES:
            for each in list(vars(module).values()):
                if hasattr(each, "cache_clear"):
                    each.cache_clear()


def row(one: Threshold, path: str, noted: dict[str, Calls], seconds: float) -> str:
    """The cells of a threshold."""
    name = path.rpartition(".")[2]
    path = path.rpartition(".")[0]
    places = readers(path, name)
    near = sorted((each.seconds, test) for test, each in noted.items() if each.places & places)
    tests, total = [], 0.0
    for took, test in near:
        total += took
        if tests and total > seconds:
            break
        tests.append(test)
    if not tests:
        return f"| `{one.path}` | {one.cells[1]} | no case | no case | no case |"

    def outcome(new: Any) -> Counted:
        counted = Counted()
        with changed(path, name, new):
            run(tests, counted)
        for each in counted.failed:
            print(f"  {name} = {new}: {each}", file=sys.stderr, flush=True)
        return counted

    both = [outcome(switched_off(one.value, high=high)) for high in (False, True)]
    off = min(both, key=lambda cases: len(cases.failed))
    felt = any(each.failed for each in both)
    cells = [outcome(multiplied(one.value, factor)).words if felt else "no effect"
             for factor in FACTORS]
    return f"| `{one.path}` | {one.cells[1]} | {' | '.join(cells)} | {off.words} |"


def too_long(*_: Any) -> None:
    """A test that takes too long fails."""
    raise TimeoutError(f"longer than {LONGEST_S} s")


def main() -> None:
    """A row of a table for each threshold."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--only", nargs="*", default=())
    parser.add_argument("--tests", nargs="*", default=("tests/calib",))
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    signal.signal(signal.SIGALRM, too_long)
    if options.keep and options.keep.exists():
        noted = pickle.loads(options.keep.read_bytes())
    else:
        plugin = Noted()
        run(options.tests, plugin)
        noted = plugin.of
        if options.keep:
            options.keep.write_bytes(pickle.dumps(noted))
    print("| threshold | value | × 0.5 | × 2 | off |\n|---|---|---|---|---|")
    for package in PACKAGES:
        for one in thresholds(package):
            path = f"{package}.{one.path}"
            if not options.only or any(begins(path, each) for each in options.only):
                print(row(one, path, noted, options.seconds), flush=True)


if __name__ == "__main__":
    main()
