"""Results are those of the configuration that asks for them, and of its logs as they are."""

import shutil
from pathlib import Path

from tests.sessions import accelerometer_alone, edit, results_in, typed


def test_results_of_another_configuration_or_of_what_was_changed_are_not_used(
    tmp_path: Path,
) -> None:
    one = accelerometer_alone(tmp_path)
    one.write_text("output: same\n" + one.read_text(encoding="utf-8"), encoding="utf-8")
    two = tmp_path / "two.yaml"
    shutil.copy(one, two)
    edit(two, "[bias, scale, misalignment]", "[bias, scale]")
    log, folder = next((tmp_path / "accelerometer").glob("*.csv")), tmp_path / "same"
    assert typed("run", one)[0] == 0
    assert results_in(folder)["config"] == one.name
    code, _, errors = typed("run", two)
    assert (code, f"has the results of {one.name}, which would be replaced" in errors) == (2, True)
    assert typed("run", two, "--force")[0] == 0
    code, out, errors = typed("apply", one, log)
    assert (code, out) == (2, "")
    assert f"has the results of two.yaml, not of {one}" in errors
    assert f"Type: pipeline run {one}" in errors

    two.write_text("# a remark\n" + two.read_text(encoding="utf-8"), encoding="utf-8")
    assert typed("apply", two, log)[0] == 0
    copy = shutil.copy(log, tmp_path / "drive.csv")
    log.write_text(log.read_text(encoding="utf-8").rstrip().rpartition("\n")[0], encoding="utf-8")
    code, _, errors = typed("export", two, "--to", "json")
    assert (code, "or a log that it names, was changed after the run" in errors) == (2, True)
    assert typed("apply", folder, copy)[0] == 0  # as they are
