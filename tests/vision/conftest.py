"""Films for the tests of the vision stage, rendered once per session."""

import pytest


@pytest.fixture(scope="session")
def render(tmp_path_factory):
    """Render a clip: ``render(motion, scene, seconds=20, **film arguments)`` → path, truth."""
    pytest.importorskip("av", reason="rendering clips needs PyAV")
    from tests.world.film import film

    folder = tmp_path_factory.mktemp("clips")
    count = iter(range(1000))

    def make(motion, scene=None, *, seconds=20.0, suffix=".mp4", **how):
        path = folder / f"clip_{next(count):03d}{suffix}"
        return path, film(path, motion, scene, seconds=seconds, **how)

    return make
