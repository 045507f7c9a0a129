"""`pipeline noise` from a log to Kalibr's file."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from tests.calib.noise.simulated import noise
from tests.pipeline.conftest import RunSession
from tests.sessions import pipeline

STEP_S = 0.1
ACC, GYR = (2e-3, 5e-4, 1e-4), (1e-4, 4e-5, 1e-5)


@pytest.fixture(scope="module")
def still(tmp_path_factory: pytest.TempPathFactory) -> Path:
    rng = np.random.default_rng(7)
    path = tmp_path_factory.mktemp("noise") / "still.csv"
    columns = [STEP_S * np.arange(40_000)]
    columns += [noise(rng, 40_000, STEP_S, *ACC) + g for g in (0.1, -0.2, 9.8)]
    columns += [noise(rng, 40_000, STEP_S, *GYR) for _ in range(3)]
    np.savetxt(path, np.column_stack(columns), delimiter=",", comments="", fmt="%.9g",
               header="time_s,acc_x_m_s2,acc_y_m_s2,acc_z_m_s2,gyr_x_rad_s,gyr_y_rad_s,gyr_z_rad_s")
    return path


def test_the_four_numbers_reach_kalibr_with_their_units(
    still: Path, finished: RunSession, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "n"
    assert pipeline("noise", still, "--output", out) == 0
    said = capsys.readouterr().out
    assert re.search(r"noise density \[°/s/√Hz\] +0\.00\d+ ± 0\.0000\d\d  ", said)
    assert (out / "noise.svg").read_bytes().startswith(b"<?xml")
    assert (out / "noise.png").read_bytes().startswith(b"\x89PNG")
    assert pipeline("export", finished.folder, "--to", "kalibr", "--noise", out,
                    "--output", tmp_path) == 0
    read = yaml.safe_load((tmp_path / "imu.yaml").read_text(encoding="utf-8"))["imu0"]
    assert read["update_rate"] == pytest.approx(1 / STEP_S, rel=1e-4)
    for triad, (density, _, walk) in (("accelerometer", ACC), ("gyroscope", GYR)):
        assert read[f"{triad}_noise_density"] == pytest.approx(density, rel=0.03)
        assert read[f"{triad}_random_walk"] == pytest.approx(walk, rel=0.5)
    assert "missing in the file" not in capsys.readouterr().err


def test_json_is_the_file(still: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "few.csv"
    log.write_text("".join(still.read_text().splitlines(keepends=True)[:4000]))
    assert pipeline("noise", log, "--output", tmp_path, "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown == json.loads((tmp_path / "noise.json").read_text(encoding="utf-8"))
    assert shown["gyroscope"]["unit"] == "rad/s"


@pytest.mark.parametrize(("lines", "code", "message"), [
    (900, 4, "900 samples; at least 1000"), (0, 3, "."), (None, 3, "cannot be read"),
])
def test_a_log_too_short_determines_nothing_and_one_that_cannot_be_read_is_repaired(
    still: Path, tmp_path: Path, lines: int | None, code: int, message: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    log = tmp_path / "short.csv"
    if lines is not None:
        log.write_text("".join(still.read_text().splitlines(keepends=True)[: lines + bool(lines)]))
    assert pipeline("noise", log, "--output", tmp_path / "n") == code
    assert re.search(message, capsys.readouterr().err)
    assert not (tmp_path / "n").exists()


def test_noise_is_for_kalibr_alone_and_must_be_ours(
    finished: RunSession, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("export", finished.folder, "--to", "px4", "--noise", tmp_path) == 2
    assert pipeline("export", finished.folder, "--to", "kalibr", "--noise", tmp_path) == 3
    (tmp_path / "noise.json").write_text('{"format": 1, "rate_hz": -3}')
    assert pipeline("export", finished.folder, "--to", "kalibr", "--noise", tmp_path) == 3
    assert "not what `pipeline noise` writes" in capsys.readouterr().err
