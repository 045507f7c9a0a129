"""The outlook before recording is what recording then gives."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from calib.diagnosis.next_measurement.ideal_poses import (
    PlannedRun,
    expected_widening,
    ideal_poses,
    one_second_sd,
)
from calib.effects.catalogue import BASE
from calib.errors import Undetermined
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.planning.prospect import WEDGE, best_pose, prospect_of
from calib.poses.attitudes import natural_directions
from calib.poses.imu_log import Triad
from calib.poses.reference import CommonError, tilt_name
from calib.poses.runs.ring import DIRECTION_SD_RAD
from pipeline.stages.pose_means import first_directions
from tests.fitting import Calibrated, averaged, calibrated, spec_of, tilted_pose_sets
from tests.sessions import configured, pipeline, typed
from tests.world.designs import SLOW, paper_design, tilted_design
from tests.world.imu import Sensor, mpu6050, mti
from tests.world.session import Session, simulate
from tests.world.write import write_session

GRAVITY = 9.80267
SESSIONS = 12
MODEL = Model.of(BASE)
SENSORS = {"mti": mti, "mpu6050": mpu6050}


@cache
def evening(sensor: str, seed: int) -> tuple[Session, Calibrated]:
    """The paper's session of a sensor, calibrated; both triads and the outlook look at the same."""
    session = simulate(paper_design(SENSORS[sensor]()), seed)
    return session, calibrated(session)


def specs_of(sensor: Sensor) -> dict[Triad, object]:
    return {"accelerometer": spec_of(sensor.accelerometer, sensor.accelerometer.full_scale),
            "gyroscope": spec_of(sensor.gyroscope, sensor.gyroscope.full_scale)}


def planned(triad: Triad, up: np.ndarray = WEDGE, sd: float = 1e-3, **changes: float) -> PlannedRun:
    """Poses under gravity at rest, or at 16 2/3 rpm."""
    turning = triad == "gyroscope"
    run = PlannedRun(
        "17rpm" if turning else "stopped", up, SLOW if turning else GRAVITY,
        SLOW if turning else 0.0, np.full(3, sd), 0.0,
        (CommonError("rate 17rpm", 50e-6 * SLOW, of_setting=True),) if turning else (), GRAVITY,
        30.0 * np.arange(len(up)))
    return replace(run, **changes)


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
@pytest.mark.parametrize("name", SENSORS)
def test_predicted_sds_are_those_obtained_within_ten_per_cent(name: str, triad: Triad) -> None:
    """Noise as the sensor has it; each obtained sd scatters by a tenth, their median does not."""
    sensor = SENSORS[name]()
    truth = getattr(sensor, triad)
    turn_s = 2 * np.pi / SLOW
    seconds = 8.0 if triad == "accelerometer" else np.floor(20 / turn_s) * turn_s
    sd = truth.pose_mean_sd(round(seconds * 100), 0.01) * expected_widening(18)
    run = replace(planned(triad), sd=sd)
    predicted = prospect_of(ideal_poses(triad, [run]), MODEL, specs_of(sensor)[triad]).sd
    obtained = []
    for seed in range(SESSIONS):
        found = getattr(evening(name, seed)[1], triad)
        misalignment, bias, scale = found.parameters.sd
        per_unit = found.parameters.scale_counts_per_unit
        obtained.append(np.array([misalignment, bias / per_unit, scale / per_unit])
                        / found.widening)
    ratio = predicted / np.median(obtained, axis=0)
    assert np.abs(np.median(ratio, axis=1) - 1).max() < 0.10  # misalignment, bias, scale
    assert np.abs(ratio - 1).max() < 0.15  # the median of twelve still scatters by four per cent


def test_a_plan_knows_what_goes_round_on_a_plate_that_leans() -> None:
    """Nine mountings at 20°; each obtained sd scatters by a tenth, their medians less."""
    sensor, tilt = mpu6050(), np.radians(20.0)
    model = {"accelerometer": MODEL, "gyroscope": Model.of([*BASE, "g_sensitivity"])}
    obtained: dict[str, list[np.ndarray]] = {triad: [] for triad in model}
    for seed in range(4):
        session = simulate(replace(tilted_design(20.0), sample_rate_hz=50.0), seed)
        *sets, _ = tilted_pose_sets(session)
        for poses, each in zip(sets, model, strict=True):
            obtained[each].append(np.sqrt(np.diag(fit(poses, model[each]).cov)))
    up, turn_s = first_directions(9), 2 * np.pi / SLOW
    seconds = np.floor(20 / turn_s) * turn_s
    for triad, each in model.items():
        truth = getattr(sensor, triad)
        sd = truth.pose_mean_sd(round(seconds * 50), 0.02) * expected_widening(9)
        run = planned(triad, up, tilt_rad=tilt, sd=sd)
        if triad == "accelerometer":
            run = replace(run, magnitude=GRAVITY * np.cos(tilt), common=(
                CommonError(tilt_name(run.name), -GRAVITY * np.sin(tilt) * DIRECTION_SD_RAD),))
        predicted = prospect_of(ideal_poses(triad, [run]), each, specs_of(sensor)[triad])
        ratio = np.sqrt(np.diag(predicted.fit.cov)) / np.median(obtained[triad], axis=0)
        assert np.median(ratio) == pytest.approx(1, abs=0.15)
        assert np.abs(ratio - 1).max() < 0.4
        assert predicted.d_efficiency > 0.5  # by the pose, not by its ten rows
        assert "g_sensitivity" not in predicted.blind


def test_noise_of_a_few_poses_predicts_the_rest() -> None:
    sensor = mpu6050()
    specs = (specs_of(sensor)["accelerometer"], specs_of(sensor)["gyroscope"])
    ratios = []
    for seed in range(SESSIONS):
        session, both = evening("mpu6050", seed)
        first = averaged(session.runs[0], specs, 0.0)[:6]
        sd = one_second_sd([first], "accelerometer") / np.sqrt(7.99)
        run = replace(planned("accelerometer"), sd=sd)
        predicted = prospect_of(ideal_poses("accelerometer", [run]), MODEL, specs[0]).sd
        found = both.accelerometer
        ratios.append(predicted[0] / (found.parameters.sd[0] / found.widening))
    assert np.median(ratios) == pytest.approx(1, abs=0.10)


def test_the_wedge_is_the_measure_of_efficiency_and_conditioning() -> None:
    spec = specs_of(mpu6050())["accelerometer"]
    prospect = prospect_of(ideal_poses("accelerometer", [planned("accelerometer")]), MODEL, spec)
    assert prospect.dof == 9
    assert prospect.condition == pytest.approx(1.4, abs=0.05)
    assert prospect.d_efficiency == pytest.approx(1)
    half = WEDGE[WEDGE[:, 2] >= 0]
    fewer = prospect_of(ideal_poses("accelerometer", [planned("accelerometer", half)]), MODEL, spec)
    assert fewer.d_efficiency < 0.9
    assert (fewer.sd > 0.999 * prospect.sd).all()
    assert fewer.sd[1, 2] > 8 * prospect.sd[1, 2]  # z has been seen from one side only


@pytest.mark.parametrize(("up", "says"), [
    (WEDGE[:6], "at least 10 are needed"),
    (np.repeat(WEDGE[:6], 3, axis=0), "do not determine|condition number"),
])
def test_poses_that_would_be_refused_are_refused_before(up: np.ndarray, says: str) -> None:
    spec = specs_of(mpu6050())["accelerometer"]
    with pytest.raises(Undetermined, match=says):
        prospect_of(ideal_poses("accelerometer", [planned("accelerometer", up)]), MODEL, spec)


def test_what_level_poses_at_one_speed_cannot_see_is_blind() -> None:
    spec = specs_of(mpu6050())["gyroscope"]
    one = planned("gyroscope")
    prospect = prospect_of(ideal_poses("gyroscope", [one]), MODEL, spec)
    assert "g_sensitivity" in prospect.blind
    assert any({"quadratic", "asymmetry"} <= {*group} for group in prospect.aliases)
    stopped = replace(one, name="stopped", magnitude=0.0, spin_rad_s=0.0, common=(),
                      reference_sd=4e-5, time_s=one.time_s + 600)
    more = prospect_of(ideal_poses("gyroscope", [one, stopped]), MODEL, spec)
    assert "g_sensitivity" not in more.blind
    assert "g_sensitivity" not in more.partly


def test_only_columns_that_may_cause_an_error_are_judged() -> None:
    warmth = {"temperature_c": np.linspace(20.0, 30.0, len(WEDGE)),
              "supply_v": np.tile([3.3, 3.2], len(WEDGE) // 2)}
    spec = specs_of(mpu6050())["accelerometer"]
    poses = ideal_poses("accelerometer", [planned("accelerometer")])
    alike = replace(poses, columns={**warmth, "other_v": warmth["supply_v"]})
    group = {"column:other_v", "column:supply_v"}
    assert any(group <= {*each} for each in prospect_of(alike, MODEL, spec).aliases)
    left = prospect_of(alike, MODEL, spec, (), ["supply_v", "temperature_c"])
    assert not any("column:other_v" in each for each in left.aliases)


def test_the_next_best_pose_is_where_poses_are_missing() -> None:
    half = natural_directions()[natural_directions()[:, 0] <= 0.1]
    best = best_pose("accelerometer", [planned("accelerometer", half)], MODEL)
    assert best is not None
    assert best.up[0] > 0.5
    assert best.shrinks < 1
    # It is the best: no other direction shrinks the volume of the sds more.
    spec = specs_of(mpu6050())["accelerometer"]

    def volume(up: np.ndarray) -> float:
        run = planned("accelerometer", np.vstack([half, up]))
        fit = prospect_of(ideal_poses("accelerometer", [run]), MODEL, spec).fit
        return float(np.linalg.slogdet(fit.cov)[1])

    every = [volume(up) for up in natural_directions()]
    assert volume(best.up) == pytest.approx(min(every), abs=1e-6)


def test_the_next_planned_pose_is_the_missing_one_that_is_worth_most_per_minute() -> None:
    up = natural_directions()
    order = np.random.default_rng(0).permutation(len(up))
    runs = [planned("accelerometer", up[order])]
    best = best_pose("accelerometer", runs, MODEL, [12], [0.5])
    assert best is not None
    assert best.minutes == 0.5
    spec = specs_of(mpu6050())["accelerometer"]

    def volume(rows: np.ndarray) -> float:
        run = planned("accelerometer", up[order[rows]])
        fit = prospect_of(ideal_poses("accelerometer", [run]), MODEL, spec).fit
        return float(np.linalg.slogdet(fit.cov)[1])

    there = np.arange(12)
    every = {k: volume(np.append(there, k)) for k in range(12, len(up))}
    where = int(np.flatnonzero((up[order] == best.up).all(axis=1))[0])
    assert every[where] == pytest.approx(min(every.values()), abs=1e-6)
    assert 2 * 9 * np.log(best.shrinks) == pytest.approx(every[where] - volume(there), abs=1e-6)
    both = [*runs, replace(runs[0], name="slow")]
    for minutes, name in (([0.5, 2.0], runs[0].name), ([2.0, 0.5], "slow")):
        quick = best_pose("accelerometer", both, MODEL, [12, 12], minutes)
        assert quick is not None
        assert quick.run == name
    assert best_pose("accelerometer", runs, MODEL, [len(up)]) is None


def plan(config: Path, *options: str) -> str:
    code, printed, errors = typed("plan", config, *options)
    assert (code, errors) == (0, "")
    return printed


NEW = """\
sensor: mpu-6050
site: {latitude_deg: 40.85}
rate: {fast: {rate_rad_s: 4.712, sd_rad_s: 1e-4}}
accelerometer: {poses: acc/pose_*.csv}
gyroscope: {runs: [{poses: gyr/pose_*.csv, rate: fast}]}
record: {device: mpu-6050}
"""


def test_before_the_first_pose_the_plan_goes_by_the_data_sheet(tmp_path: Path) -> None:
    config = tmp_path / "c.yaml"
    config.write_text(NEW)
    text = plan(config, "--effect", "g_sensitivity")
    assert "accelerometer: 0 poses recorded, 18 missing" in text
    assert "typical noise of this sensor" in text
    assert "270 °/s and the gyroscope reads up to ±250 °/s: it saturates" in text
    assert "for g_sensitivity record: the same poses with the plate stopped" in text


def test_both_triads_from_the_plate_are_planned_on_a_plate_that_leans(tmp_path: Path) -> None:
    assert pipeline("init", tmp_path, "--tilted") == 0
    assert "5 cm under one side" in (tmp_path / "leaning.svg").read_text()
    first = (tmp_path / "config.yaml").read_text().splitlines()[0]
    assert "a sensor in nine poses on a turning plate that leans" in first
    text = plan(tmp_path / "config.yaml")
    assert text.count("0 poses recorded, 9 missing") == 2
    assert text.count("0 recorded, 9 missing, 20 s each") == 2
    assert text.count("at 16.67 rpm; put 5 cm under one side of the record player, which") == 2
    assert "g_sensitivity" not in text


@pytest.mark.parametrize("command", ["check", "plan"])
def test_planned_poses_that_determine_nothing_are_refused_before_recording(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = configured(tmp_path, NEW.replace("record: {", "record: {poses: 6, "))
    assert pipeline(command, config, "--json") == 4
    printed = capsys.readouterr()
    assert "6 poses give 6 equations for 9 parameters" in printed.err
    assert printed.err.count("faces and edges") == 1
    read = json.loads(printed.out)
    if command == "plan":
        assert read["accelerometer"]["complete"]["determined"] is False
    else:
        assert read["exit_code"] == 4
        assert read["problems"] == [printed.err.strip()]
    config.write_text(NEW)
    assert pipeline(command, config, "--quiet") == (3 if command == "check" else 0)
    assert capsys.readouterr().out == ""


def test_half_a_session_is_judged_with_and_without_the_rest(tmp_path: Path) -> None:
    written = write_session(tmp_path, simulate(paper_design(), 3), film=False)
    for number in range(13, 19):
        (tmp_path / "accelerometer" / f"pose_{number:02d}.csv").unlink()
    config = written.config
    config.write_text(config.read_text() + "record: {device: xsens-mti, seconds_per_pose: 8}\n")
    text = plan(config)
    assert "accelerometer: 12 poses recorded, 6 missing" in text
    assert "noise of the recorded poses" in text
    (freedom,) = [line for line in text.splitlines() if "degrees of freedom" in line][:1]
    assert freedom.split()[-2:] == ["3", "9"]


def test_what_is_at_hand_is_predicted_as_the_calibration_states_it(tmp_path: Path) -> None:
    session = simulate(paper_design(mpu6050()), 3)
    text = plan(write_session(tmp_path, session, film=False).config)
    found = calibrated(session).accelerometer
    stated = next(line for line in text.splitlines() if "sd of misalignment" in line).split()[-3:]
    np.testing.assert_allclose(np.array(stated, dtype=float),
                               found.parameters.sd[0] / found.widening, rtol=0.06)
