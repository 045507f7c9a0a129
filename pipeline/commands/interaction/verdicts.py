"""A verdict on the terminal: green where the calibration is good, yellow where it is open."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from pipeline.commands import paragraph
from pipeline.commands.interaction.output import say

if TYPE_CHECKING:
    from pipeline.stages.triads import TriadResult

#: Colour by the standing of a diagnosis; the words say the same without it.
COLOURS: Mapping[str, str] = {"good": "green", "act": "red", "open": "yellow"}


def echo_verdict(result: "TriadResult") -> None:
    """Print the diagnosis of a triad in its colour, wrapped at the terminal's width."""
    from pipeline.console.run_text import verdict_line

    say(paragraph(verdict_line(result)), bold=True,
                fg=COLOURS[result.diagnosis.explanation.standing])
