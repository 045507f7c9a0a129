"""A case of the corpus: what is spoiled, what is typed, what must come of it.

A command that does not end with 0 leaves every file as it was. One that does leaves every file
that it did not make, but for the configuration where it is asked to change that. No command calls
a fault of the data a bug, and none sends a control character to the terminal.
"""

import gzip
import json
import re
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest

from pipeline.text.plain import HIDDEN
from tests import sessions
from tests.sessions import pipeline

POSE = "accelerometer/pose_07.csv"
Spoil = Callable[[Path], object]
#: What a command may write in the session's own folder, whatever comes of it.
MADE = ("config.run/cache", "config.run/.written.json")
CHANGES_THE_CONFIGURATION = ("add", "remove")


@dataclass(frozen=True)
class Case:
    """One line of the corpus.

    ``typed`` has CONFIG, RUN (folder of the results), LOG (a pose), HERE (the session's folder);
    ``says`` is a pattern that standard output or error must hold; ``spoil`` changes the session
    first.
    """

    name: str
    typed: str
    code: int
    says: str
    spoil: Spoil = lambda _config: None

    def arguments(self, config: Path) -> list[str]:
        """What is typed in the session of ``config``."""
        places = {"CONFIG": config, "RUN": config.with_suffix(".run"),
                  "LOG": config.parent / POSE, "HERE": config.parent}
        words = shlex.split(self.typed)
        return [re.sub("|".join(places), lambda match: str(places[match[0]]), word)
                for word in words]


def hashes(folder: Path) -> dict[str, str]:
    """The content of every file below a folder."""
    return {path.relative_to(folder).as_posix(): sha256(path.read_bytes()).hexdigest()
            for path in sorted(folder.rglob("*")) if path.is_file()
            and not path.relative_to(folder).as_posix().startswith(MADE)}


def is_consistent(config: Path) -> bool:
    """Whether the results are those of the configuration beside them, and nothing lies about."""
    folder = config.with_suffix(".run")
    results = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    steps = (folder / "history.jsonl").read_text(encoding="utf-8").splitlines()
    hashed = sha256(config.read_text(encoding="utf-8").encode()).hexdigest()
    parts = [*config.parent.rglob("*.part"), *config.parent.rglob(".unfinished*")]
    return (not parts and results["config_sha256"] == hashed
            and json.loads(steps[-1])["config_sha256"] == hashed)


def check(case: Case, config: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Run a case in a session of its own and look at everything that it must leave alone."""
    case.spoil(config)
    before = hashes(config.parent)
    code = pipeline(*case.arguments(config))
    printed = "".join(capsys.readouterr())
    assert (code, bool(re.search(case.says, printed))) == (case.code, True), printed
    assert "our bug" not in printed
    assert set(HIDDEN.findall(printed)) <= {"\n", "\t"}
    after = hashes(config.parent)
    if code:
        assert after == before
        return
    own = ("config.run/", config.name) if case.typed.split()[0] in CHANGES_THE_CONFIGURATION else (
        "config.run/",)
    assert {name: after.get(name) for name in before if not name.startswith(own)} == {
        name: value for name, value in before.items() if not name.startswith(own)}


# --- ways to spoil a session ---------------------------------------------------------------------


def edit(old: str, new: str) -> Spoil:
    """Another text in the configuration, which must hold the old one."""
    return partial(sessions.edit, old=old, new=new)


def append(text: str) -> Spoil:
    """More text at the end of the configuration."""
    return lambda config: config.write_text(
        config.read_text(encoding="utf-8") + text + "\n", encoding="utf-8")


def write(name: str, content: str | bytes) -> Spoil:
    """A file of the session with this content; gzip where the name ends so."""

    def spoil(config: Path) -> None:
        data = content.encode() if isinstance(content, str) else content
        (config.parent / name).write_bytes(gzip.compress(data) if name.endswith("gz") else data)

    return spoil


def rows(change: Callable[[list[str]], list[str]], name: str = POSE) -> Spoil:
    """Other cells in every row of a log."""

    def spoil(config: Path) -> None:
        head, *lines = (config.parent / name).read_text(encoding="utf-8").splitlines()
        changed = [",".join(change(line.split(","))) for line in lines]
        (config.parent / name).write_text("\n".join([head, *changed]) + "\n", encoding="utf-8")

    return spoil


def lines(change: Callable[[list[str]], list[str]], name: str = POSE) -> Spoil:
    """Other lines in a log."""

    def spoil(config: Path) -> None:
        path = config.parent / name
        path.write_text("\n".join(change(path.read_text(encoding="utf-8").splitlines())) + "\n",
                        encoding="utf-8")

    return spoil


def result(*where: Any, value: Any) -> Spoil:
    """Another value in results.json."""

    def spoil(config: Path) -> None:
        path = config.with_suffix(".run") / "results.json"
        contents = json.loads(path.read_text(encoding="utf-8"))
        inside = contents
        for key in where[:-1]:
            inside = inside[key]
        inside[where[-1]] = value
        path.write_text(json.dumps(contents), encoding="utf-8")

    return spoil


def both(*spoils: Spoil) -> Spoil:
    """One after the other."""

    def spoil(config: Path) -> None:
        for each in spoils:
            each(config)

    return spoil
