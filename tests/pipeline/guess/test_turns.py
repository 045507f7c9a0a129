"""Whether turns of gravity are measured from rest to rest, and how a log of both is shown."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.console.import_text import guess_lines
from pipeline.guess.agreement import disagreements
from pipeline.guess.files import guess_files
from pipeline.guess.session import guess_session
from pipeline.guess.turns import turn_of
from tests.pipeline.guess.hand_log import GRAVITY_M_S2, hand_log

RATE_HZ = 100.0
WANDER_S, PUSH_S = 0.7, 0.15  #: correlation times of a hand's turns and of its pushes


def walk(seconds: float, sd: float, rng: np.random.Generator) -> np.ndarray:
    """Three components (t, 3) of 60 s that stay correlated for so long, with this sd."""
    keeps = np.exp(-1 / (RATE_HZ * seconds))
    values = [np.zeros(3)]
    for step in rng.normal(0, sd * np.sqrt(1 - keeps**2), (6000, 3)):
        values.append(keeps * values[-1] + step)
    return np.array(values[1:])


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("push_m_s2", [0.3, 1.0])
def test_a_log_that_never_rests_shows_no_unit(seed: int, push_m_s2: float) -> None:
    """Its stillest blocks are no rests: the unit between them came out wrong by up to 40 %."""
    rng = np.random.default_rng(seed)
    rate = walk(WANDER_S, 1.0, rng)
    attitude, up = np.eye(3), []
    for half in Rotation.from_rotvec(rate / RATE_HZ / 2).as_matrix():
        middle = attitude @ half
        up.append(middle[2] * GRAVITY_M_S2)
        attitude = middle @ half
    force = np.array(up) + walk(PUSH_S, push_m_s2, rng)
    turn = turn_of(rate + rng.normal(0, 0.002, rate.shape), force, np.zeros(6000, np.int64), 0.01)
    assert turn is not None
    assert not turn.is_exact


def test_a_table_at_rest_and_on_the_plate_is_shown_once(tmp_path: Path) -> None:
    log = hand_log(rests=8)
    np.savetxt(tmp_path / "log.csv", np.column_stack([log.time_s, log.acc, log.gyr]), "%.5f", ",",
               header="time_s,ax,ay,az,gx (rad/s),gy (rad/s),gz (rad/s)", comments="")
    guess = guess_session(guess_files([tmp_path / "log.csv"], None)[0])
    source, = guess.sources
    turning = replace(source, rate="45rpm", rate_rad_s=45 * np.pi / 30)
    lines = guess_lines(replace(guess, sources=(source, turning)))
    assert [line for line in lines if "the static intervals are the poses" in line] == [
        "1 table, at rest, turning at +45 rpm: the static intervals are the poses"]


def test_a_clock_in_ticks_tells_no_speed_but_the_rates_that_known_ranges_have(
    tmp_path: Path
) -> None:
    """10 µs a tick, which is read as 1 µs, at ±1000 °/s."""
    log = hand_log()
    counts = np.column_stack([log.acc / GRAVITY_M_S2 * 8192, np.degrees(log.gyr) * 32.768])
    np.savetxt(tmp_path / "log.csv", np.column_stack([1e5 * log.time_s, counts]), "%.0f",
               ",", header="sensortime,ax,ay,az,gx,gy,gz", comments="")
    guess = guess_session(guess_files([tmp_path / "log.csv"], None)[0])
    fault, = disagreements(guess)
    assert "°/s, and no sensor's is as wide" in fault
    assert "100 for ±1000 °/s" in fault
    assert "1 table, at rest or turning, by what unit the gyroscope has" in "\n".join(
        guess_lines(guess))
    assert not [doubt for doubt in guess.doubts if "record player" in doubt]


@pytest.mark.parametrize(("late_every", "lost", "unit"), [
    (3, (3.0, 3.0), "32.768 per °/s"), (3, (0.0, 2.0), "32.768 per °/s"),
    (1, (2.0, 2.5), "of a range that is open"),
], ids=["rate", "rate_and_rests", "half_of_each_turn"])
def test_a_logger_that_changes_its_rate_or_pauses_shows_no_wrong_range(
    tmp_path: Path, late_every: int, lost: tuple[float, float], unit: str
) -> None:
    log = hand_log()
    late = log.time_s > log.time_s[-1] / 2
    here = log.time_s % (9 if lost[0] < 2 else 3)
    kept = (late & (late_every > 1) | (np.arange(len(late)) % late_every == 0)
            & ((here < lost[0]) | (here > lost[1])))
    counts = np.column_stack([log.acc / GRAVITY_M_S2 * 8192, np.degrees(log.gyr) * 32.768])
    np.savetxt(tmp_path / "log.csv", np.column_stack([1e3 * log.time_s, counts])[kept], "%.0f",
               ",", header="ms,ax,ay,az,gx,gy,gz", comments="")
    table, = guess_session(guess_files([tmp_path / "log.csv"], None)[0]).tables
    assert table.gyroscope is not None
    assert table.gyroscope.unit == f"counts, {unit}, twos-complement"
