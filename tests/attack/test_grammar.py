"""A small draw of ``tests.bench.attack``: parameters that are off imply a word, at every dose."""

from pathlib import Path

import pytest

from tests.attack.configured import CONFIGURATIONS
from tests.attack.grammar import MISTAKES, drawn

FIRST_SEED = 500_000  #: used by no bench
KEPT = {"next pose": 985_000, "backwards": 985_001, "coarse": 985_001, "twice": 985_000}
"""Seeds that a bench found silent, wrong or without a cause once."""


@pytest.mark.parametrize("what", [*MISTAKES, *CONFIGURATIONS])
def test_parameters_that_are_off_imply_a_word(what: str, tmp_path: Path) -> None:
    attack = drawn(FIRST_SEED + len(what), what)
    judged = attack.judged(tmp_path)
    assert attack.outcome(judged)[0] != "silent", (attack.words, judged.worst, judged.said)


@pytest.mark.parametrize("what", KEPT)
def test_what_a_bench_found_stays_named(what: str, tmp_path: Path) -> None:
    attack = drawn(KEPT[what], what)
    judged = attack.judged(tmp_path)
    assert attack.outcome(judged)[0] == "right", (attack.words, judged.said)
