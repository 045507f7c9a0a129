"""Which tests fail with a threshold halved, doubled, or switched off.

    python -m tests.bench.tested_thresholds [--only MODULE[.NAME] ...] [--tests PATH ...]
                                            [--seconds 5] [--off] [--keep FILE]

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
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import pytest
from _pytest.runner import runtestprotocol

from tests.bench.threshold_records import FACTORS, changed, forget, holders, multiplied
from tests.paths import ROOT
from tests.source_tree import FILES, begins
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


class Study:
    """All tests collected once; a threshold is changed in a process of its own.

    Parameters
    ----------
    noted : dict of str to Calls
        What the tests call; noted first where it is empty.
    rows : callable
        Called with the study once the tests are known.
    """

    def __init__(self, noted: dict[str, Calls], rows: Callable[["Study"], None]) -> None:
        self.noted, self.rows = noted, rows
        self.items: dict[str, pytest.Item] = {}

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Called by pytest in the place of its own loop over the tests."""
        self.items = {item.nodeid: item for item in session.items}
        if not self.noted:
            self.note()
        self.rows(self)
        return True

    def note(self) -> None:
        """What each test and its fixtures call, by the interpreter's tracer."""
        inside = tuple(str(ROOT / package) + os.sep for package in PACKAGES)
        codes: set[CodeType] = set()

        def note(frame: FrameType, _: str, __: Any) -> None:  # of calls alone: it returns no tracer
            codes.add(frame.f_code)

        for item in self.items.values():
            forget()
            codes.clear()
            start = time.perf_counter()
            sys.settrace(note)
            try:
                runtestprotocol(item, nextitem=None, log=False)
            finally:
                sys.settrace(None)
            self.noted[item.nodeid] = Calls(time.perf_counter() - start, {
                (code.co_filename, code.co_firstlineno) for code in codes
                if code.co_filename.startswith(inside)})

    def failed(self, tests: Sequence[str], path: str, name: str, new: Any) -> list[str]:
        """The tests that fail with another value of a constant."""
        reading, writing = os.pipe()
        process = os.fork()
        if not process:
            items = [self.items[test] for test in tests]
            with changed(path, name, new), open(writing, "w", encoding="utf-8") as out:
                for item, after in zip(items, [*items[1:], None], strict=True):
                    signal.alarm(LONGEST_S)
                    reports = runtestprotocol(item, nextitem=after, log=False)
                    signal.alarm(0)
                    if any(report.failed for report in reports):
                        print(item.nodeid, file=out)
            os._exit(0)
        os.close(writing)
        with open(reading, encoding="utf-8") as lines:
            failed = lines.read().splitlines()
        os.waitpid(process, 0)
        return failed


def words(failed: Sequence[str], count: int) -> str:
    """How many of ``count`` tests failed, as a cell of the table."""
    many = len(failed) or "none"
    return f"{many} of {count} cases {'fails' if many in (1, 'none') else 'fail'}"


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


def switched_off(value: Any, *, high: bool) -> Any:
    """A threshold that nothing exceeds, or that everything does."""
    if isinstance(value, dict):
        return {key: switched_off(each, high=high) for key, each in value.items()}
    if isinstance(value, tuple):
        return tuple(switched_off(each, high=high) for each in value)
    largest = MANY if isinstance(value, int) else math.inf
    return largest if high else type(value)(0)


def row(one: Threshold, path: str, study: Study, seconds: float, only_off: bool) -> str:
    """The cells of a threshold."""
    name = path.rpartition(".")[2]
    path = path.rpartition(".")[0]
    places = readers(path, name)
    near = sorted((calls.seconds, test) for test, calls in study.noted.items()
                  if calls.places & places)
    tests, total = [], 0.0
    for took, test in near:
        total += took
        if tests and total > seconds:
            break
        tests.append(test)
    if not tests:
        return f"| `{one.path}` | {one.cells[1]} | no case | no case | no case |"

    def outcome(new: Any) -> list[str]:
        failed = study.failed(tests, path, name, new)
        for test in failed:
            print(f"  {name} = {new}: {test}", file=sys.stderr, flush=True)
        return failed

    both = [outcome(switched_off(one.value, high=high)) for high in (False, True)]
    off = min(both, key=len)
    if only_off:
        cells = ["", ""]
    elif any(both):
        cells = [words(outcome(multiplied(one.value, factor)), len(tests)) for factor in FACTORS]
    else:
        cells = ["no effect", "no effect"]
    return f"| `{one.path}` | {one.cells[1]} | {' | '.join(cells)} | {words(off, len(tests))} |"


def too_long(*_: Any) -> None:
    """A test that takes too long fails."""
    raise TimeoutError(f"longer than {LONGEST_S} s")


def main() -> None:
    """A row of a table for each threshold."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--only", nargs="*", default=())
    parser.add_argument("--tests", nargs="*", default=("tests/calib",))
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--off", action="store_true", help="neither half nor double")
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    signal.signal(signal.SIGALRM, too_long)
    keep: Path | None = options.keep
    noted = pickle.loads(keep.read_bytes()) if keep and keep.exists() else {}
    table = sys.stdout

    def rows(study: Study) -> None:
        if keep:
            keep.write_bytes(pickle.dumps(study.noted))
        print("| threshold | value | × 0.5 | × 2 | off |\n|---|---|---|---|---|", file=table)
        for package in PACKAGES:
            for one in thresholds(package):
                path = f"{package}.{one.path}"
                if not options.only or any(begins(path, start) for start in options.only):
                    print(row(one, path, study, options.seconds, options.off), file=table,
                          flush=True)

    with open(os.devnull, "w", encoding="utf-8") as nowhere, redirect_stdout(nowhere):
        pytest.main(["--numprocesses=0", "--capture=no",
                     *(str(ROOT / each) for each in options.tests)], plugins=[Study(noted, rows)])


if __name__ == "__main__":
    main()
