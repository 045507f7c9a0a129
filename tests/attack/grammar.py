"""Mistakes drawn at random: what is done, where, and how much of it.

Every mistake is done to the arrays of a session before it is written, or to its configuration. It
states the claims that name it; where the dose is so small that no parameter is off by it, nothing
need be said.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tests.attack.claims import Claims, claims_of
from tests.attack.configured import CONFIGURATIONS, SHEET
from tests.attack.judged import Judged, judge
from tests.attack.spoiling import (
    Where,
    add_constant,
    backwards,
    clip,
    coarse,
    copy_the_first,
    creep,
    deaden,
    exchange,
    freeze,
    gain_of,
    gap,
    held,
    hum,
    mirror,
    mix_with_next,
    other_unit,
    spikes,
    spin_up,
    stretch,
    take_from_next,
    tuples,
    turned,
)
from tests.world.designs import paper_design, rich_design
from tests.world.session import RunLog, Session, simulate
from tests.world.write import write_session

DESIGNS = {"paper": paper_design, "rich": rich_design}
SAMPLE_RATE = {"paper": 0.5, "rich": 0.3}  #: of the designs', to halve the time
TRIADS = ("accelerometer", "gyroscope")
Rng = np.random.Generator
OFF = 4.0  #: stated sds from which on a parameter is wrong


@dataclass(frozen=True)
class Mistake:
    """One kind of mistake.

    Attributes
    ----------
    doses : tuple of float
        From the smallest to the largest that is tried; drawn evenly in the logarithm.
    do : callable
        Changes the arrays of a place by a dose.
    right : tuple of str
        The claims (:mod:`tests.attack.claims`) that name it.
    places : tuple of str
        ``pose`` one, ``few`` two or three, ``run`` all of a run, ``all`` every run.
    triads : tuple of str
    """

    doses: tuple[float, float]
    do: Callable[[Where, float, Rng], None]
    right: tuple[str, ...]
    places: tuple[str, ...] = ("pose", "few", "run", "all")
    triads: tuple[str, ...] = TRIADS


FAILED = ("failed reading",)
AXES = ("axes", "two triads", "bad pose")
#: At rest a gyroscope reads its bias alone, and another gain is another bias.
OTHER_GAIN = ("range", "bad pose", "another sensor", "rate", "rate_scatter", "gains of runs",
              "bias_step", "other zero")
OFFSET = ("bad pose", "bias_step", "bias_wander", "clipped", "two triads", "other zero")

MISTAKES: dict[str, Mistake] = {
    "zeros": Mistake((0.005, 0.5), tuples(lambda at: -at.middle), FAILED),
    "ones": Mistake((0.005, 0.5), tuples(lambda at: -at.middle - 1), FAILED),
    "low end": Mistake((0.005, 0.5), tuples(lambda at: at.ends[0]), FAILED),
    "spikes": Mistake((0.002, 0.3), spikes, FAILED),
    "factor": Mistake((0.1, 10.0), gain_of, (*OTHER_GAIN, "clipped", SHEET, "data sheet"),
                      ("pose", "few", "run")),
    "gain": Mistake((1.002, 1.1), gain_of, OTHER_GAIN, ("pose", "few", "run")),
    "other unit": Mistake((0.02, 0.08), other_unit, ("another sensor",), ("run",),
                          ("accelerometer",)),
    "axes": Mistake((1, 1), exchange, AXES, triads=("gyroscope",)),
    "axes of a pose": Mistake((1, 1), exchange, AXES, ("pose", "few"), ("accelerometer",)),
    "sign": Mistake((1, 1), mirror, AXES, ("pose", "few", "run")),
    "turned": Mistake((0.2, 90.0), turned(0.5, 1), ("moved", "bad pose"), ("pose", "few")),
    "turned back": Mistake((0.2, 90.0), turned(0.25, 0.75), ("moved", "bad pose"),
                           ("pose", "few")),
    "frozen": Mistake((0.05, 1.0), freeze, ("frozen", "bad pose")),
    "clipped": Mistake((0.01, 0.5), clip, ("clipped", "frozen", "bad pose")),
    "bias": Mistake((0.3, 300.0), add_constant, OFFSET, ("pose", "few", "run")),
    "clock": Mistake((1.06, 1000.0), stretch, ("time stamps",), ("run", "all"), ("gyroscope",)),
    "gap": Mistake((0.05, 3.0), gap, ("missing samples",), ("pose", "run")),
    "copy": Mistake((0.2, 1.0), copy_the_first, ("copied",), ("few",)),
    "spin up": Mistake((0.02, 0.9), spin_up, ("moved", "bad pose", "rate", "unsteady"),
                       triads=("gyroscope",)),
    "creep": Mistake((0.3, 300.0), creep, ("moved", "bad pose", "short poses", "unsteady")),
    "held": Mistake((2, 40), held, ("frozen", "short poses")),
    "coarse": Mistake((0.3, 30.0), coarse, ("frozen",)),
    "hum": Mistake((0.3, 300.0), hum, ("moved", "clipped")),
    "mixed": Mistake((0.05, 0.5), mix_with_next, ("moved", "copied", "bad pose"), ("few", "run")),
    "next pose": Mistake((1, 1), take_from_next, AXES, ("few", "run"), ("gyroscope",)),
    "backwards": Mistake((1, 1), backwards, ("time stamps",)),
    "dead axis": Mistake((1, 1), deaden, ("dead axis", "bias_step"), ("run", "all")),
}


@dataclass(frozen=True)
class Drawn:
    """One attack in words, and the session that it makes of a sound one.

    ``files`` are the poses that it changes; None where it is in the configuration.
    """

    what: str
    words: str
    session: Session
    truth: Session
    edits: tuple[tuple[str, str], ...] = ()
    files: frozenset[str] | None = None

    def outcome(self, judged: Judged) -> tuple[str, Claims]:
        """``silent`` (a parameter is off, without a word), ``harmless``, or what is claimed of it.

        That is ``right``, ``wrong``, or ``open`` where no cause is named.
        """
        claims = claims_of(judged)
        if judged.is_silent:
            blind = self.words.split(":")[0] in UNOBSERVABLE.get(self.what, ())
            return "silent" if judged.worst > OFF and not blind else "harmless", claims
        if not claims.causes:
            return "open", claims
        kinds = MISTAKES if self.what in MISTAKES else CONFIGURATIONS
        poses = claims.poses if self.files is None else self.files
        right = claims.are_right(kinds[self.what].right, poses)
        return "right" if right else "wrong", claims

    def judged(self, folder: Path) -> Judged:
        """What the program makes of it, written to ``folder``."""
        config = write_session(folder / "attack", self.session, film=False).config
        text = config.read_text(encoding="utf-8")
        for old, new in self.edits:
            text = re.sub(old, new, text)
        config.write_text(text, encoding="utf-8")
        judged = judge(config, self.truth)
        if judged.is_silent and judged.worst > OFF:
            without = write_session(folder / "sound", self.truth, film=False).config
            judged = judged.less(judge(without, self.truth))
        return judged


def drawn(seed: int, what: str | None = None) -> Drawn:
    """The attack with this seed; of one kind where ``what`` is stated."""
    rng = np.random.default_rng([seed, 4242])
    design = str(rng.choice([*DESIGNS]))
    session = simulate(DESIGNS[design]().scaled(sample_rate=SAMPLE_RATE[design]), seed)
    kinds = [*MISTAKES, *CONFIGURATIONS]
    what = what or str(rng.choice(kinds))
    if what in CONFIGURATIONS:
        words, edits = CONFIGURATIONS[what].edits(rng, session)
        return Drawn(what, f"{design}: {words}", session, session, edits)
    mistake = MISTAKES[what]
    low, high = mistake.doses
    dose = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    triad, place = str(rng.choice(mistake.triads)), str(rng.choice(mistake.places))
    runs = [i for i, run in enumerate(session.runs)
            if triad == "gyroscope" or run.run.in_accelerometer_section]
    if design == "paper" and triad == "gyroscope":
        runs = runs[1:]
    if len(runs) == 1 and place == "run" and what in ABSORBED:
        place = "few"  # of the only run it is the sensor itself
    which = runs if place == "all" else [int(rng.choice(runs))]
    changed, files = [*session.runs], set()
    for i in which:
        run = session.runs[i]
        poses = _poses(place, len(run.time_s), rng)
        changed[i] = _changed(run, session, triad, poses, mistake, dose, rng)
        at_rest = run.run.in_accelerometer_section
        folder = "accelerometer" if at_rest else f"gyroscope/{run.run.name}"
        files |= {f"{folder}/pose_{k + 1:02d}.csv" for k in poses}
    words = f"{design}: {what} {dose:.3g} in {place} of {triad} {session.runs[which[0]].run.name}"
    return Drawn(what, words, replace(session, runs=tuple(changed)), session, (), frozenset(files))


def _poses(place: str, count: int, rng: Rng) -> np.ndarray:
    if place in ("run", "all"):
        return np.arange(count)
    return rng.choice(count, 1 if place == "pose" else int(rng.integers(2, 4)), replace=False)


def _changed(run: RunLog, session: Session, triad: str, poses: np.ndarray, mistake: Mistake,
             dose: float, rng: Rng) -> RunLog:
    """A run with the mistake in some of its poses."""
    converter = getattr(session.design.sensor, triad)
    low, high = converter.rails
    middle = (low + high) / 2 if converter.offset_binary else 0.0
    counts, time_s = getattr(run, triad).astype(float), run.time_s.copy()
    at = Where(triad, counts[poses] - middle, time_s[poses], middle, (low - middle, high - middle))
    mistake.do(at, dose, rng)
    counts[poses] = np.clip(np.rint(at.counts + middle), low, high)
    time_s[poses] = at.time_s
    return replace(run, time_s=time_s, **{triad: counts.astype(np.int64)})


ABSORBED = ("bias", "sign", "gain")
"""Kinds that are no mistake where every pose of a triad has them."""

UNOBSERVABLE = {"gravity": ("paper", "rich"), "sd of the rate": ("paper", "rich"),
                "stated rate": ("paper",)}
"""Kinds that no data show, by design: what all references are off by together, and its sd."""
