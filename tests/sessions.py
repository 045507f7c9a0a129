"""Sessions on disk and the command run on them, as a user has and does it."""

import json
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from calib.poses.triad_kind import TRIAD_KINDS
from pipeline import cli
from pipeline.config.load import load_config
from pipeline.results.write import results_of, results_text
from pipeline.stages.context import RunContext
from pipeline.stages.run import run_stages
from tests.world.designs import paper_design
from tests.world.magnetometer import Magnetometer, log_field
from tests.world.session import Session, simulate
from tests.world.write import write_session

FIELD_SD_UT = 0.05  #: stated of a magnetometer's field


def quick_session(folder: Path, seed: int = 2) -> tuple[Path, Session]:
    """The paper's evening with shorter poses, rates stated; its configuration and its truth.

    With ``seed`` 2 every model on the page is solved quickly: a run takes two thirds of the time
    that it takes with 1, where one left-out pose leaves 18 parameters to 17.
    """
    session = simulate(paper_design().scaled(seconds=0.5), seed)
    return write_session(folder, session, film=False).config, session


def magnetometer_session(
    folder: Path, seed: int, sensor: Magnetometer, kind: str = "magnetometer"
) -> Path:
    """The configuration of a session whose poses at rest log a field, which it states."""
    config, world = quick_session(folder, seed)
    log_field(folder, world.design, seed, replace(sensor, prefix=TRIAD_KINDS[kind].prefix))
    sheet = (f"  {kind}: {{counts_per_ut: {sensor.counts_per_ut}, bits: 16, "
             "encoding: twos-complement}\n\nsite:")
    text = config.read_text(encoding="utf-8").replace("\nsite:", sheet, 1)
    return configured(folder, f"{text}\n{kind}:\n  poses: accelerometer/pose_*.csv\n"
                              f"  field_ut: {sensor.field_ut}\n  sd_ut: {FIELD_SD_UT}\n")


def accelerometer_alone(folder: Path) -> Path:
    """The configuration of a short session of an accelerometer alone."""
    design = paper_design().scaled(seconds=0.3, sample_rate=0.5)
    config = write_session(folder, simulate(design, 3), film=False).config
    text = config.read_text(encoding="utf-8")
    config.write_text(text.partition("\ngyroscope:")[0] + "\n", encoding="utf-8")
    return config


def pipeline(*arguments: str | Path) -> int:
    """One command in this process; an exception that nobody expects goes through."""
    return cli.main([str(argument) for argument in arguments])


def typed(*arguments: str | Path) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of one command in this process."""
    with redirect_stdout(StringIO()) as out, redirect_stderr(StringIO()) as errors:
        code = pipeline(*arguments)
    return code, out.getvalue(), errors.getvalue()


def configured(folder: Path, text: str) -> Path:
    """The folder's ``config.yaml``, with this text."""
    (folder / "config.yaml").write_text(text, encoding="utf-8")
    return folder / "config.yaml"


def run_without_page(config: Path, *, allow_python: bool = False) -> dict[str, Any]:
    """results.json as `pipeline run` writes it, without the page and the history beside it."""
    session = load_config(config)
    outcome = run_stages(session, RunContext(session.output_folder, allow_python=allow_python))
    session.output_folder.mkdir(exist_ok=True)
    text = results_text(results_of(outcome))
    (session.output_folder / "results.json").write_text(text, encoding="utf-8")
    return results_in(session.output_folder)


def results_in(folder: Path) -> dict[str, Any]:
    """results.json of a folder."""
    found: dict[str, Any] = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    return found


def edit(config: Path, old: str, new: str) -> None:
    """Replace a text that the configuration must hold."""
    text = config.read_text(encoding="utf-8")
    assert old in text
    config.write_text(text.replace(old, new), encoding="utf-8")


def rewrite_rows(path: Path, table: np.ndarray) -> None:
    """Other rows under the header of a log."""
    header = path.read_text(encoding="utf-8").splitlines()[0]
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.4f")
