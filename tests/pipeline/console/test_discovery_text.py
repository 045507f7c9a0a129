"""What is said where no formula holds."""

from types import SimpleNamespace
from typing import cast

from calib.diagnosis.verdict.explanation import Explanation
from pipeline.console.discovery_text import no_formula
from pipeline.stages.triads import TriadResult


def test_where_no_formula_holds_it_is_said_what_is_to_be_added() -> None:
    said = Explanation("act", "its model lacks 'bias_step'", "", "add", "Add it")
    diagnosis = SimpleNamespace(explanation=said, name="bias_step", verdict="effect")
    result = SimpleNamespace(triad="accelerometer", diagnosis=diagnosis)
    assert no_formula(cast(TriadResult, result)).endswith(
        "does. What the diagnosis says stands: its model lacks 'bias_step'. Add it.")
