"""Sound sessions of a class of sensors, and how many of them are refused or doubted."""

import tempfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.attack.judged import judge
from tests.calib.fit.least_squares.coverage import another_evening
from tests.world.designs import paper_design, rich_design
from tests.world.hidden import Hidden
from tests.world.imu import Sensor
from tests.world.session import simulate
from tests.world.write import write_session

SAMPLE_RATE = 0.5  #: of the designs' rates, to halve the time
FASTEST_RAD_S = 4.0  #: of the rich design, with an offset; a smaller range has the paper's alone
REMARKS = ("are short", "frozen block")
"""Warnings that a sound session may have: what a pose was too short for, readings held."""


@dataclass(frozen=True)
class Counted:
    """Sessions that were refused, warned of or given another verdict, why, and errors in sds."""

    counts: Counter[str]
    words: list[str]
    off: list[np.ndarray]


def counted(sensor: Sensor, seeds: range, hidden: Sequence[tuple[Hidden, ...]]) -> Counted:
    """What comes of the sessions of a class with these seeds."""
    found = Counted(Counter(), [], [])
    for k, seed in enumerate(seeds):
        rich = k % 2 == 1 and sensor.gyroscope.full_scale > FASTEST_RAD_S
        design = (rich_design if rich else paper_design)(sensor).scaled(sample_rate=SAMPLE_RATE)
        session = simulate(another_evening(design, seed), seed, hidden[k // 2 % len(hidden)])
        with tempfile.TemporaryDirectory() as folder:
            judged = judge(write_session(Path(folder), session, film=False).config, session)
        warned = [one for one in judged.warnings if not any(word in one for word in REMARKS)]
        others = [one for one in judged.verdicts.values() if one != "nothing_missing"]
        if judged.refusal:
            found.counts["refused"] += 1
            found.words.append(f"{seed}: {judged.refusal}")
        elif warned or others:
            found.counts["warned" if warned else "other"] += 1
            found.words.extend(f"{seed}: {one}" for one in (*warned, *others))
        found.off.extend(judged.off.values())
    return found
