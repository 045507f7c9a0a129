"""Trials of two effects at once: what following the advice to its end adds."""

import argparse
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from tests.trials import DESIGNS, LISTED, calibrates, follow_to_the_end, hidden_of, poses_of
from tests.world.bench import Design
from tests.world.hidden import Hidden


@dataclass(frozen=True)
class PairAdded:
    """How many of two hidden effects were added, whether an innocent one was, and in words."""

    right: int
    innocent: bool
    text: str


def one_pair(asked: argparse.Namespace, seed: int) -> PairAdded:
    """What following the advice adds to the session of one seed."""
    design = DESIGNS[asked.design]()
    hidden = draw_pair(design, seed, asked)
    names = {h.name for h in hidden}
    loop = follow_to_the_end(poses_of(design, seed, asked.triad, hidden))
    shown = set(loop.groups)
    shown |= {"reference_drift"} if "scale_drift" in shown else set()
    right = len(names & shown)
    text = (f"{' + '.join(sorted(names))}: added {', '.join(loop.added) or 'nothing'}; then "
            f"{loop.last.verdict} {'/'.join(loop.last.group)}")
    return PairAdded(right, len(loop.added) > right, text)


def draw_pair(design: Design, seed: int, asked: argparse.Namespace) -> list[Hidden]:
    """Two visible effects of the catalogue that are no part of each other."""
    rng = np.random.default_rng([seed, 30])
    names = [n for n in asked.effects or LISTED if calibrates(n, asked.triad)]
    apart = [
        pair
        for pair in combinations(names, 2)
        if not set(pair) & {"frame_rotation", "reference_scale"}
        and set(pair) != {"scale_drift", "reference_drift"}
    ]
    while True:
        pair = apart[int(rng.integers(len(apart)))]
        hidden = hidden_of(pair, asked.triad, asked.sizes[0], design, seed)
        if hidden is not None:
            return hidden
