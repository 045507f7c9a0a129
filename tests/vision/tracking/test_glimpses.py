"""Whether anything moves in a clip, seen in glimpses."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from vision.errors import NothingMoves
from vision.tracking import track
from vision.tracking.glimpses import nothing_moves
from vision.tracking.stretch import LEARN_FROM
from vision.tracking.track import track_phase
from vision.video.reader import ClipReader

pytest.importorskip("av", reason="rendering clips needs PyAV")

from tests.vision.rendered_clips import Render
from tests.world.film import Scene
from tests.world.plate import PlateMotion
from tests.world.scene import colour_scene

TURNING = PlateMotion(33.3 * 2 * np.pi / 60)


def test_nothing_moves_about_a_plate_at_rest(render: Render) -> None:
    path, _ = render(PlateMotion(0.0), seconds=6)
    done: list[int] = []
    assert nothing_moves(path, lambda count, stated: done.append(count))
    assert done == sorted(done)
    assert done[-1] >= 6 * 15


@pytest.mark.parametrize(
    "scene", [Scene(), colour_scene(np.random.default_rng(1000))], ids=["brightness", "colour"])
def test_what_turns_is_glimpsed(render: Render, scene: Scene) -> None:
    assert not nothing_moves(render(TURNING, scene, seconds=16)[0], None)


def grey_clip(path: Path, *, moves_from: int, frames: int) -> Path:
    """A bright square that begins to move, in frames without any colour."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 15.0, (240, 180))
    for number in range(frames):
        grey = np.full((180, 240), 90, np.uint8)
        at = 40 + 3 * (max(number - moves_from, 0) % 40)
        grey[60:120, at : at + 40] = 200
        writer.write(np.repeat(grey[:, :, None], 3, axis=2))
    writer.release()
    return path


def test_what_begins_to_move_later_without_colour_is_glimpsed(tmp_path: Path) -> None:
    first = LEARN_FROM[0]
    later = grey_clip(tmp_path / "later.avi", moves_from=first + 30, frames=first + 150)
    assert not nothing_moves(later, None)
    never = grey_clip(tmp_path / "never.avi", moves_from=10_000, frames=first + 150)
    assert nothing_moves(never, None)


def test_a_plate_at_rest_is_not_read_with_all_its_colours(
    render: Render, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, _ = render(PlateMotion(0.0), seconds=6, preset="veryfast")
    read: list[bool] = []

    class Reader(ClipReader):
        def __init__(self, *where: object, colours: bool = False) -> None:
            read.append(colours)
            super().__init__(path, colours=colours)

    monkeypatch.setattr(track, "ClipReader", Reader)
    with pytest.raises(NothingMoves, match="no more than the noise"):
        track_phase(path)
    assert read == [False]
