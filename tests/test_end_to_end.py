"""From clip and logs to results, as a user does it, against the world that made them."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.paths import ROOT, SHARED
from tests.sessions import pipeline, results_in
from tests.world.make_data import example_session
from tests.world.session import Session

EXAMPLE = ROOT / "data/example/config.yaml"
CLIP = ROOT / "data/example/video/17rpm.mp4"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of the shipped session, clip included."""
    folder = tmp_path_factory.mktemp("example")
    assert pipeline("run", EXAMPLE, "--output", folder) == 0
    return folder


@pytest.fixture(scope="module")
def found(folder: Path) -> dict[str, Any]:
    return results_in(folder)


@pytest.fixture(scope="module")
def truth() -> Session:
    return example_session()


def test_the_rate_from_the_clip_is_within_50_ppm_of_the_truth(
    found: dict[str, Any], truth: Session
) -> None:
    rate, true = found["rate"]["17rpm"], truth.rates["17rpm"].true_rad_s
    assert rate["rate_rad_s"] == pytest.approx(true, rel=50e-6)
    assert rate["direction"] == "ccw"
    assert rate["revolutions"] > 16
    assert rate["sd_parts"]["image_rad_s"] < 5e-6 * true
    assert rate["sd_parts"]["timebase_rad_s"] == pytest.approx(50e-6 * true, rel=1e-3)


def test_counting_frames_is_within_its_own_plus_or_minus_one_frame(
    found: dict[str, Any], truth: Session
) -> None:
    counted = found["rate"]["17rpm"]["frame_count"]
    true = truth.rates["17rpm"].true_rad_s
    one_frame = true / (60 * 15)  # of a 60 s clip at 15 frames/s
    assert 0.2 * one_frame < counted["sd_rad_s"] < one_frame
    assert abs(counted["rate_rad_s"] - true) < one_frame


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_every_parameter_is_found_and_nothing_is_said_to_be_missing(
    found: dict[str, Any], truth: Session, triad: str
) -> None:
    own = found[triad]
    for key, values in own["parameters"].items():
        away = np.array(values) - getattr(getattr(truth, triad), key)
        assert np.abs(away / np.array(own["sd"][key])).max() < 4, key
    assert own["diagnosis"]["verdict"] == "nothing_missing"
    assert own["p_value"] > 0.001


def test_a_second_run_does_not_follow_the_clip_again(folder: Path) -> None:
    """In a process of its own: OpenCV is not even imported."""
    code = (
        "import sys; from pipeline import cli; "
        f"code = cli.main(['run', {str(EXAMPLE)!r}, '--output', {str(folder)!r}]); "
        "print('cv2' in sys.modules, code)"
    )
    before = (folder / "results.json").read_bytes()
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True,
                          check=True)
    assert done.stdout.splitlines()[-1] == "False 0"
    assert (folder / "results.json").read_bytes() == before


def test_the_vision_stage_alone_prints_the_same_object_by_the_file_s_stem(
    found: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("rate", CLIP, "--nominal-rpm", "16.667", "--json") == 0
    alone = json.loads(capsys.readouterr().out)
    assert alone.keys() == {"17rpm"}
    assert alone["17rpm"].keys() == found["rate"]["17rpm"].keys()
    assert alone["17rpm"]["rate_rad_s"] == pytest.approx(found["rate"]["17rpm"]["rate_rad_s"])


def test_diagnose_says_what_to_type_and_writes_no_results(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = EXAMPLE.read_text(encoding="utf-8").replace("video/", f"{CLIP.parent}/")
    text = text.replace("poses: ", f"poses: {EXAMPLE.parent}/")
    text = text.replace("{poses: ", "{poses: ").replace("title:", f"output: {tmp_path}/out\ntitle:")
    (tmp_path / "config.yaml").write_text(text, encoding="utf-8")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "cache").symlink_to(folder / "cache")
    assert pipeline("diagnose", tmp_path / "config.yaml") == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith("accelerometer: Nothing is missing") for line in lines)
    assert any("these data cannot determine" in line and "g_sensitivity" in line for line in lines)
    assert lines[-1].startswith("next: ")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["cache"]


# --- sessions of a bench that nobody of us knows ------------------------------------------------


@pytest.mark.skipif(not (SHARED / "bench").is_dir(), reason=f"no sessions in {SHARED / 'bench'}")
@pytest.mark.parametrize("name", ["a", "b", "c"])
def test_a_session_of_unknown_content_runs_to_its_end(tmp_path: Path, name: str) -> None:
    assert pipeline("run", SHARED / "bench" / name / "config.yaml", "--output", tmp_path) == 0
    found = results_in(tmp_path)
    for rate in found["rate"].values():
        assert 0 < rate["sd_rad_s"] < 2e-3 * rate["rate_rad_s"]
        assert rate["revolutions"] > 3
    for triad in ("accelerometer", "gyroscope"):
        for values in found[triad]["sd"].values():
            assert all(sd > 0 for sd in values)
        assert found[triad]["diagnosis"]["says"]
