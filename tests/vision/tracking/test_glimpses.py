"""Whether anything moves in the colours of a clip, seen in glimpses."""

import numpy as np
import pytest

from vision.errors import NothingMoves
from vision.tracking import track
from vision.tracking.glimpses import nothing_moves
from vision.tracking.track import track_phase
from vision.video.reader import ClipReader

pytest.importorskip("av", reason="rendering clips needs PyAV")

from tests.vision.rendered_clips import Render
from tests.world.plate import PlateMotion
from tests.world.scene import colour_scene

TURNING = PlateMotion(33.3 * 2 * np.pi / 60)


def test_nothing_moves_about_a_plate_at_rest(render: Render) -> None:
    path, _ = render(PlateMotion(0.0), seconds=6)
    done: list[int] = []
    assert nothing_moves(path, lambda count, stated: done.append(count))
    assert done == sorted(done)
    assert done[-1] >= 6 * 15


def test_what_turns_is_glimpsed_by_its_colour(render: Render) -> None:
    scene = colour_scene(np.random.default_rng(1000))
    assert not nothing_moves(render(TURNING, scene, seconds=16)[0], None)


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
