"""`covariates:` names the logged columns that may cause an error, and no others do."""

from pathlib import Path

import pytest

from tests.pipeline.stages.user_physics import variant
from tests.sessions import pipeline, run_without_page


def listed(config: Path) -> set[str]:
    """Everything the gyroscope's diagnosis weighed or called blind."""
    diagnosis = run_without_page(config)["gyroscope"]["diagnosis"]
    return {c["name"] for c in diagnosis["ranking"]} | set(diagnosis["blind"])


def test_only_the_columns_that_are_named_may_be_causes(damp_once: Path) -> None:
    plain = variant(damp_once, "every", "")
    assert {"temperature_bias", "column:humidity_pct"} <= listed(plain)
    named = listed(variant(damp_once, "named", "covariates: [temperature_c]"))
    assert "temperature_bias" in named
    assert "column:humidity_pct" not in named


def test_what_was_set_aside_is_said_with_the_key_that_names_it(
    damp_once: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    named = variant(damp_once, "aside", "covariates: [temperature_c]")
    assert pipeline("diagnose", named) == 0
    said = capsys.readouterr().out
    assert "logged columns that the diagnosis does not use" in said
    assert "humidity_pct" in said
    assert "`covariates: [" in said


@pytest.mark.parametrize("command", ["check", "run"])
def test_a_column_that_no_log_has_is_said_with_the_nearest(
    damp_once: Path, command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    wrong = variant(damp_once, "wrong", "covariates: [humidty_pct, temperature_c]")
    assert pipeline(command, wrong) == 2
    error = capsys.readouterr().err
    assert "covariates" in error
    assert "'humidty_pct' is no logged column (did you mean 'humidity_pct'?)" in error
    assert "wrong.yaml:" in error
