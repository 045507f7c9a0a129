"""Faults of the machine at the n-th call: memory that is not there, a disk that does not read.

As SQLite is tested: a command is run with the fault at its first call, its second and so on, or at
calls drawn at random. What stands on the disk must then be as before or all new, the command must
say what happened, and the next command must find nothing lying about.
"""

import builtins
import errno
import io
import re
import shutil
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any, Literal

import numpy as np
import pytest

from tests.attack.case import Case, hashes, is_consistent
from tests.paths import ROOT
from tests.sessions import pipeline

Fault = Literal["memory", "read"]
OURS = tuple(str(ROOT / package) for package in ("calib", "pipeline"))


@contextmanager
def failing(fault: Fault, at: int, folder: Path) -> Iterator[list[int]]:
    """Let call number ``at`` fail, none at 0; what is given counts the calls.

    ``memory`` fails at the call of a function of the program, ``read`` at the reading of a file in
    ``folder``.
    """
    calls = [0]
    with _without_memory(at, calls) if fault == "memory" else _unreadable(at, calls, folder):
        yield calls


@contextmanager
def _without_memory(at: int, calls: list[int]) -> Iterator[None]:
    def traced(frame: FrameType, event: str, _argument: object) -> None:
        if event == "call" and frame.f_code.co_filename.startswith(OURS):
            calls[0] += 1
            if calls[0] == at:
                raise MemoryError

    before = sys.gettrace()
    sys.settrace(traced)
    try:
        yield
    finally:
        sys.settrace(before)


@contextmanager
def _unreadable(at: int, calls: list[int], folder: Path) -> Iterator[None]:
    real = io.open

    class Unreadable(io.FileIO):
        def _read(self, read: Any, *arguments: Any) -> Any:
            calls[0] += 1
            if calls[0] == at:
                raise OSError(errno.EIO, "Input/output error")
            return read(*arguments)

        def readinto(self, buffer: Any) -> Any:
            return self._read(super().readinto, buffer)

        def readall(self) -> Any:
            return self._read(super().readall)

    def opened(file: Any, mode: str = "r", *arguments: Any, **keywords: Any) -> Any:
        if set(mode) & set("wax+") or isinstance(file, int) or folder not in Path(file).parents:
            return real(file, mode, *arguments, **keywords)
        raw = io.BufferedReader(Unreadable(file))
        if "b" in mode:
            return raw
        text = dict(zip(("encoding", "errors", "newline"), arguments[1:], strict=False))
        return io.TextIOWrapper(raw, **(text | {key: value for key, value in keywords.items()
                                                if key != "buffering"}))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(builtins, "open", opened)
        patch.setattr(io, "open", opened)
        yield


COMMANDS = ("check CONFIG", "run CONFIG", "add CONFIG accelerometer.bias_drift --anyway",
            "remove CONFIG accelerometer.misalignment", "diagnose CONFIG",
            "history CONFIG", "apply RUN LOG --output HERE/si.csv", "export RUN --to csv",
            "import POSES --output HERE/imported")


def typed(command: str, prepared: Path, folder: Path) -> tuple[Path, list[str]]:
    """A copy of a session in ``folder``, its configuration, and the words of a command on it."""
    shutil.copytree(prepared.parent, folder)
    config = folder / prepared.name
    words = Case(command, command, 0, "").arguments(config)
    poses = [str(path) for path in sorted((folder / "accelerometer").glob("*.csv"))]
    return config, [part for word in words for part in (poses if word == "POSES" else [word])]


_RUN: set[str] = set()
"""Commands that have run in this process, and imported what they need."""


def calls_of(
    command: str, fault: Fault, prepared: Path, folder: Path
) -> tuple[int, set[str]]:
    """How many calls a command makes that can have this fault, and the files that it changes."""
    _, words = typed(command, prepared, folder)
    if command not in _RUN:
        pipeline(*words)  # imports everything
        shutil.rmtree(folder)
        typed(command, prepared, folder)
        _RUN.add(command)
    before = hashes(folder)
    with failing(fault, 0, folder) as calls:
        pipeline(*words)
    return calls[0], _changed(before, folder)


def _changed(before: dict[str, str], folder: Path) -> set[str]:
    """Names of the files that are new, gone or of another content."""
    return {name for name, _ in before.items() ^ hashes(folder).items()}


def draws(calls: int, count: int, seed: int) -> list[int]:
    """Numbers of calls, drawn at random."""
    at = np.random.default_rng(seed).permutation(calls)[:count] + 1
    return [int(number) for number in at]


def complaints(
    command: str, fault: Fault, at: int, prepared: Path, folder: Path,
    whole: set[str], printed: Callable[[], Any]
) -> list[str]:
    """What is wrong after a command whose call number ``at`` failed.

    ``whole`` are the files that it changes where nothing fails; ``printed`` gives what was printed
    since it was called last, as pytest's ``readouterr``.
    """
    config, words = typed(command, prepared, folder)
    before = hashes(folder)
    with failing(fault, at, folder):
        try:
            code = pipeline(*words)
        except Exception:
            return [f"call {at}: a bug\n{traceback.format_exc(limit=-6)}"]
    said = "".join(printed())
    wrong = []
    changed = _changed(before, folder)
    if code and (changed not in (set(), whole) or not is_consistent(config)):
        wrong.append(f"call {at}: code {code}, and of {whole} have changed {changed}")
    if code and not re.search("memory" if fault == "memory" else "Input/output error", said):
        wrong.append(f"call {at}: code {code}: {said.strip()[-300:]}")
    if pipeline("run", config) or not is_consistent(config):
        wrong.append(f"call {at}: the next run does not mend it: {''.join(printed())[-300:]}")
    printed()
    return wrong
