"""Clips for the tests of the vision stage, rendered once per session."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from tests.vision.rendered_clips import Render

if TYPE_CHECKING:
    from tests.world.film import FilmTruth, Recorder, Scene
    from tests.world.plate import PlateMotion


@pytest.fixture(scope="session")
def render(tmp_path_factory: pytest.TempPathFactory) -> Render:
    """Render a clip, by default of 20 s; the other arguments are those of the world's ``film``.

    The same arguments give the same file, which no test changes. At ``preset="veryfast"``, that
    of the benches, x264 takes as long as the rendering; it is for what shows in fine detail.
    """
    pytest.importorskip("av", reason="rendering clips needs PyAV")
    from tests.world.film import Recorder, film

    folder = tmp_path_factory.mktemp("clips")
    count = iter(range(1000))

    @cache
    def make(
        motion: "PlateMotion",
        scene: "Scene | None" = None,
        *,
        seconds: float = 20.0,
        suffix: str = ".mp4",
        recorder: "Recorder | None" = None,
        preset: str = "superfast",
        **how: Any,
    ) -> "tuple[Path, FilmTruth]":
        path = folder / f"clip_{next(count):03d}{suffix}"
        recorder = replace(recorder or Recorder(), preset=preset)
        return path, film(path, motion, scene, seconds=seconds, recorder=recorder, **how)

    return make
