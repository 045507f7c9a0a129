"""Sessions on disk and the command run on them, as a user has and does it."""

import json
from pathlib import Path
from typing import Any

from pipeline import cli
from tests.world.designs import paper_design
from tests.world.session import Session, simulate
from tests.world.write import write_session


def quick_session(folder: Path, seed: int = 1) -> tuple[Path, Session]:
    """The paper's evening with shorter poses, rates stated; its configuration and its truth."""
    session = simulate(paper_design().scaled(seconds=0.5), seed)
    return write_session(folder, session, film=False).config, session


def pipeline(*arguments: str | Path) -> int:
    """One command in this process; an exception that nobody expects goes through."""
    return cli.main([str(argument) for argument in arguments])


def results_in(folder: Path) -> dict[str, Any]:
    """results.json of a folder."""
    found: dict[str, Any] = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    return found
