"""Commands in any order, some of them stopped at a write: the files agree with each other."""

import os
import re
import shutil
import signal
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    rule,
    run_state_machine_as_test,
)

from pipeline import files
from tests.attack.case import hashes, is_consistent
from tests.sessions import edit, pipeline, results_in

STOPPED = -signal.SIGKILL
EFFECTS = ("bias_drift", "cubic", "temperature_bias", "misalignment")


def _with_a_full_disk(words: Sequence[object], stop_at: int) -> int:
    """The exit code of a command, or ``STOPPED`` where the disk was full at that write."""
    real, calls = os.replace, 0

    def full(*arguments: object) -> None:
        nonlocal calls
        calls += 1
        if calls == stop_at:
            raise OSError(28, "No space left on device")
        real(*arguments)  # type: ignore[arg-type]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pipeline.files.os.replace", full)
        code = pipeline(*map(str, words))
    return code if code == 0 or calls < stop_at or stop_at == 0 else STOPPED


def killed(words: Sequence[object], step: str, stop_at: int) -> int:
    """The exit code of a command in a process that is killed at the n-th ``step`` of its writes.

    A step is ``replace``, the renaming of a file, or ``fsync``, what forces it to the disk.
    """
    child = os.fork()
    if child == 0:
        real, calls = getattr(os, step), 0

        def kill(*arguments: object) -> None:
            nonlocal calls
            calls += 1
            if calls == stop_at:
                os.kill(os.getpid(), signal.SIGKILL)
            real(*arguments)

        setattr(files.os, step, kill)  # type: ignore[attr-defined]
        os._exit(pipeline(*map(str, words)))
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


class AnyOrder(RuleBasedStateMachine):
    """A session and what its configuration must hold by now."""

    prepared: Path

    @initialize()
    def copy(self) -> None:
        self.folder = Path(tempfile.mkdtemp())
        shutil.copytree(self.prepared.parent, self.folder / "session")
        self.config = self.folder / "session" / self.prepared.name
        self.logs = self._logs()
        self.model = self._stated()
        self.is_stale = False
        self.history = self._history()
        self.noted: list[str] | None = None
        self.excluded: str | None = None

    def _logs(self) -> dict[str, str]:
        return {name: each for name, each in hashes(self.config.parent).items()
                if name.endswith(".csv") and ".run/" not in name}

    def _whole(self) -> dict[str, str]:
        """All files but the unfinished ones of a killed command, which the next one takes away."""
        return {name: each for name, each in hashes(self.config.parent).items()
                if not name.endswith(files.PART)}

    def _stated(self) -> list[str]:
        text = self.config.read_text(encoding="utf-8")
        return list(yaml.safe_load(text)["accelerometer"]["model"])

    def _history(self) -> list[str]:
        path = self.config.with_suffix(".run") / "history.jsonl"
        return path.read_text(encoding="utf-8").splitlines()

    def _typed(self, command: str, effect: str, stop_at: int, is_killed: bool) -> None:
        """Change the model; at a ``stop_at`` above 0 the disk is full from that write on.

        Or the command is killed there, in a process of its own.
        """
        self._finish()
        before = self._whole()
        words = (command, self.config, f"accelerometer.{effect}",
                 *(("--anyway",) if command == "add" else ()))
        code = killed(words, "replace", stop_at) if is_killed else _with_a_full_disk(words, stop_at)
        assert code in (0, 2, 4, 5, STOPPED)
        changed = sorted({*self.model} ^ {effect})
        if code == 0:
            assert sorted(self._stated()) == changed
        elif code != STOPPED:  # refused: by the model, or by the poses
            assert self._whole() == before
        self._accept(changed)

    def _accept(self, changed: list[str]) -> None:
        """Take over a change that is made; one that is noted is made by the next command."""
        self.noted = changed if [*self.config.parent.rglob(".unfinished*")] else None
        if sorted(self._stated()) == changed:
            self.model, self.is_stale = self._stated(), False

    @rule(effect=st.sampled_from(EFFECTS), stop_at=st.integers(0, 5), is_killed=st.booleans())
    def add(self, effect: str, stop_at: int, is_killed: bool) -> None:
        self._typed("add", effect, stop_at, is_killed)

    @rule(effect=st.sampled_from(EFFECTS), stop_at=st.integers(0, 5), is_killed=st.booleans())
    def remove(self, effect: str, stop_at: int, is_killed: bool) -> None:
        self._typed("remove", effect, stop_at, is_killed)

    @rule(pose=st.integers(1, 18))
    def exclude(self, pose: int) -> None:
        """Leave one pose out, and no other."""
        self._finish()
        text = self.config.read_text(encoding="utf-8")
        text = re.sub(r"  exclude: .*\n", "", text)
        self.config.write_text(text.replace(
            "\naccelerometer:", f"\naccelerometer:\n  exclude: [pose_{pose:02d}.csv]", 1),
            encoding="utf-8")
        self.excluded, self.is_stale = f"accelerometer/pose_{pose:02d}.csv", True

    @rule()
    def retitle(self) -> None:
        self._finish()
        edit(self.config, "title: ", "title: again ")
        self.is_stale = True

    @rule()
    def run(self) -> None:
        assert pipeline("run", self.config) == 0
        self._accept(self.noted or sorted(self.model))
        self.is_stale = False
        poses = results_in(self.config.with_suffix(".run"))["accelerometer"]["poses"]
        assert self.excluded not in [pose["label"] for pose in poses]
        assert len(poses) == 18 - (self.excluded is not None)

    def _finish(self) -> None:
        """Let the next command finish a change that was noted."""
        if self.noted is not None:
            self.run()

    @rule()
    def show(self) -> None:
        self._finish()
        before = hashes(self.config.parent)
        assert pipeline("history", self.config) == 0
        assert hashes(self.config.parent) == before

    @invariant()
    def files_agree(self) -> None:
        if not hasattr(self, "config"):
            return
        assert self._logs() == self.logs
        assert sorted(self._stated()) == sorted(self.model)
        history = self._history()
        assert history[: len(self.history)] == self.history
        self.history = history
        if not self.is_stale and not [*self.config.parent.rglob(".unfinished*")]:
            assert is_consistent(self.config)

    def teardown(self) -> None:
        if hasattr(self, "folder"):
            shutil.rmtree(self.folder)


def run_in_any_order(prepared: Path, examples: int, steps: int, **how: Any) -> None:
    """So many sequences of so many commands on copies of a session."""
    AnyOrder.prepared = prepared
    run_state_machine_as_test(AnyOrder, settings=settings(
        max_examples=examples, stateful_step_count=steps, deadline=None,
        suppress_health_check=list(HealthCheck), **how))
