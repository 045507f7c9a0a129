"""`pipeline rate --flutter`, `--gyro`, `--page` and `--csv` as they are typed."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests import sessions
from tests.paths import DATA
from tests.pipeline.report.html_page import Page

CLIP = DATA / "example/video/17rpm.mp4"
RATE = 16.7015 * 2 * np.pi / 60
Typed = Callable[..., tuple[int, str, str]]


@pytest.fixture
def typed(capfdbinary: pytest.CaptureFixture[bytes]) -> Typed:
    """A command: its exit code, what it printed, and what it said on standard error."""
    def type_it(*words: str | Path) -> tuple[int, str, str]:
        code = sessions.pipeline("rate", *words)
        done = capfdbinary.readouterr()
        return code, done.out.decode(), done.err.decode()

    return type_it


def platter_log(folder: Path, rate_rad_s: float = RATE) -> Path:
    """A gyroscope on its edge on the platter, in rad/s: 0.2 % at 4 Hz, a bias, gravity across."""
    rng = np.random.default_rng(2)
    time = np.arange(0, 30, 0.01)
    speed = rate_rad_s * (1 + 2e-3 * np.sin(2 * np.pi * 4 * time))
    gyro = np.outer(speed, [0.6, 0.0, 0.8]) + 1e-4 * rng.standard_normal((len(time), 3))
    acc = np.tile([5.88, 0.0, 7.84], (len(time), 1)) + 0.02 * rng.standard_normal((len(time), 3))
    log = folder / "platter.csv"
    np.savetxt(log, np.column_stack([time, acc, gyro]), "%.8g", ",", comments="",
               header="time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z")
    return log


CONFIG = """\
sensor:
  name: a board
  accelerometer: {unit: m_s2}
  gyroscope: {unit: rad_s}
rate: {slow: {rate_rad_s: 1.749, sd_rad_s: 0.001}}
"""


def test_clip_and_gyroscope_are_printed_and_drawn(tmp_path: Path, typed: Typed) -> None:
    log, page = platter_log(tmp_path), tmp_path / "platter.html"
    (tmp_path / "config.yaml").write_text(CONFIG, encoding="utf-8")
    code, out, _ = typed(CLIP, "--flutter", "--gyro", log, "--config", tmp_path / "config.yaml",
                         "--page", page, "--json")
    assert code == 0
    clip, gyro = json.loads(out)["flutter"]
    assert (clip["by"], gyro["by"]) == ("clip", "gyroscope")
    assert gyro["platter_aes6_weighted"] == pytest.approx(0.997 * 2e-3, rel=0.02)
    assert gyro["scale_error"] == pytest.approx(0.0, abs=1e-3)
    assert clip["noise_weighted"] > 0
    assert "rate_rad_s" in json.loads(out)["17rpm"]
    html = Page(page.read_text(encoding="utf-8"))
    assert html.open == []
    for words in ("Speed over one turn", "Spectrum of the speed", "in time", "AES6-weighted"):
        assert words in html.text
    code, out, _ = typed(CLIP, "--flutter")
    assert code == 0
    assert "platter, AES6-weighted" in out
    assert "at most ± 0.986 % (two sigma): mostly noise, which is ± " in out  # it turns evenly
    assert [line.split()[-3] for line in out.splitlines() if " wave " in line] == ["1.02"]
    assert "AES6-weighted: at most ± 0.986 % (two sigma): mostly noise" in html.text


def test_a_gyroscope_needs_no_clip(tmp_path: Path, typed: Typed) -> None:
    (tmp_path / "config.yaml").write_text(CONFIG, encoding="utf-8")
    code, out, _ = typed("--flutter", "--gyro", platter_log(tmp_path), "--config",
                         tmp_path / "config.yaml")
    assert code == 0
    assert "platter, AES6-weighted   ± 0.199 % (two sigma); the noise alone gives ± 0.00" in out
    wave, = (line.split() for line in out.splitlines() if " wave " in line)  # the rest is noise
    assert float(wave[1]) == pytest.approx(0.2, abs=3 * float(wave[3]))
    assert wave[5:7] == ["at", "4"]


def test_a_gyroscope_of_another_speed_is_refused(tmp_path: Path, typed: Typed) -> None:
    (tmp_path / "config.yaml").write_text(CONFIG, encoding="utf-8")
    code, _, err = typed(CLIP, "--flutter", "--gyro", platter_log(tmp_path, 2 * RATE), "--config",
                         tmp_path / "config.yaml")
    assert code == 3
    assert "They belong to different speeds" in err
    code, _, err = typed("--flutter", "--gyro", platter_log(tmp_path, 0.0), "--config",
                         tmp_path / "config.yaml")
    assert code == 3
    assert "on average" in err


def test_the_angles_are_written_for_other_programs(tmp_path: Path, typed: Typed) -> None:
    table = tmp_path / "angles.csv"
    code, out, _ = typed(CLIP, "--csv", table)
    assert (code, out.splitlines()[-1]) == (0, str(table))
    rows = np.genfromtxt(table, delimiter=",", names=True)
    used = rows["used"] == 1
    slope = np.polyfit(rows["time_s"][used], rows["angle_rad"][used], 1)[0]
    assert slope == pytest.approx(RATE, rel=1e-4)
    assert np.abs(rows["residual_rad"][used]).max() < 0.01
    assert typed(CLIP, "--csv", table)[0] == 2  # it exists
    assert typed(CLIP, "--csv", table, "--force")[0] == 0


@pytest.mark.parametrize(("options", "says"), [
    (("--gyro", "log.csv"), "--gyro and --page belong to --flutter"),
    (("--flutter", "--page", "a.txt"), "--page OUT.html"),
    (("--flutter", "--config", "a.yaml"), "--config states the units of --gyro"),
    ((CLIP, "--gyroscope-range", "500"), "as --gyroscope-range and --gyroscope-unit do"),
    (("--gyroscope-range", "500", "--gyroscope-unit", "rpm"), "give one of them"),
    (("--flutter", "--gyro", "a.csv", "--config", "a.yaml", "--gyroscope-range", "500"),
     "leave out --gyroscope-range"),
])
def test_options_without_their_fellows_are_refused(
    options: tuple[str, ...], says: str, typed: Typed
) -> None:
    code, _, err = typed(CLIP, *options)
    assert code == 2
    assert says in err
