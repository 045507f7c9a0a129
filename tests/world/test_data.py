"""Sessions as files: complete, without the truth; and data/ is what its generator makes."""

import gzip
import hashlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml

from tests.world.designs import paper_design, rich_design, soak_design
from tests.world.make_data import (
    DATA,
    LIST_BEGINS,
    LIST_ENDS,
    SESSIONS,
    example_session,
    file_list,
    hidden_effect_session,
)
from tests.world.session import Session, simulate
from tests.world.write import pose_files, table_text, write_session


def numbers(path: Path) -> np.ndarray:
    return np.loadtxt(path, delimiter=",", skiprows=1)


def test_a_session_on_disk_holds_the_logs_and_states_no_truth(tmp_path: Path) -> None:
    session = simulate(paper_design().scaled(seconds=0.1), 1)
    written = write_session(tmp_path, session, film=False)
    files = sorted(p.relative_to(tmp_path).as_posix() for p in tmp_path.rglob("*.*"))
    assert len(files) == 18 + 18 + 1
    still, turning = session.runs
    third = numbers(tmp_path / "accelerometer/pose_03.csv")
    assert np.array_equal(third[:, 1:4], still.accelerometer[2])
    last = numbers(tmp_path / "gyroscope/17rpm/pose_18.csv")
    assert np.array_equal(last[:, 4:7], turning.gyroscope[17])
    assert np.array_equal(last[:, 7], turning.columns["temperature_c"][17])
    assert last[:, 0] == pytest.approx(turning.time_s[17])

    config = yaml.safe_load(written.config.read_text(encoding="utf-8"))
    stated = session.rates["17rpm"]
    assert config["rate"]["17rpm"]["rate_rad_s"] == pytest.approx(stated.rate_rad_s)
    assert config["rate"]["17rpm"]["rate_rad_s"] != pytest.approx(stated.true_rad_s, rel=1e-9)
    assert config["gyroscope"]["runs"] == [{"poses": "gyroscope/17rpm/pose_*.csv", "rate": "17rpm"}]


def test_the_rich_session_uses_its_poses_at_rest_for_both_triads(tmp_path: Path) -> None:
    session = simulate(rich_design().scaled(seconds=0.1, sample_rate=0.2), 2)
    config = yaml.safe_load(write_session(tmp_path, session, film=False).config.read_text())
    rates = [run["rate"] for run in config["gyroscope"]["runs"]]
    assert rates == ["17rpm", "m17rpm", "33rpm", "m33rpm", "stopped"]
    assert config["gyroscope"]["runs"][-1]["poses"] == config["accelerometer"]["poses"]
    assert all(known["rate_rad_s"] > 0 for known in config["rate"].values())


def test_poses_at_rest_are_numbered_through_all_temperatures(tmp_path: Path) -> None:
    session = simulate(soak_design().scaled(seconds=0.1, sample_rate=0.2), 3)
    write_session(tmp_path, session, film=False, compressed=True)
    paths = sorted((tmp_path / "accelerometer").iterdir())
    assert [path.name for path in paths] == [f"pose_{i + 1:02d}.csv.gz" for i in range(78)]
    begins = [numbers(path)[0, 0] for path in paths]
    assert (np.diff(begins) > 0).all()


def test_clips_show_the_plate_and_the_config_names_only_the_marked_speed(tmp_path: Path) -> None:
    pytest.importorskip("av", reason="the clips of the simulated bench need PyAV")
    from tests.world.write import Camera

    session = simulate(paper_design().scaled(seconds=0.1), 4)
    written = write_session(tmp_path, session, film=Camera(seconds=1.0))
    config = yaml.safe_load(written.config.read_text(encoding="utf-8"))
    assert config["rate"]["17rpm"]["nominal_rpm"] == pytest.approx(50 / 3, abs=1e-3)
    assert (tmp_path / config["rate"]["17rpm"]["video"]).stat().st_size > 1000
    truth = written.films["17rpm"]
    assert truth.angle_rad[-1] - truth.angle_rad[0] == pytest.approx(100 * np.pi / 180 * 14 / 15)


# --- data/ -------------------------------------------------------------------------------------


def shipped_text(path: Path) -> str:
    packed = path.read_bytes()
    return (gzip.decompress(packed) if path.suffix == ".gz" else packed).decode()


@pytest.mark.parametrize(
    ("name", "make", "suffix"),
    [
        ("example", example_session, ".csv"),
        ("hidden_effect", hidden_effect_session, ".csv.gz"),
    ],
)
def test_the_shipped_logs_are_what_the_generator_makes(
    name: str, make: Callable[[], Session], suffix: str
) -> None:
    files = pose_files(make())
    logs = {p.relative_to(DATA / name).as_posix() for p in (DATA / name).rglob(f"pose_*{suffix}")}
    assert logs == {where + suffix for where, _ in files}
    for where, pose in files:
        text = shipped_text(DATA / name / (where + suffix))
        assert text == table_text(pose), f"{where}: run python -m tests.world.make_data"


@pytest.mark.parametrize("name", SESSIONS)
def test_the_shipped_config_names_the_clips_that_are_there(name: str) -> None:
    config = yaml.safe_load((DATA / name / "config.yaml").read_text(encoding="utf-8"))
    clips = {rate["video"] for rate in config["rate"].values()}
    assert clips == {f"video/{p.name}" for p in (DATA / name / "video").iterdir()}


def test_the_readme_lists_every_file_with_its_sha256() -> None:
    readme = (DATA / "README.md").read_text(encoding="utf-8")
    listed = readme.partition(LIST_BEGINS)[2].partition(LIST_ENDS)[0].strip()
    assert listed == file_list(DATA).strip()
    config = DATA / "example/config.yaml"
    assert hashlib.sha256(config.read_bytes()).hexdigest() in listed


def test_data_stays_under_8_megabytes() -> None:
    shipped = (p for name in SESSIONS for p in (DATA / name).rglob("*") if p.is_file())
    assert sum(p.stat().st_size for p in shipped if ".run" not in p.as_posix()) < 8e6
