"""Bad input, by the command: the right exit code, one helpful paragraph, nothing half written."""

import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.attack.case import POSE, Spoil, edit
from tests.paths import ROOT
from tests.sessions import pipeline, quick_session

CLIP = ROOT / "data/example/video/17rpm.mp4"


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session without a fault."""
    return quick_session(tmp_path_factory.mktemp("session"))[0]


@pytest.fixture
def session(whole: Path, tmp_path: Path) -> Path:
    """A copy to spoil; its configuration."""
    shutil.copytree(whole.parent, tmp_path / "session")
    return tmp_path / "session" / whole.name


def in_line_5(column: int, text: str) -> Spoil:
    """Another cell in line 5 of one pose."""

    def spoil(config: Path) -> None:
        lines = (config.parent / POSE).read_text(encoding="utf-8").splitlines()
        cells = lines[4].split(",")
        cells[column] = text
        lines[4] = ",".join(cells)
        (config.parent / POSE).write_text("\n".join(lines), encoding="utf-8")

    return spoil


def no_pose_file(config: Path) -> None:
    edit("accelerometer/pose_*.csv", "accelerometer/position_*.csv")(config)


def empty_pose(config: Path) -> None:
    (config.parent / POSE).write_text("", encoding="utf-8")


def header_only(config: Path) -> None:
    path = config.parent / POSE
    path.write_text(path.read_text(encoding="utf-8").splitlines()[0] + "\n", encoding="utf-8")


def eight_poses(config: Path) -> None:
    for path in sorted((config.parent / "accelerometer").iterdir())[8:]:
        path.unlink()


def copies_of_one_pose(config: Path) -> None:
    first, *others = sorted((config.parent / "accelerometer").iterdir())
    for other in others:
        shutil.copy(first, other)


def counts(column: int, change: Callable[[np.ndarray], np.ndarray]) -> Spoil:
    """Other counts in one column of one pose."""

    def spoil(config: Path) -> None:
        path = config.parent / POSE
        header = path.read_text(encoding="utf-8").splitlines()[0]
        table = np.loadtxt(path, delimiter=",", skiprows=1)
        table[:, column] = change(table[:, column])
        np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.4f")

    return spoil


def filmed(make_clip: Callable[[Path], None]) -> Spoil:
    """A clip instead of the stated rate."""

    def spoil(config: Path) -> None:
        make_clip(config.parent / "clip.mp4")
        text = config.read_text(encoding="utf-8")
        rate = next(line for line in text.splitlines() if line.startswith("  17rpm: {"))
        config.write_text(text.replace(rate, "  17rpm: {video: clip.mp4}"), encoding="utf-8")

    return spoil


def truncated_clip(path: Path) -> None:
    path.write_bytes(CLIP.read_bytes()[:40_000])


def empty_clip(path: Path) -> None:
    path.write_bytes(b"")


def no_plate(path: Path) -> None:
    """A still picture with noise, as of a camera pointed at a table."""
    import av

    rng = np.random.default_rng(0)
    table = np.kron(rng.integers(60, 200, (12, 16), np.uint8), np.ones((20, 20), np.uint8))
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=15)
        stream.width, stream.height, stream.pix_fmt = 320, 240, "yuv420p"
        stream.options = {"preset": "ultrafast"}
        for _ in range(60):
            noisy = np.clip(table + rng.normal(0, 3, table.shape), 0, 255).astype(np.uint8)
            frame = av.VideoFrame.from_ndarray(np.dstack([noisy] * 3), format="rgb24")
            container.mux(stream.encode(frame))
        container.mux(stream.encode())


def yaml_bomb(config: Path) -> None:
    lines = ["a: &a [x, x, x, x, x, x, x, x, x]"]
    lines += [f"{b}: &{b} [{', '.join([f'*{a}'] * 9)}]" for a, b in zip("abcdefgh", "bcdefghi",
                                                                         strict=True)]
    config.write_text("\n".join(lines), encoding="utf-8")


CASES: dict[str, tuple[Spoil, int, str]] = {
    "a missing file": (no_pose_file, 3, "no file matches 'accelerometer/position_*.csv'"),
    "an empty CSV": (empty_pose, 3, "pose_07.csv: the file is empty"),
    "a header without rows": (header_only, 3, "pose_07.csv"),
    "text in a number column": (in_line_5(2, "n/a"), 3, "pose_07.csv:5: column acc_y: found 'n/a'"),
    "NaN": (in_line_5(4, "nan"), 3, "pose_07.csv:5: column gyr_x: found nan"),
    "time going backwards": (in_line_5(0, "-1.0"), 3, "pose_07.csv:5: time does not increase"),
    "a truncated clip": (filmed(truncated_clip), 3, "clip.mp4"),
    "an empty clip": (filmed(empty_clip), 3, "clip.mp4"),
    "a clip that is not a plate": (filmed(no_plate), 4, "nothing in the frame turns"),
    "8 poses": (eight_poses, 4, "8 poses give 8 equations for 9 parameters"),
    "18 copies of one pose": (copies_of_one_pose, 4, "hold the same accelerometer samples"),
    "counts at the rails": (
        counts(1, lambda x: np.where(np.arange(len(x)) % 3, x, 65_535)), 4, "acc_x|saturated",
    ),
    "an axis that is stuck": (counts(1, np.zeros_like), 4, "accelerometer x is saturated"),
    "the wrong encoding": (
        edit("encoding: offset-binary", "encoding: twos-complement"), 3, "offset-binary",
    ),
    "the wrong full scale": (
        edit("full_scale_m_s2: 50", "full_scale_m_s2: 500"), 4, "where 9.803 m/s² is expected",
    ),
    "a plate that was not turning": (
        edit("gyroscope/17rpm/pose_*.csv", "accelerometer/pose_*.csv"), 4, "not turning",
    ),
    "a YAML bomb": (yaml_bomb, 2, "config.yaml:1"),
}


@pytest.mark.parametrize("case", CASES)
def test_bad_input_is_one_paragraph_with_the_right_exit_code_and_leaves_nothing(
    session: Path, case: str, capsys: pytest.CaptureFixture[str]
) -> None:
    spoil, code, says = CASES[case]
    spoil(session)
    before = sorted(session.parent.rglob("*"))
    assert pipeline("run", session) == code
    message = capsys.readouterr().err.strip()
    assert any(part in message for part in says.split("|")), message
    paragraphs = [line for line in message.splitlines() if not line.startswith("warning: ")]
    assert len(paragraphs) == 1, message
    assert ". " in message or "; " in message, "what was found, and what to do"
    assert "Traceback" not in message
    assert sorted(session.parent.rglob("*")) == before


def test_a_yaml_bomb_is_refused_at_once(session: Path) -> None:
    """In a process of its own, with a time limit: expanded, these nine lines are 4 GB."""
    yaml_bomb(session)
    done = subprocess.run(["timeout", "5", sys.executable, "-m", "pipeline", "run",
                           str(session)], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
