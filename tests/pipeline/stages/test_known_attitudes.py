"""A configuration that states how the case stood: the whole way, and what is refused."""

from pathlib import Path

import pytest

from tests.sessions import edit, pipeline, results_in
from tests.world.cube import evening
from tests.world.write import write_session

pytestmark = pytest.mark.usefixtures("bare_page")


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six faces at rest and six on the plate, with the attitudes stated."""
    written = write_session(tmp_path_factory.mktemp("cube"), evening(3), film=False).config
    edit(written, "  poses: accelerometer/pose_*.csv\n",
         "  poses: accelerometer/pose_*.csv\n  attitude_sd_deg: 0.2\n")
    edit(written, "rate: 17rpm}", "rate: 17rpm, attitude_sd_deg: 0.2}")
    return written


def test_six_faces_calibrate_both_triads(config: Path) -> None:
    assert pipeline("run", config) == 0
    results = results_in(config.with_suffix(".run"))
    for triad in ("accelerometer", "gyroscope"):
        assert results[triad]["n_poses"] == 6
        assert results[triad]["dof"] == 6
    assert max(results["accelerometer"]["sd"]["misalignment_rad"]) < 0.02


def test_the_plan_knows_that_six_are_enough(config: Path) -> None:
    assert pipeline("plan", config) == 0


def test_without_the_key_six_are_refused(
    config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = config.read_text(encoding="utf-8")
    bare = config.with_name("bare.yaml")
    bare.write_text(text.replace("  attitude_sd_deg: 0.2\n", ""), encoding="utf-8")
    assert pipeline("check", bare) == 4
    refused = capsys.readouterr().err
    assert "6 equations for 9 parameters" in refused
    assert "state how squarely by `attitude_sd_deg`, and six faces are enough" in refused


@pytest.mark.parametrize(("old", "new", "says"), [
    ("rate: 17rpm, attitude", "rate: stopped, attitude", "says nothing of a gyroscope at rest"),
    ("  attitude_sd_deg: 0.2\n", "  attitude_sd_deg: 50\n", "expected a number of at most 5"),
])
def test_what_it_cannot_mean_is_refused(
    config: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, says: str
) -> None:
    text = config.read_text(encoding="utf-8")
    assert old in text
    other = config.with_name("other.yaml")
    other.write_text(text.replace(old, new, 1), encoding="utf-8")
    assert pipeline("check", other) == 2
    assert says in capsys.readouterr().err
