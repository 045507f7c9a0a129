"""Further logs join a session that exists: each in its run, refused where it cannot be."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml

from calib.poses.averaging.pose_mean import PoseMean, TriadMean
from calib.poses.reference import PlateRate
from pipeline.config.load import Config, load_config
from pipeline.config.schema import GyroscopeSection, PosesSection, RunSection
from pipeline.further.logs import Known
from pipeline.stages.rate import SettingRate
from pipeline.stages.recordings import Recording, Recordings
from tests.sessions import edit, pipeline, quick_session, results_in, rewrite_rows, typed

pytestmark = pytest.mark.usefixtures("bare_page")


@pytest.fixture(scope="module")
def evening(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session of which a pose of each triad was recorded later; nobody changes it."""
    config, _ = quick_session(tmp_path_factory.mktemp("evening"))
    later = config.parent / "later"
    later.mkdir()
    for place, name in (("accelerometer", "pose_03.csv"), ("gyroscope/17rpm", "pose_07.csv")):
        (config.parent / place / name).rename(later / name)
    return config


@pytest.fixture
def session(evening: Path, tmp_path: Path) -> Path:
    shutil.copytree(evening.parent, tmp_path, dirs_exist_ok=True)
    return tmp_path / evening.name


def poses_of(config: Path) -> dict[str, int]:
    results = results_in(config.with_suffix(".run"))
    return {triad: results[triad]["n_poses"] for triad in ("accelerometer", "gyroscope")}


def test_each_log_joins_the_run_in_which_it_was_recorded(session: Path) -> None:
    later = session.parent / "later"
    code, out, _ = typed("import", *sorted(later.iterdir()), "--into", session)
    assert code == 0
    rows = [line.split("  ") for line in out.splitlines() if line.startswith("  later/")]
    assert [row[1] for row in rows] == ["later/pose_03.csv", "later/pose_07.csv"]
    assert "stopped" in out.splitlines()[1]
    assert "17rpm" in out.splitlines()[2]
    assert "mm/s²" in out
    assert poses_of(session) == {"accelerometer": 18, "gyroscope": 19}
    assert "gyroscope: 1 pose more at rest, as a run of its own" in out
    now = load_config(session)
    assert [path.name for path in now.accelerometer.at_rest[0].poses.files][-1] == "pose_03.csv"
    assert [path.name for path in now.gyroscope.runs[0].poses.files][-1] == "pose_07.csv"
    assert "accelerometer, 17 → 18 poses" in out
    code, _, err = typed("import", later / "pose_03.csv", "--into", session)
    assert code == 2
    assert "is in" in err


def test_the_direction_of_a_setting_is_that_of_its_poses_where_its_rate_states_none() -> None:
    turning = np.array([0.0, 0.0, 3.49])

    def recording(sign: float) -> Recording:
        means = [TriadMean(vector, np.zeros(3), np.zeros(3))
                 for vector in (np.array([0.0, 0.0, 9.8]), sign * turning)]
        return Recording((PoseMean("pose", *means, 0.0, 20.0, {}),), (0.0,), np.arange(1))

    runs = [RunSection.model_construct(poses=PosesSection.model_construct(files=(Path(name),)),
                                       rate=name, exclude=()) for name in ("fast", "back")]
    config = Config.model_construct(
        gyroscope=GyroscopeSection.model_construct(runs=tuple(runs)))
    rates = {name: SettingRate(name, PlateRate(name, np.full(1, 3.49), np.full(1, 1e-4), 0.0), (),
                               ()) for name in ("fast", "back")}
    recordings = Recordings({run.recorded: recording(sign)
                             for run, sign in zip(runs, (1.0, -1.0), strict=True)})
    assert Known.of(config, {}, rates, recordings).rates == {"fast": 3.49, "back": -3.49}


def test_poses_at_rest_become_a_run_of_the_gyroscope_where_it_has_none(session: Path) -> None:
    log = session.parent / "later/pose_03.csv"
    assert pipeline("import", log, "--into", session, "--triad", "gyroscope", "--quiet") == 0
    runs = yaml.safe_load(session.read_text(encoding="utf-8"))["gyroscope"]["runs"]
    assert runs[1] == {"poses": "later/pose_03.csv", "rate": "stopped"}
    assert poses_of(session) == {"accelerometer": 17, "gyroscope": 18}


def test_a_log_that_turns_at_a_rate_of_no_setting_is_refused_and_nothing_is_written(
    session: Path,
) -> None:
    log = session.parent / "later/pose_07.csv"
    table = np.loadtxt(log, delimiter=",", skiprows=1)
    names = log.read_text(encoding="utf-8").splitlines()[0].split(",")
    table[:, [names.index(f"gyr_{axis}") for axis in "xyz"]] *= 1.5
    rewrite_rows(log, table)
    before = session.read_text(encoding="utf-8")
    code, _, err = typed("import", log, "--into", session)
    assert code == 2
    assert "pose_07.csv: the plate turns at" in err
    assert "Bring the clip of it too" in err
    assert session.read_text(encoding="utf-8") == before


@pytest.mark.parametrize(("first", "last", "says"), [
    (0.5, 0.5, "pose_03.csv contradict those of all other poses"),
    (1.0, 0.9, "pose_03.csv: the sensor moved")])
def test_the_log_of_another_sensor_or_of_one_that_moved_is_refused_as_none_of_the_session(
    session: Path, first: float, last: float, says: str
) -> None:
    log = session.parent / "later/pose_03.csv"
    table = np.loadtxt(log, delimiter=",", skiprows=1)
    names = log.read_text(encoding="utf-8").splitlines()[0].split(",")
    table[:, [names.index(f"acc_{axis}") for axis in "xyz"]] *= np.linspace(
        first, last, len(table))[:, None]
    rewrite_rows(log, table)
    before = session.read_text(encoding="utf-8")
    code, _, err = typed("import", log, "--into", session)
    assert says in err
    assert code == 4
    assert "bring further logs without them" in err
    assert session.read_text(encoding="utf-8") == before


def test_the_name_of_an_excluded_pose_is_written_whole_where_a_new_one_has_it_too(
    session: Path,
) -> None:
    edit(session, "accelerometer/pose_*.csv\n", "accelerometer/pose_*.csv\n  exclude: [pose_05]\n")
    again = session.parent / "again"
    again.mkdir()
    (session.parent / "later/pose_03.csv").rename(again / "pose_05.csv")
    assert pipeline("import", again / "pose_05.csv", "--into", session, "--quiet") == 0
    assert load_config(session).accelerometer.exclude == ("accelerometer/pose_05.csv",)


@pytest.mark.parametrize("option", [["--latitude", "5"], ["--json"], ["--output", "x.yaml"]])
def test_what_the_session_states_is_not_stated_again(session: Path, option: list[str]) -> None:
    log = session.parent / "later/pose_03.csv"
    assert pipeline("import", log, "--into", session, *option) == 2
