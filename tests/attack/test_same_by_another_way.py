"""The same measurement by two ways gives the same calibration.

Others stand where they belong: an export and `apply` for any column's name
(``test_a_column_of_any_name_is_exported_as_it_is_applied``), a notebook and a command
(``test_samples_of_poses_give_the_command_s_own_figures``), the page that is served and a run
(``test_the_figures_on_the_screen_are_those_of_a_run_with_the_same_effects``).
"""

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from tests.sessions import pipeline, run_without_page
from tests.world.designs import rich_design
from tests.world.session import simulate
from tests.world.write import write_session

PER_G, PER_DEG_S = 16384.0, 131.072  #: counts of the simulated sensor
MOST_SD = 0.7  #: of a parameter; what the ends of poses, which a search leaves out, move it by


def test_an_import_of_one_file_is_that_of_many(tmp_path: Path) -> None:
    session = simulate(rich_design().scaled(sample_rate=0.3), 5)
    config = write_session(tmp_path / "session", session, film=False).config
    files = sorted((config.parent / "accelerometer").glob("*.csv"))
    header = files[0].read_text(encoding="utf-8").splitlines()[0]
    tables = [np.loadtxt(path, delimiter=",", skiprows=1) for path in files]
    for table, path in zip(tables, files, strict=True):
        table[:, 1:4] /= PER_G
        table[:, 4:7] /= PER_DEG_S
        _write(path, header, table)
    whole = tmp_path / "whole.csv"
    _write(whole, header, np.vstack(sorted(tables, key=lambda table: float(table[0, 0]))))
    many, one = (_imported(paths, tmp_path / name) for paths, name in ((files, "many"),
                                                                      ([whole], "one")))
    assert many[0] == one[0]
    for triad in many[1]:
        sd = np.array(list(many[1][triad]["sd"].values()), dtype=float)
        values = [np.array(list(results[triad]["parameters"].values()), dtype=float)
                  for results in (many[1], one[1])]
        assert np.nanmax(np.abs(values[0] - values[1]) / sd) < MOST_SD, triad


def _write(path: Path, header: str, table: np.ndarray) -> None:
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.6f")


def _imported(paths: list[Path], folder: Path) -> tuple[Any, Any]:
    """The sensor as it was guessed, and the results of its triads."""
    assert pipeline("import", *paths, "--output", folder) == 0
    (config,) = folder.glob("*.yaml") if folder.is_dir() else (folder,)
    results = run_without_page(config)
    triads = {name: results[name] for name in ("accelerometer", "gyroscope") if results.get(name)}
    return yaml.safe_load(config.read_text(encoding="utf-8"))["sensor"], triads
