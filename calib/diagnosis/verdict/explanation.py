"""What a verdict is for people: how it stands, in a few words, in sentences, and what is next."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

Standing = Literal["good", "act", "open"]
Step = Literal["apply", "add", "record", "discover"]

#: A sign beside the word, since colour alone says nothing.
SIGNS: Mapping[Standing, str] = {"good": "✓", "act": "!", "open": "?"}


@dataclass(frozen=True)
class Explanation:
    """A verdict for people.

    ``standing`` says how it stands, ``short`` in a few words what is wrong, ``text`` in two or
    three sentences. ``step`` is what to do next, for programs, ``following`` in words.
    """

    standing: Standing
    short: str
    text: str
    step: Step
    following: str
