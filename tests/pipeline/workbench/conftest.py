"""A session with something hidden, opened in a workbench of its own process."""

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from tests.sessions import pipeline
from tests.world.designs import rich_design
from tests.world.session import simulate
from tests.world.sizes import draw_effect
from tests.world.write import write_session


@dataclass(frozen=True)
class Opened:
    """A running ``pipeline open``: its configuration, its address with the token, its process.

    ``said`` are the lines before the address.
    """

    config: Path
    address: str
    process: subprocess.Popen[str]
    said: tuple[str, ...]

    @property
    def origin(self) -> str:
        """The address without its token."""
        return self.address.partition("/?")[0]


def written_session(folder: Path, seed: int = 3) -> Path:
    """A gyroscope that hides a g-sensitivity: short poses, stopped and at one speed; not run yet.

    Another seed is another evening of the same sensor.
    """
    design = rich_design().scaled(seconds=0.3, sample_rate=0.5)
    design = replace(design, runs=tuple(
        run for run in design.runs if run.name in ("stopped", "33rpm")))
    hidden = draw_effect("g_sensitivity", "gyroscope", 25.0, design, 3)
    return write_session(folder, simulate(design, seed, (hidden,)), film=False).config


@contextmanager
def opened_workbench(
    config: Path, *options: str, path: str = "/nowhere"
) -> Iterator[Opened]:
    """``pipeline open`` of a configuration with no browser in ``path``, ended by Ctrl-C."""
    with subprocess.Popen(
        [sys.executable, "-m", "pipeline", "open", str(config), *options],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        env=os.environ | {"PATH": path}) as process:
        assert process.stdout is not None
        try:
            said: list[str] = []
            for line in iter(process.stdout.readline, ""):
                said.append(line.strip())
                if line.startswith("http://"):
                    break
            *before, address = said
            yield Opened(config, address, process, tuple(before))
        finally:
            process.send_signal(signal.SIGINT)
            assert process.wait(240) == 130  # on a busy machine


@pytest.fixture(scope="session")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The session, which was run once; nobody changes it."""
    config = written_session(tmp_path_factory.mktemp("written"))
    assert pipeline("run", config, "--quiet") == 0
    return config


def copied(config: Path, folder: Path) -> Path:
    """The same session with its results in another folder, as if it had been run there."""
    shutil.copytree(config.parent, folder, dirs_exist_ok=True)
    report = (folder / config.name).with_suffix(".run") / "report.html"
    report.write_text(report.read_text("utf-8").replace(str(config.parent), str(folder)), "utf-8")
    return folder / config.name


@pytest.fixture(scope="session")
def opened(written: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Opened]:
    """The session, opened; nobody writes it."""
    with opened_workbench(copied(written, tmp_path_factory.mktemp("opened"))) as opened:
        yield opened
