"""Tables of pose means, and several logs of one sensor."""

from pathlib import Path

import numpy as np
import pytest

from calib.errors import UnusableLog
from calib.planning.prospect import Prospect
from pipeline.cli import main
from pipeline.config.load import load_config
from pipeline.plan.outlook import plan_of
from pipeline.stages.context import RunContext
from pipeline.stages.run import Outcome, run_stages
from tests.pipeline.guess.hand_log import hand_log

pytestmark = pytest.mark.usefixtures("bare_page")

SESSION = """\
sensor: {accelerometer: {unit: m_s2}}
site: {gravity_m_s2: 9.80665}
accelerometer:
  poses: {%s}
  model: [bias, scale, misalignment]
"""
SCALE, BIAS = np.array([1.02, 0.98, 1.01]), np.array([0.12, -0.2, 0.25])
SD = 0.002


def directions(n: int) -> np.ndarray:
    vectors = np.random.default_rng(3).normal(size=(n, 3))
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def means(repeats: int, seed: int = 0, cubic: float = 0.0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    true = 9.80665 * np.repeat(directions(14), repeats, axis=0)
    return np.asarray((true + cubic * true**3) * SCALE + BIAS + rng.normal(0, SD, true.shape))


def run(folder: Path, head: str, rows: np.ndarray) -> Outcome:
    np.savetxt(folder / "means.csv", rows, delimiter=",", header=head, comments="")
    config = folder / "config.yaml"
    config.write_text(SESSION % "means: means.csv")
    return run_stages(load_config(config), RunContext())


HEAD = "acc_x,acc_y,acc_z"
WITH_SD = f"{HEAD},sd_acc_x,sd_acc_y,sd_acc_z"


def test_stated_sds_are_the_sds_of_the_poses(tmp_path: Path) -> None:
    rows = means(2)
    outcome = run(tmp_path, WITH_SD, np.hstack([rows, np.full_like(rows, SD)]))
    assert outcome.triad("accelerometer") is not None
    fit = outcome.triad("accelerometer").calibration.fit
    np.testing.assert_allclose(fit.poses.sd, SD)
    np.testing.assert_allclose(outcome.triad("accelerometer").calibration.parameters.scale_counts_per_unit,
                               SCALE, atol=0.002)
    assert outcome.triad("accelerometer").diagnosis.verdict == "nothing_missing"


@pytest.mark.parametrize("has_sds", [True, False])
def test_the_plan_of_tabled_means_has_their_noise_and_their_labels_are_no_cause(
    has_sds: bool, tmp_path: Path
) -> None:
    rows = np.hstack([np.arange(28.0)[:, None], means(2)])
    if has_sds:
        rows = np.hstack([rows, np.full((28, 3), SD)])
    outcome = run(tmp_path, f"label,{WITH_SD if has_sds else HEAD}", rows)
    poses = outcome.triad("accelerometer").calibration.fit.poses
    assert not poses.columns
    (plan,) = plan_of(load_config(tmp_path / "config.yaml"))
    assert isinstance(plan.at_hand, Prospect)
    assert isinstance(plan.complete, Prospect)
    for outlook in (plan.at_hand, plan.complete):
        np.testing.assert_allclose(np.median(outlook.fit.poses.sd, axis=0),
                                   np.median(poses.sd, axis=0), rtol=1e-3)
    assert np.isfinite(plan.next_pose.shrinks)


@pytest.mark.parametrize("times", [1.0, 10.0])
def test_sds_of_single_samples_in_a_table_are_told(times: float, tmp_path: Path) -> None:
    rows = means(2)
    outcome = run(tmp_path, WITH_SD, np.hstack([rows, np.full_like(rows, times * SD)]))
    said = [one for one in outcome.warnings if "those of single samples" in one]
    assert len(said) == (times > 1)


@pytest.mark.parametrize("decimals", [1, 2])
def test_the_digits_of_a_table_belong_to_its_sds(decimals: int, tmp_path: Path) -> None:
    noise = np.random.default_rng(4).normal(0, SD, (28, 3))
    rows = 9.80665 * directions(28) * SCALE + BIAS + noise
    rounded = np.round(rows, decimals)
    table = np.hstack([rounded, np.full_like(rows, SD)])
    triad = run(tmp_path, WITH_SD, table).triad("accelerometer")
    assert triad is not None
    fit = triad.calibration.fit
    off = np.sqrt(np.mean((rounded - rows) ** 2) + SD**2)
    assert fit.poses.sd == pytest.approx(np.full_like(rows, off / SCALE.mean()), rel=0.1)
    assert 0.5 < fit.chi2 / fit.dof < 1.6
    assert triad.diagnosis.verdict == "nothing_missing"


def test_sds_of_samples_are_divided_by_their_number(tmp_path: Path) -> None:
    rows = means(2)
    table = np.hstack([rows, np.full_like(rows, 10 * SD), np.full((len(rows), 1), 100)])
    outcome = run(tmp_path, f"{WITH_SD},samples", table)
    assert outcome.triad("accelerometer") is not None
    np.testing.assert_allclose(outcome.triad("accelerometer").calibration.fit.poses.sd, SD)


@pytest.mark.parametrize("damaged", [1e10, 1e300])
@pytest.mark.parametrize(
    "unit", ["unit: m_s2", "full_scale_g: 2, bits: 16, encoding: offset-binary"])
def test_a_mean_that_no_sensor_reads_is_refused_with_its_row(
    damaged: float, unit: str, tmp_path: Path
) -> None:
    rows = means(2)
    rows[4, 1] = damaged
    np.savetxt(tmp_path / "means.csv", rows, delimiter=",", header=HEAD, comments="")
    config = tmp_path / "config.yaml"
    config.write_text((SESSION % "means: means.csv").replace("unit: m_s2", unit))
    with pytest.raises(UnusableLog, match=r"means.csv row 5: (the )?accelerometer (reads|counts)"):
        run_stages(load_config(config), RunContext())


def test_repeated_attitudes_show_the_noise_that_was_not_stated(tmp_path: Path) -> None:
    estimates = []
    for seed in range(8):
        outcome = run(tmp_path, HEAD, means(3, seed))
        assert outcome.triad("accelerometer") is not None
        estimates.append(outcome.triad("accelerometer").calibration.fit.poses.sd[0, 0])
        assert any("have no sds" in warning for warning in outcome.warnings)
    assert np.sqrt(np.mean(np.square(estimates))) == pytest.approx(SD, rel=0.15)


def test_by_repeated_attitudes_a_missing_effect_is_still_seen(tmp_path: Path) -> None:
    outcome = run(tmp_path, HEAD, means(3, cubic=3e-5))
    assert outcome.triad("accelerometer") is not None
    assert outcome.triad("accelerometer").diagnosis.verdict != "nothing_missing"
    assert outcome.triad("accelerometer").calibration.fit.p_value < 1e-4


@pytest.mark.parametrize("cubic", [0.0, 3e-5])
def test_without_sds_and_repeats_the_model_is_not_judged(tmp_path: Path, cubic: float) -> None:
    outcome = run(tmp_path, HEAD, means(1, cubic=cubic))
    assert outcome.triad("accelerometer") is not None
    diagnosis = outcome.triad("accelerometer").diagnosis
    assert diagnosis.verdict == "refused"
    assert "cannot be determined" in diagnosis.text
    assert diagnosis.addable == ()


def test_the_results_of_means_are_written_and_shown(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run(tmp_path, HEAD, means(1))
    assert main(["run", str(tmp_path / "config.yaml")]) == 0
    assert "Whether something is missing cannot be determined" in capsys.readouterr().out


def test_two_logs_of_one_sensor_are_pooled_and_not_joined(tmp_path: Path) -> None:
    for i in range(2):
        log = hand_log(seed=i, rests=9)
        np.savetxt(tmp_path / f"{i}.csv", np.column_stack([log.time_s, log.acc]), delimiter=",",
                   header=f"time_s,{HEAD}", comments="", fmt="%.6f")
    config = tmp_path / "config.yaml"
    config.write_text(SESSION % "log: [0.csv, 1.csv], find: still")
    outcome = run_stages(load_config(config), RunContext())
    assert outcome.triad("accelerometer") is not None
    assert len(outcome.triad("accelerometer").calibration.fit.poses) == 18
    assert not [warning for warning in outcome.warnings if "pooled" in warning]
    np.testing.assert_allclose(outcome.triad("accelerometer").calibration.parameters.scale_counts_per_unit,
                               SCALE, atol=0.002)
