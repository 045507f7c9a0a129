"""When to calibrate again: sensors that move, judged by what the simulated ones really err by."""

import json
import shutil
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calib.poses.attitudes import spread_directions
from pipeline.fleet.finish import finish_fleet
from pipeline.fleet.sessions import FleetSession, SessionRecord, folder_of, write_record
from pipeline.fleet.table import rows_of_results
from pipeline.results.ageing import DAY_S, Ageing, Pace, ageing_of, recorded_at
from pipeline.results.comparison import compare_calibrations
from pipeline.results.read import Stored, load_results
from tests.sessions import pipeline, run_without_page
from tests.world.designs import paper_design
from tests.world.imu import G_STANDARD, Triad
from tests.world.session import simulate
from tests.world.write import write_session

BEGIN_S = 1.75e9
STEP_COUNTS = np.array([25.0, -40.0, 15.0])


def aged(sessions: int) -> Triad:
    """The accelerometer after so many steps."""
    first = paper_design().sensor.accelerometer
    sign = [0.0, 1.0, 0.0, 1.0][sessions]
    return replace(first, offset=first.offset + sign * STEP_COUNTS)


def dated(folder: Path, day: float) -> Stored:
    """The results in ``folder`` as if its logs had begun on that day."""
    path = folder / "results.json"
    contents = json.loads(path.read_text(encoding="utf-8"))
    contents["session_start_s"] = BEGIN_S + day * DAY_S
    path.write_text(json.dumps(contents), encoding="utf-8")
    return load_results(folder)


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Four evenings: the sensor moves from each to the next, and two more of the first sensor."""
    root = tmp_path_factory.mktemp("ageing")
    made = []
    for k, age in enumerate([0, 1, 2, 3, 0, 0]):
        design = paper_design().scaled(seconds=0.5)
        design = replace(design, sensor=replace(design.sensor, accelerometer=aged(age)))
        config = write_session(root / str(k), simulate(design, 900 + k), film=False).config
        run_without_page(config)
        made.append(config.with_suffix(".run"))
    return made


def of_days(
    folders: list[Path], days: list[float], limit: float | None = None,
    steps: Sequence[int] | None = None,
) -> Ageing | None:
    """What the sessions show; ``steps`` are added to the biases that they came to."""
    stored = [dated(folder, day) for folder, day in zip(folders, days, strict=True)]
    for one, step in zip(stored, steps or [0] * len(stored), strict=True):
        one.triads[0].parameters.bias_counts[:] += step * STEP_COUNTS
    compared = compare_calibrations(stored)[0]
    return ageing_of(compared, [recorded_at(one) for one in stored], limit)


def true_change() -> float:
    """What a perfect calibration of the first sensor errs by on the moved one, rms, m/s²."""
    before, after = aged(0), aged(1)
    force = G_STANDARD * spread_directions(2000)
    counts = force @ (after.gain[:, None] * after.axes).T + after.offset
    corrected = (counts - before.offset) @ np.linalg.inv(before.gain[:, None] * before.axes).T
    error = np.linalg.norm(corrected, axis=1) - G_STANDARD
    return float(np.sqrt((error**2).mean()))


def test_what_moved_is_what_the_sensor_errs_by(folders: list[Path]) -> None:
    seen = of_days(folders[:4], [0.0, 10.0, 20.0, 30.0])
    assert seen is not None
    assert seen.days == pytest.approx(30.0)
    assert seen.moved == pytest.approx(true_change(), rel=0.1)
    assert seen.most == "bias y"
    pace = true_change() ** 2 / 10
    early, due, late = seen.due_days
    assert due == pytest.approx((seen.limit**2 - seen.now**2) / pace, rel=0.2)
    assert early < due < late


def test_a_sensor_that_ages_one_way_is_due_long_before_a_random_walk(folders: list[Path]) -> None:
    """Ten steps of the same size and sign make ten times the error, and a random walk √10."""
    seen = of_days([folders[0], folders[4], folders[5]], [0.0, 10.0, 20.0], 10 * true_change(),
                   steps=[0, 1, 2])
    assert seen is not None
    assert seen.is_steady
    assert seen.most == "bias y"
    early, due, late = seen.due_days
    assert early < due < late
    assert due == pytest.approx(100.0, rel=0.1)
    two = of_days([folders[0], folders[4]], [0.0, 10.0], 10 * true_change(), steps=[0, 1])
    assert two is not None
    assert not two.is_steady  # two sessions tell neither, and the range has both
    assert two.due_days[0] == pytest.approx(100.0, rel=0.1)
    assert two.due_days[1] == pytest.approx(1000.0, rel=0.2)


@pytest.mark.parametrize("steps", [2, 3, 6])
def test_a_random_walk_is_seldom_called_steady(steps: int) -> None:
    rng = np.random.default_rng(steps)
    called = []
    for _ in range(1000):
        days = rng.uniform(5, 60, steps)
        changes = np.zeros((steps, 9))
        changes[:, :3] = rng.normal(size=(steps, 3)) * np.sqrt(days)[:, None]
        called.append(Pace.of(changes, days, 1.0).is_steady)
    assert 0.03 < np.mean(called) < 0.07


def test_a_limit_that_is_stated_is_the_one_that_counts(folders: list[Path]) -> None:
    limit = 3 * true_change()
    seen = of_days(folders[:4], [0.0, 10.0, 20.0, 30.0], limit)
    assert seen is not None
    assert seen.due_days[1] == pytest.approx(90.0, rel=0.2)


def test_a_sensor_that_does_not_move_is_not_due(folders: list[Path]) -> None:
    seen = of_days([folders[0], folders[4], folders[5]], [0.0, 100.0, 200.0])
    assert seen is not None
    assert (seen.moved, seen.most) == (0.0, "")
    assert seen.due_days[0] > 30
    assert np.isinf(seen.due_days[1])


@pytest.mark.parametrize("days", [[0.0, 0.1], [0.0, np.nan]])
def test_of_one_evening_nothing_is_said(folders: list[Path], days: list[float]) -> None:
    stored = [load_results(folder) for folder in folders[:2]]
    compared = compare_calibrations(stored)[0]
    assert ageing_of(compared, [BEGIN_S + day * DAY_S for day in days]) is None


@pytest.fixture
def printed(
    folders: list[Path], capsys: pytest.CaptureFixture[str]
) -> Callable[..., tuple[int, str]]:
    """Exit code and words of ``pipeline compare`` on the four evenings."""
    def run(*options: str) -> tuple[int, str]:
        for folder, day in zip(folders, [0.0, 10.0, 20.0, 30.0], strict=False):
            dated(folder, day)
        code = pipeline("compare", *folders[:4], *options)
        words = capsys.readouterr()
        return code, " ".join((words.out + words.err).split())
    return run


def test_the_command_says_when(printed: Callable[..., tuple[int, str]]) -> None:
    code, words = printed("--limit", "accelerometer=500")
    assert code == 0
    assert "accelerometer: over 30 days corrected magnitudes moved by" in words
    assert "passes 5e+02 mm/s² after" in words or "passes 500 mm/s² after" in words
    assert "gyroscope: over 30 days nothing moved" in words
    code, words = printed("--json")
    assert json.loads(words)["accelerometer"]["ageing"]["most"] == "bias y"
    code, words = printed("--limit", "accelerometer=soon")
    assert code == 2
    assert "accelerometer=20" in words


@pytest.fixture(scope="module")
def fleet(folders: list[Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a fleet of two sensors: one moves between four evenings, one rests for two."""
    output = tmp_path_factory.mktemp("fleet")
    records = []
    for sensor, evenings in {"moves": [0, 1, 2, 3], "rests": [4, 5]}.items():
        for k, evening in enumerate(evenings):
            stored = dated(folders[evening], 10.0 * k)
            session = FleetSession(stored.folder, f"{sensor}/e{k}", sensor)
            record = SessionRecord(session.name, sensor, "", 0, "",
                                   rows_of_results(session, stored.contents))
            write_record(output, record)
            shutil.copy(stored.path, folder_of(output, session.name))
            records.append(record)
    finish_fleet(records, output, reports=False)
    return output


def test_a_fleet_shows_what_moved_in_which_sensor_and_when(
    fleet: Path, folders: list[Path]
) -> None:
    whole = json.loads((fleet / "population.json").read_text(encoding="utf-8"))
    seen = whole["accelerometer"]["over_time"]
    assert seen["moves"]["days"] == [0.0, 10.0, 20.0, 30.0]
    apart = seen["moves"]["moved"]
    assert set(apart) == {"bias x", "bias y", "bias z"}  # a step there, back, and there again
    assert apart["bias y"][1] < -10 < apart["bias y"][2] < 10 < -apart["bias y"][3]
    compared = of_days(folders[:4], [0.0, 10.0, 20.0, 30.0])
    assert compared is not None
    assert seen["moves"]["ageing"]["moved"] == compared.moved
    assert seen["rests"]["moved"] == {}
    assert whole["gyroscope"]["over_time"]["moves"]["moved"] == {}


def test_the_page_of_a_fleet_draws_the_sensors_the_one_that_moved_first(fleet: Path) -> None:
    page = (fleet / "fleet.html").read_text(encoding="utf-8")
    cards = page.split("Sensors over time</h3>")[1].split("</section>")[0].split("<figure")[1:]
    assert [card.partition("<figcaption>")[2].partition("<")[0] for card in cards] == [
        "moves", "rests"]
    assert cards[0].count('class="line axis') == 3
    assert "bias y by −" in cards[0]
    assert "recalibrate then" in cards[0]
    assert cards[1].count('class="line axis') == 0
    assert "Nothing moved by more than" in cards[1]
