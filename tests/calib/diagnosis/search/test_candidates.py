"""Which sets are weighed beside a set."""

from calib.diagnosis.finding import find
from calib.diagnosis.search.candidates import MOST_UNLISTED, Candidates
from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from tests.calib.made_poses import noisy, rich_poses


def test_no_third_of_what_no_model_can_contain_stands_in_a_set() -> None:
    """Three kinds of noise, of a hundred columns each, took 18 s and had no other verdict."""
    known = find(fit(noisy(rich_poses("gyroscope"), 3), Model.of(BASE))).posterior
    candidates = Candidates(known.hypotheses)
    unlisted = {h.name: j for j, h in enumerate(known.hypotheses)
                if h.effect is None and not known.table.is_blind(j)}
    some = tuple(sorted(unlisted.values()))[:MOST_UNLISTED]
    every = range(len(known.hypotheses))
    added = {j for one in candidates.one_more(known.table, some, every) for j in {*one} - {*some}}
    assert added
    assert all(known.hypotheses[j].effect is not None for j in added)
    fewer = candidates.one_more(known.table, some[1:], every)
    assert any({*one} - {*some[1:]} <= {*unlisted.values()} for one in fewer)
