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
from tests.world.designs import paper_design, rich_design
from tests.world.session import RunLog, Session, simulate
from tests.world.write import write_session

DESIGNS = {"paper": paper_design, "rich": rich_design}
SAMPLE_RATE = {"paper": 0.5, "rich": 0.3}  #: of the designs', to halve the time
TRIADS = ("accelerometer", "gyroscope")
Rng = np.random.Generator
OFF = 4.0  #: stated sds from which on a parameter is wrong


@dataclass
class Where:
    """A triad of some poses of one run, as arrays that a mistake changes in place.

    Attributes
    ----------
    counts : array, shape (p, n, 3)
        About the middle of the converter.
    time_s : array, shape (p, n)
    middle : float
        What was taken off.
    ends : tuple of float
        Of the converter, about its middle.
    """

    triad: str
    counts: np.ndarray
    time_s: np.ndarray
    middle: float
    ends: tuple[float, float]


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


def _tuples(value: Callable[[Where], float]) -> Callable[[Where, float, Rng], None]:
    def do(at: Where, share: float, rng: Rng) -> None:
        at.counts[rng.uniform(size=at.counts.shape[:2]) < share] = value(at)
    return do


def _spikes(at: Where, share: float, rng: Rng) -> None:
    noise = np.median(np.abs(np.diff(at.counts, axis=1)), axis=1, keepdims=True) + 1
    hit = rng.uniform(size=at.counts.shape[:2]) < share
    size = rng.uniform(10, 300) * noise * np.array([1.0, 0.0, 0.0])
    at.counts += np.where(hit[..., None], size, 0.0)


def _factor(at: Where, dose: float, _rng: Rng) -> None:
    at.counts *= dose


def _other_unit(at: Where, dose: float, _rng: Rng) -> None:
    """Another sensor of the same type."""
    at.counts *= 1 - dose * np.array([1.0, -0.7, 0.5])
    at.counts += dose * np.abs(at.counts).max() * np.array([0.3, -0.5, 0.2])


def _swap(at: Where, _dose: float, rng: Rng) -> None:
    order = rng.choice([(1, 0, 2), (0, 2, 1), (2, 1, 0)])
    at.counts[:] = at.counts[..., order]


def _mirror(at: Where, _dose: float, rng: Rng) -> None:
    at.counts[..., int(rng.integers(3))] *= -1


def _turned(first: float, last: float) -> Callable[[Where, float, Rng], None]:
    """Lies otherwise from one share of the pose to another."""
    def do(at: Where, degrees: float, _rng: Rng) -> None:
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        n = at.counts.shape[1]
        part = slice(int(first * n), int(last * n))
        at.counts[:, part] = at.counts[:, part] @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
    return do


def _freeze(at: Where, share: float, rng: Rng) -> None:
    n = at.counts.shape[1]
    length = max(2, round(share * n))
    first = int(rng.integers(0, n - length + 1))
    at.counts[:, first : first + length] = at.counts[:, first : first + 1]


def _clip(at: Where, share: float, _rng: Rng) -> None:
    limit = (1 - share) * np.abs(at.counts).max()
    np.clip(at.counts, -limit, limit, out=at.counts)


def _step(at: Where, dose: float, _rng: Rng) -> None:
    """Another bias in these poses, in counts of the noise of a sample."""
    at.counts += dose * np.median(np.abs(np.diff(at.counts, axis=1))) * np.array([1.0, -0.5, 0.3])


def _stretch(at: Where, dose: float, _rng: Rng) -> None:
    at.time_s[:] = at.time_s[:, :1] + dose * (at.time_s - at.time_s[:, :1])


def _gap(at: Where, share: float, rng: Rng) -> None:
    """Some seconds were not logged."""
    n = at.counts.shape[1]
    first = int(rng.integers(n // 4, n // 2))
    at.time_s[:, first:] += share * (at.time_s[:, -1:] - at.time_s[:, :1])


def _copy(at: Where, share: float, _rng: Rng) -> None:
    """The end of the first pose stands in the others."""
    length = max(1, round(share * at.counts.shape[1]))
    at.counts[1:, -length:] = at.counts[0, -length:]


def _dead(at: Where, _dose: float, rng: Rng) -> None:
    axis = int(rng.integers(3))
    at.counts[..., axis] = np.rint(rng.normal(0, 10, at.counts.shape[:2]))


FAILED = ("failed reading",)
AXES = ("axes", "two triads", "bad pose")
#: At rest a gyroscope reads its bias alone, and another gain is another bias.
OTHER_GAIN = ("range", "bad pose", "another sensor", "rate", "rate_scatter", "gains of runs",
              "bias_step", "other zero")
OFFSET = ("bad pose", "bias_step", "bias_wander", "clipped", "two triads", "other zero")

MISTAKES: dict[str, Mistake] = {
    "zeros": Mistake((0.005, 0.5), _tuples(lambda at: -at.middle), FAILED),
    "ones": Mistake((0.005, 0.5), _tuples(lambda at: -at.middle - 1), FAILED),
    "low end": Mistake((0.005, 0.5), _tuples(lambda at: at.ends[0]), FAILED),
    "spikes": Mistake((0.002, 0.3), _spikes, FAILED),
    "factor": Mistake((0.1, 10.0), _factor, (*OTHER_GAIN, "clipped", SHEET, "data sheet"),
                      ("pose", "few", "run")),
    "gain": Mistake((1.002, 1.1), _factor, OTHER_GAIN, ("pose", "few", "run")),
    "other unit": Mistake((0.02, 0.08), _other_unit, ("another sensor",), ("run",),
                          ("accelerometer",)),
    "axes": Mistake((1, 1), _swap, AXES, triads=("gyroscope",)),
    "axes of a pose": Mistake((1, 1), _swap, AXES, ("pose", "few"), ("accelerometer",)),
    "sign": Mistake((1, 1), _mirror, AXES, ("pose", "few", "run")),
    "turned": Mistake((0.2, 90.0), _turned(0.5, 1), ("moved", "bad pose"), ("pose", "few")),
    "turned back": Mistake((0.2, 90.0), _turned(0.25, 0.75), ("moved", "bad pose"),
                           ("pose", "few")),
    "frozen": Mistake((0.05, 1.0), _freeze, ("frozen", "bad pose")),
    "clipped": Mistake((0.01, 0.5), _clip, ("clipped", "frozen", "bad pose")),
    "bias": Mistake((0.3, 300.0), _step, OFFSET, ("pose", "few", "run")),
    "clock": Mistake((1.06, 1000.0), _stretch, ("time stamps",), ("run", "all"), ("gyroscope",)),
    "gap": Mistake((0.05, 3.0), _gap, ("missing samples",), ("pose", "run")),
    "copy": Mistake((0.2, 1.0), _copy, ("copied",), ("few",)),
    "dead axis": Mistake((1, 1), _dead, ("dead axis", "bias_step"), ("run", "all")),
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
