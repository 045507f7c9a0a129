"""What is recorded of one plate setting is read once, as long as its files stay what they are."""

from pathlib import Path

import pytest

from pipeline.logs.read import read_log
from pipeline.stages import session_logs
from tests.sessions import typed
from tests.world.designs import paper_design
from tests.world.session import simulate
from tests.world.write import write_session


def test_after_a_pose_its_log_alone_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = write_session(tmp_path, simulate(paper_design(), 3), film=False).config
    config.write_text(config.read_text() + "record: {device: xsens-mti, seconds_per_pose: 8}\n")
    first, *_, last = sorted((tmp_path / "accelerometer").iterdir())
    recorded = last.read_bytes()
    last.unlink()
    reads: list[Path] = []
    monkeypatch.setattr(session_logs, "read_log", lambda path, *stated: (
        reads.append(path), read_log(path, *stated))[1])

    def plan() -> tuple[str, int]:
        reads.clear()
        code, printed, errors = typed("plan", config)
        assert (code, errors) == (0, "")
        return printed, len(reads)

    before, all_of_them = plan()
    assert "accelerometer: 17 poses recorded, 1 missing" in before
    assert all_of_them == 17 + 18
    assert plan() == (before, 0)
    last.write_bytes(recorded)
    assert "accelerometer: 18 poses recorded, 0 missing" in plan()[0]
    assert reads == [last]
    first.write_bytes(recorded)  # one direction twice: another is missing
    assert "accelerometer: 18 poses recorded, 1 missing" in plan()[0]
    assert reads == [first]
