"""Verdicts on measured sessions hold for stops that took no part in them.

``python -m tests.studies.real_sets`` prints all of them; the logs are not part of the project.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.studies.real_sets.__main__ import judgement
from tests.studies.real_sets.independent import (
    best_step,
    judge_accelerometer,
    judge_gyroscope,
    weighted,
)
from tests.studies.real_sets.logs import LOGS, REAL, Stops, stops_of
from tests.studies.real_sets.pose_means import fit_means
from tests.studies.real_sets.program import (
    Said,
    ask,
    ask_means,
    ask_turntable,
    corrected_magnitude,
    without_each_face,
)
from tests.studies.real_sets.turntable import fit_turntable

pytestmark = pytest.mark.skipif(not REAL.is_dir(), reason=f"no measured logs in {REAL}")


@cache
def said(name: str) -> Said:
    return ask(LOGS[name])


@cache
def stops(name: str) -> Stops:
    return stops_of(LOGS[name])


@pytest.mark.parametrize("name", LOGS)
def test_stops_left_out_do_not_contradict_the_verdict(name: str) -> None:
    accelerometer, gyroscope = said(name).accelerometer, said(name).gyroscope
    assert accelerometer is not None or said(name).refusal
    if accelerometer is not None:
        judged = best_step(judge_accelerometer(stops(name), LOGS[name].gravity))
        assert not judgement(accelerometer, judged).startswith("NO")
    if gyroscope is not None:
        judged = best_step(judge_gyroscope(stops(name)))
        assert not judgement(gyroscope, judged).startswith("NO")


@pytest.mark.parametrize(("name", "triad", "verdict", "names"), [
    ("xsens", "gyroscope", "effect", ("g_sensitivity",)),
    ("sundevil short", "gyroscope", "effect", ("bias_step",)),
    ("sundevil long", "accelerometer", "nothing_missing", ()),
])
def test_what_left_out_stops_show_is_what_is_said(
    name: str, triad: str, verdict: str, names: tuple[str, ...]
) -> None:
    found = getattr(said(name), triad).diagnosis
    assert (found.verdict, found.names) == (verdict, names)


def test_an_effect_beside_what_no_effect_explains_is_offered() -> None:
    """`quadratic` lowers the error of stops left out by 25 %, and a misfit of p < 1e-3 stays."""
    found = said("ck").accelerometer
    assert found is not None
    assert found.diagnosis.verdict == "ambiguous"
    assert "quadratic" in found.diagnosis.group


def test_no_gyroscope_in_a_hand_is_named_the_earth() -> None:
    """It turns with the hand, five times as fast as the Earth at its quietest."""
    for name in ("snu good1", "snu good2", "snu good3", "sundevil units"):
        found = said(name).gyroscope
        assert found is not None
        assert "earth_rate" not in (*found.diagnosis.names, *found.diagnosis.group)


def test_two_sessions_in_one_log_do_not_name_the_earth_either(tmp_path: Path) -> None:
    """A vertical rate of 79 °/h would explain them; the Earth has 15."""
    parts, begins_s = [], 0.0
    for file in (LOGS["snu good2"].files[0], LOGS["snu good3"].files[0]):
        rows = np.loadtxt(REAL / file)
        rows[:, 0] += begins_s - rows[0, 0]
        begins_s = rows[-1, 0] + 30.0
        parts.append(rows)
    np.savetxt(tmp_path / "both.txt", np.vstack(parts), fmt="%.7g")
    both = replace(LOGS["snu good2"], files=(str(tmp_path / "both.txt"),))
    found = ask(both).gyroscope
    assert found is not None
    assert "earth_rate" not in (*found.diagnosis.names, *found.diagnosis.group)


@pytest.mark.parametrize(("one", "other"), [
    ("snu good3", "snu good2"), ("snu good3", "snu good1"), ("snu good2", "snu good3"),
    ("sundevil long", "sundevil short"),
])
def test_the_stated_error_holds_for_the_sensor_s_next_session(
    one: str, other: str
) -> None:
    result = said(one).accelerometer
    assert result is not None
    assert result.prediction is not None
    sd = weighted(stops(other))
    off = corrected_magnitude(result, stops(other).force) - LOGS[other].gravity
    rms = np.sqrt(np.average(off**2, weights=sd**-2))
    alone = np.sqrt(len(off) / np.sum(sd**-2))
    assert rms < 1.5 * np.hypot(result.prediction.sd_median, alone)


@pytest.mark.parametrize("name", ["xsens", "snu good3", "sundevil long"])
def test_a_session_that_lost_a_face_is_never_called_good(name: str) -> None:
    result = said(name).accelerometer
    assert result is not None
    for lost in without_each_face(result):
        assert not lost.said_good, lost
        assert np.isnan(lost.stated) or lost.error < 2.5 * lost.stated


def test_the_gyroscope_on_a_record_player_has_the_gains_of_an_independent_fit() -> None:
    result, fitted = ask_turntable(), fit_turntable()
    gain = result.calibration.parameters.scale_counts_per_unit
    assert gain == pytest.approx(fitted.gain, abs=0.002)
    # The plate's rate scatters by 4e-4 from pose to pose, the bias at rest by three sds of a pose.
    assert result.diagnosis.names == ()
    assert result.diagnosis.verdict == "noise"


def test_a_table_of_pose_means_has_the_fit_of_scipy_and_no_name() -> None:
    result, fitted = ask_means(), fit_means()
    gain = result.calibration.parameters.scale_counts_per_unit
    assert gain == pytest.approx(fitted.scale, rel=1e-4)
    assert result.comparison.loo_rms == pytest.approx(fitted.left_out, rel=0.05)
    assert result.diagnosis.names == ()
