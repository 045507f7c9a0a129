"""The user's own words, tested: see where the model fails, learn what is missing, add it, and
watch the error fall.

Each session hides one effect, drawn at random, of a size drawn at random. The test does what a
user does: it runs the command, reads what is printed and results.json, types the command that was
printed, and looks whether the error fell. What was hidden is compared at the very end only.
"""

import re
import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.chance import spread_bounds
from tests.sessions import accelerometer_alone, pipeline, results_in
from tests.trials import COMMON_PARTS, LISTED, drawn
from tests.world.bench import Design
from tests.world.designs import paper_design, rich_design
from tests.world.hidden import Hidden
from tests.world.session import simulate
from tests.world.write import write_session

RICH = rich_design().scaled(sample_rate=0.2)
PAPER = paper_design().scaled(sample_rate=0.2)
NOT_DRAWN = (
    "frame_rotation",  # blind
    "reference_scale",
    "reference_offset",  # within the sd of the rates, or a guess between two, at these sizes
    "direction_dependent_rate",
    "asymmetry",
)
DRAWN_FROM = [*(n for n in LISTED if n not in NOT_DRAWN), "column:humidity_pct"]
ONE_SESSION_IN = 2e-3  #: a bound on one side of what two sides pass with this chance
FALL = 1 / np.sqrt(2)
"""What is as large as the noise raises the rms by √2; what is hidden here is larger by 4 to 12."""
ADD = re.compile(r"^next: pipeline (add .*)$", re.MULTILINE)


def one_at_random(seed: int) -> Hidden:
    """An effect of the gyro and a size of 4 to 12 noise units that the test does not look at."""
    rng = np.random.default_rng([seed, 41])
    name = DRAWN_FROM[int(rng.integers(len(DRAWN_FROM)))]
    hidden = drawn(name, "gyroscope", float(rng.uniform(4, 12)), RICH, seed)
    assert hidden is not None
    return hidden


def session_with(folder: Path, design: Design, seed: int, *hidden: Hidden) -> Path:
    """The files of an evening; what is hidden is nowhere in them."""
    config = write_session(folder, simulate(design, seed, hidden), film=False).config
    for effect in hidden:
        assert effect.name.partition(":")[0] not in config.read_text(encoding="utf-8")
    return config


@dataclass(frozen=True)
class Seen:
    """What the user has seen: the printed text and results.json of the gyro."""

    printed: str
    gyroscope: dict[str, Any]

    @property
    def verdict(self) -> str:
        return str(self.gyroscope["diagnosis"]["verdict"])

    @property
    def whitened(self) -> float:
        """Root of chi-square over its degrees of freedom."""
        return float(np.sqrt(self.gyroscope["chi2"] / self.gyroscope["dof"]))


def typed(capsys: pytest.CaptureFixture[str], config: Path, *arguments: str | Path) -> Seen:
    """Type a command that must succeed, and look."""
    assert pipeline(*arguments) == 0, capsys.readouterr().err
    folder = config.with_suffix(".run")
    return Seen(capsys.readouterr().out, results_in(folder)["gyroscope"])


@pytest.mark.usefixtures("bare_page")
@pytest.mark.parametrize("seed", [201, 203])
def test_what_was_hidden_is_named_added_by_the_printed_command_and_the_error_falls(
    seed: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    hidden = one_at_random(seed)
    config = session_with(tmp_path, RICH, seed, hidden)

    before = typed(capsys, config, "run", config)
    assert before.verdict == "effect"
    name = before.gyroscope["diagnosis"]["name"]
    assert f"gyroscope: '{name}' is missing" in before.printed
    command = ADD.search(before.printed)
    assert command is not None, before.printed

    after = typed(capsys, config, *shlex.split(command.group(1)))
    assert after.gyroscope["model"] == ["bias", "scale", "misalignment", name]
    dof = after.gyroscope["dof"]
    assert after.whitened < spread_bounds(dof, ONE_SESSION_IN)[1] < before.whitened
    assert after.gyroscope["residual_rms"] < FALL * before.gyroscope["residual_rms"]
    parameters = 9 + len(after.gyroscope["effects"][name]["values"])
    left_out = (dof + parameters) / dof  # 1 / (1 - mean leverage)
    assert after.gyroscope["loo_rms"] < FALL * left_out * before.gyroscope["loo_rms"]
    found = after.gyroscope["effects"][name]
    size, sd = (np.array(found[key], float) for key in ("values", "sd"))  # null: not seen alone
    assert (np.abs(size) > 3 * sd).any()
    assert after.verdict == "nothing_missing"
    # Nine cross terms need corners, which these poses lack: then they are asked for first.
    wanted = after.gyroscope["diagnosis"]["record_next"]
    assert wanted is None or (name == "cross_quadratic" and "corner" in wanted)
    assert ("next: pipeline apply" if wanted is None else f"next: record {wanted}") in after.printed

    history = typed(capsys, config, "history", config).printed
    rows = [line for line in history.splitlines() if "base" in line and name in line]
    assert len(rows) == 1
    assert name in {hidden.name} | COMMON_PARTS.get(hidden.name, set())


@pytest.mark.usefixtures("bare_page")
def test_taking_it_out_again_leaves_the_file_as_it_was(tmp_path: Path) -> None:
    config = accelerometer_alone(tmp_path)
    text = config.read_bytes()
    assert pipeline("run", config) == 0
    first = results_in(config.with_suffix(".run"))
    assert pipeline("add", config, "accelerometer.bias_drift", "--anyway") == 0
    assert config.read_bytes() != text
    assert pipeline("remove", config, "accelerometer.bias_drift") == 0
    assert config.read_bytes() == text
    assert results_in(config.with_suffix(".run"))["accelerometer"] == first["accelerometer"]


def _of(name: str, size: float, design: Design, seed: int) -> tuple[Hidden]:
    hidden = drawn(name, "gyroscope", size, design, seed)
    assert hidden is not None
    return (hidden,)


@pytest.mark.usefixtures("bare_page")
def test_auto_goes_on_until_two_hidden_effects_are_in_the_model(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    both = (*_of("g_sensitivity", 8.0, RICH, 211), *_of("cubic", 6.0, RICH, 211))
    config = session_with(tmp_path, RICH, 211, *both)
    seen = typed(capsys, config, "add", config, "--auto")
    assert set(seen.gyroscope["model"][3:]) == {"g_sensitivity", "cubic"}
    assert seen.verdict == "nothing_missing"
    falls = [float(x) for x in re.findall(r"^chi²/dof +([\d.e+]+) ", seen.printed, re.MULTILINE)]
    assert falls == sorted(falls, reverse=True)
    history = typed(capsys, config, "history", config).printed
    assert history.count("base + ") >= 2


@pytest.mark.usefixtures("bare_page")
def test_auto_adds_nothing_where_nothing_is_hidden(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = session_with(tmp_path, PAPER, 212)
    text = config.read_bytes()
    seen = typed(capsys, config, "add", config, "--auto")
    assert seen.verdict == "nothing_missing"
    assert config.read_bytes() == text
    assert "was not changed: the diagnosis names no effect to add" in seen.printed


def test_a_named_class_is_added_by_any_member_with_the_measurement_that_tells_them_apart(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = session_with(tmp_path, PAPER, 213, *_of("quadratic", 12.0, PAPER, 213))
    seen = typed(capsys, config, "run", config)
    assert set(seen.gyroscope["diagnosis"]["group"]) == {
        "quadratic",
        "asymmetry",
        "g_squared_sensitivity",
    }
    assert "next: record" in seen.printed
    name = seen.gyroscope["diagnosis"]["name"]
    add = f"pipeline add {config} gyroscope.{name}"
    assert add in seen.printed
    assert add in (config.with_suffix(".run") / "report.html").read_text(encoding="utf-8")
    text = config.read_bytes()
    typed(capsys, config, "add", config, "--auto")  # the data cannot tell: nothing is added
    assert config.read_bytes() == text
    member = "asymmetry" if name == "quadratic" else "quadratic"
    assert pipeline("add", config, f"gyroscope.{member}") == 0
    note = capsys.readouterr().err
    assert "looks the same as" in note
    assert "record the same poses with the plate stopped" in note
    after = Seen("", results_in(config.with_suffix(".run"))["gyroscope"])
    assert after.gyroscope["model"][3:] == [member]
    assert after.whitened < 0.5 * seen.whitened


@pytest.mark.usefixtures("bare_page")
def test_a_blind_effect_is_refused_with_the_measurement_that_shows_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = session_with(tmp_path, PAPER, 214, *_of("g_sensitivity", 10.0, PAPER, 214))
    seen = typed(capsys, config, "run", config)
    assert seen.verdict == "nothing_missing"
    assert "g_sensitivity" in seen.gyroscope["diagnosis"]["blind"]
    text = config.read_bytes()
    assert pipeline("add", config, "gyroscope.g_sensitivity") == 4
    refusal = capsys.readouterr().err
    assert "these data cannot see it" in refusal
    assert "record the same poses with the plate stopped" in refusal
    assert config.read_bytes() == text


def test_diagnose_shows_the_ranking_and_changes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = session_with(tmp_path, RICH, 215, *_of("hysteresis", 8.0, RICH, 215))
    assert pipeline("diagnose", config) == 0
    printed = capsys.readouterr().out
    assert "'hysteresis' is missing" in printed
    ranked = printed[printed.rindex("candidate") :].splitlines()
    assert ranked[1].split()[0] == "hysteresis"
    assert "these data cannot determine: frame_rotation" in printed
    assert not config.with_suffix(".run").exists()
