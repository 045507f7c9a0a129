"""README and guides against the code: commands, outputs, tables, configuration, links."""

import math
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import yaml
from pydantic import BaseModel

from calib.effects.catalogue import EFFECTS
from calib.poses.attitudes import direction_name, natural_directions
from calib.poses.conditions import Conditions
from calib.poses.runs.ideal_ring import ADVISED_TILT_RAD
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.commands import COMMANDS
from pipeline.config.load import load_config
from pipeline.config.record_section import (
    CertificateSection,
    RecordSection,
    TriadCertificateSection,
)
from pipeline.config.schema import (
    AccelerometerSection,
    EffectSection,
    GyroscopeSection,
    InstallationSection,
    KnownRateSection,
    PlateSection,
    PosesSection,
    RunSection,
    SiteSection,
    StillSection,
    TimebaseSection,
    VideoRateSection,
    resting_section,
)
from pipeline.config.sensor import (
    PRESETS,
    AccelerometerSheet,
    GyroscopeSheet,
    SensorSection,
    sheet_section,
)
from pipeline.config.session import session_model
from pipeline.export.formats import FORMATS
from tests.paths import ROOT
from tests.sessions import pipeline

README = (ROOT / "README.md").read_text(encoding="utf-8")
CONFIGURATION = (ROOT / "data/docs/configuration.md").read_text(encoding="utf-8")
RECORDING = (ROOT / "data/docs/recording.md").read_text(encoding="utf-8")
DOCS = ROOT / "data/docs"
PAGES = {"README.md": README, **{
    f"data/docs/{path.name}": path.read_text(encoding="utf-8") for path in (
        DOCS / f"{name}.md" for name in (
            "configuration", "recording", "logs", "effects", "python", "export", "numbers",
            "statistics"))}}
EFFECTS_PAGE, PYTHON_PAGE = PAGES["data/docs/effects.md"], PAGES["data/docs/python.md"]
LONGEST_README = 300  #: lines
NUMBER = re.compile(r"(?<![\w.])-?\d+\.?\d*(?:e[+-]?\d+)?")
SAME = 0.02  #: relative: another decoder of video moves the last digits, and no more
LAST_DIGITS = 3  #: by which a number of few digits may differ
SMALLEST_LOG = 1e-6  #: below it only the order of magnitude is compared


def block(text: str, marker: str) -> str:
    """The fenced block after ``<!-- marker -->``."""
    found = re.search(rf"<!-- {re.escape(marker)} -->\n```\w*\n(.*?)```", text, re.DOTALL)
    assert found, marker
    return found[1]


def table(text: str, marker: str) -> list[list[str]]:
    """The rows of the table after ``<!-- marker -->``, without its head."""
    rows = text.split(f"<!-- {marker} -->\n")[1].split("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in re.split(r"(?<!\\)\|", row)[1:-1]] for row in rows]


def assert_alike(shown: str, printed: str) -> None:
    """The same words in the same lines, and numbers that agree to ``SAME``."""
    for expected, line in zip(shown.splitlines(), printed.splitlines(), strict=True):
        assert squeezed(expected) == squeezed(line)
        for a, b in zip(NUMBER.findall(expected), NUMBER.findall(line), strict=True):
            one, other = float(a), float(b)
            if 0 < abs(one) < SMALLEST_LOG:
                assert abs(math.log10(abs(other / one))) < 0.1 * abs(math.log10(abs(one))), line
                continue
            digit = 10.0 ** -len(a.partition(".")[2].partition("e")[0])
            assert other == pytest.approx(one, rel=SAME, abs=LAST_DIGITS * digit), line


def squeezed(line: str) -> str:
    """A line without its numbers and its widths."""
    return re.sub(r"\s+", " ", NUMBER.sub("#", line)).strip()


# --- commands ----------------------------------------------------------------------------------


def commands() -> Iterator[tuple[str, list[str]]]:
    """Every ``pipeline ...`` that a page tells to type, with the page's name."""
    for page, text in PAGES.items():
        code = re.findall(r"^(?:    |\$ )(pipeline [^\n#]*)", text, re.MULTILINE)
        code += re.findall(r"`(pipeline [^`]*)`", text)
        for line in code:
            yield page, shlex.split(line)[1:]


def test_every_command_shown_exists_with_its_options() -> None:
    seen = set()
    for page, words in commands():
        if words[0].startswith("--"):
            continue
        assert words[0] in COMMANDS, (page, words)
        seen.add(words[0])
        command = import_module(f"pipeline.commands.{words[0]}").command
        options = {name for parameter in command.params for name in parameter.opts}
        for word in words[1:]:
            if word.startswith("--"):
                assert word in options, (page, words)
    assert seen >= {"run", "add", "diagnose", "apply", "export", "record", "plan"}


def test_formats_and_presets_named_in_the_pages_exist() -> None:
    for _, words in commands():
        if "--to" in words:
            assert words[words.index("--to") + 1] in FORMATS
    assert table(PAGES["data/docs/export.md"], "formats") == [
        [f"`{name}`", says] for name, says in FORMATS.items()]
    assert all(f"`{name}`" in CONFIGURATION for name in PRESETS)


# --- what is printed ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The shipped sessions where a reader has them, to be run and changed."""
    folder = tmp_path_factory.mktemp("reader")
    shutil.copytree(ROOT / "data", folder / "data", ignore=shutil.ignore_patterns("*.run"))
    before = Path.cwd()
    os.chdir(folder)
    yield folder
    os.chdir(before)


def test_the_first_run_prints_what_the_readme_shows(
    bench: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The session whose figures ``tests/test_end_to_end.py`` compares with the truth."""
    command = block(README, "run-command").split("&& .venv/bin/pipeline ")[1]
    assert pipeline(*shlex.split(command)) == 0
    assert_alike(block(README, "run-output"), capsys.readouterr().out)


def test_the_tutorial_prints_what_the_readme_shows_and_ends_with_nothing_missing(
    bench: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for step in ("tutorial: run", "tutorial: add"):
        command, _, shown = block(README, step).partition("\n")
        assert command.startswith("$ pipeline ")
        assert pipeline(*shlex.split(command)[2:]) == 0
        assert_alike(shown, capsys.readouterr().out)
    assert "nothing_missing" in shown
    config = (bench / "data/hidden_effect/config.yaml").read_text(encoding="utf-8")
    assert "[bias, scale, misalignment, g_sensitivity]" in config


def test_the_notebook_prints_what_the_readme_shows(bench: Path) -> None:
    code = block(PYTHON_PAGE, "notebook: python")
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], cwd=bench,
                          env={**os.environ, "PYTHONPATH": str(ROOT)}, text=True,
                          capture_output=True, check=False)
    assert done.stderr == ""
    assert_alike(block(PYTHON_PAGE, "notebook: output"), done.stdout)


# --- tables and configuration ------------------------------------------------------------------


def test_the_table_of_effects_is_the_catalogue() -> None:
    expected = [
        [f"`{name}`", " ".join(effect.only_for) or "all",
         " ".join(effect.page.formula.split()).replace("|", "\\|")]
        for name, effect in EFFECTS.items()
    ]  # fmt: skip
    assert table(EFFECTS_PAGE, "effects")[:-1] == expected


MAGNETOMETER = TRIAD_KINDS["magnetometer"]
SECTIONS: tuple[type[BaseModel], ...] = (
    session_model(), AccelerometerSection, GyroscopeSection, resting_section(MAGNETOMETER),
    SensorSection, AccelerometerSheet, GyroscopeSheet, sheet_section(MAGNETOMETER), SiteSection,
    VideoRateSection, KnownRateSection, TimebaseSection, PlateSection,
    PosesSection, RunSection, InstallationSection, CertificateSection, TriadCertificateSection,
    EffectSection, RecordSection, StillSection,
)  # fmt: skip


@pytest.mark.parametrize("section", SECTIONS, ids=lambda section: section.__name__)
def test_every_key_of_the_configuration_is_explained(section: type[BaseModel]) -> None:
    for key in section.model_fields:
        assert re.search(rf"`{key}`", CONFIGURATION), key


def test_every_key_that_is_explained_exists() -> None:
    known = {key for section in SECTIONS for key in section.model_fields}
    for row in re.findall(r"^\| (`[^|]*) \|", CONFIGURATION, re.MULTILINE):
        for key in re.findall(r"`([^`]*)`", row):
            assert key in known, key


def test_the_sample_configuration_is_valid(tmp_path: Path) -> None:
    path = tmp_path / "config.yaml"
    path.write_text(block(CONFIGURATION, "config"), encoding="utf-8")
    config = load_config(path, files_may_be_missing=True)
    assert config.gyroscope is not None
    assert [run.rate for run in config.gyroscope.runs] == ["slow", "stopped"]


# --- user-defined effects --------------------------------------------------------------------


def test_the_effect_in_ten_lines_joins_the_catalogue() -> None:
    code = block(EFFECTS_PAGE, "user-defined effect: python")
    before = set(EFFECTS)
    names: dict[str, object] = {}
    try:
        exec(compile(code, "README.md", "exec"), names)
        (added,) = set(EFFECTS) - before
        at = Conditions.of_vectors(np.ones((2, 3)), {"supply_v": np.array([3.3, 3.8])})
        columns = EFFECTS[added].evaluate(at)
        assert columns[0] == pytest.approx(0.0)
        assert columns[1] == pytest.approx(0.5 * np.eye(3))
        assert EFFECTS[added].physics.startswith("Bias that moves in proportion to the supply")
    finally:
        for name in set(EFFECTS) - before:
            del EFFECTS[name]
    body = code.split("\n\n\n")[1].strip().splitlines()
    assert len(body) <= 10


def test_the_effect_in_yaml_is_accepted(tmp_path: Path) -> None:
    own = yaml.safe_load(block(EFFECTS_PAGE, "user-defined effect: yaml"))
    text = yaml.safe_load(block(CONFIGURATION, "config"))
    text["gyroscope"] |= own["gyroscope"]
    path = tmp_path / "config.yaml"
    path.write_text(yaml.safe_dump({**text, "effects": own["effects"]}), encoding="utf-8")
    config = load_config(path, files_may_be_missing=True)
    assert config.gyroscope is not None
    assert "radio_heating" in config.gyroscope.model


# --- links and pictures ------------------------------------------------------------------------


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere_and_pictures_are_small_and_described(page: str) -> None:
    for mark, words, target in re.findall(r"(!?)\[([^\]]*)\]\(([^)]*)\)", PAGES[page]):
        file, _, heading = target.partition("#")
        path = (ROOT / page).parent / file if file else ROOT / page
        assert path.is_file(), target
        titles = re.findall(r"^#+ (.*)$", path.read_text(encoding="utf-8"), re.MULTILINE) \
            if heading else []
        anchors = {re.sub(r"[^a-z0-9 -]", "", title.lower()).replace(" ", "-") for title in titles}
        assert not heading or heading in anchors, target
        if mark:
            assert len(words) > 25
            assert path.stat().st_size < 100_000


def test_the_readme_is_short_and_lists_its_sections() -> None:
    assert len(README.splitlines()) < LONGEST_README
    contents = README.split("**Contents:**")[1].split("\n\n")[0]
    for title in re.findall(r"^## (.*)$", README, re.MULTILINE):
        assert f"[{title.split(':')[0]}](#" in contents, title


def test_the_drawings_show_the_poses_and_the_tilt_that_the_program_asks_for() -> None:
    poses = (DOCS / "poses.svg").read_text(encoding="utf-8")
    assert re.findall(r"middle\">(\d+  .*)</text>", poses) == [
        f"{i}  {direction_name(up)}" for i, up in enumerate(natural_directions(False), 1)]
    tilt = f"{math.degrees(ADVISED_TILT_RAD):g}"
    leaning = (DOCS / "leaning.svg").read_text(encoding="utf-8")
    assert f"axis, {tilt}° off" in leaning
    assert f'rotate({tilt} ' in leaning


def test_the_guide_answers_fifteen_points() -> None:
    points = [int(number) for number in re.findall(r"^(\d+)\. \*\*", RECORDING, re.MULTILINE)]
    assert points == list(range(1, 16))
