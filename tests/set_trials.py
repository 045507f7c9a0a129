"""One trial of a diagnosis of several effects at once, and how its probabilities turn out.

What is counted: of every hidden effect that these poses can see, whether its class was named, named
as a single effect, or offered with a probability; whether anything named was innocent; and every
stated probability beside whether it came true.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.diagnosis.finding import Finding, find
from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from tests.trials import COMMON_PARTS, calibrates, drawn, poses_of
from tests.world.bench import Design, Run, corner_directions, wedge_directions
from tests.world.designs import FAST, SLOW, paper_design, rich_design, soak_design
from tests.world.hidden import Hidden
from tests.world.imu import FloatArray, mpu6050
from tests.world.plate import PlateMotion

OFFERED = 0.05
"""Probability from which a class that a verdict lists counts as offered."""

NAMES = (
    "quadratic", "cubic", "asymmetry", "cross_quadratic", "temperature_bias", "temperature_scale",
    "bias_drift", "scale_drift", "warm_up", "hysteresis", "vibration_rectification",
    "g_sensitivity", "g_squared_sensitivity", "reference_drift",
    "direction_dependent_rate", "column:humidity_pct",
)
"""All but the Earth's rate: at 5 sd the floor would turn twenty times as fast as the Earth, which
the diagnosis is right not to believe beside other effects."""

DISTURBANCES = ("none", "memory", "wander", "temperature_lag", "temperature_squared",
                "plate_wander", "coarse", "correlated", "short")
SHORT_POSE_S = 3.0
OF_THE_DESIGN = ("none", "coarse", "correlated", "short")
"""Disturbances that are no hidden effect."""
ONE_MAGNITUDE = {"quadratic", "asymmetry", "cross_quadratic"}
"""At one magnitude the first two are one, and the third holds both."""

TOGETHER = ({"scale_drift", "reference_drift"},)
"""Pairs of which one holds the other: not both are hidden at once."""

ALIKE = {
    "memory": {"hysteresis", "previous"},
    "temperature_lag": {"temperature_bias", "temperature_c"},
    "temperature_squared": {"temperature_c"},
    "jump": {"bias_step"},
    "wander": {"bias_wander"},
    "plate_wander": {"rate_scatter"},
}
"""What counts as right of a disturbance that no catalogue has."""


@dataclass(frozen=True)
class SetOutcome:
    """One trial.

    ``visible`` of the hidden effects; those of them that were ``named`` in a class, as a ``single``
    effect, or ``offered``; ``wrong`` the classes named that hold no hidden effect; ``stated`` pairs
    of a class's probability and whether it holds one; ``told`` the same of the classes named.
    """

    seed: int
    hidden: tuple[str, ...]
    visible: tuple[str, ...]
    named: tuple[str, ...]
    single: tuple[str, ...]
    offered: tuple[str, ...]
    wrong: tuple[str, ...]
    stated: tuple[tuple[float, bool], ...]
    told: tuple[tuple[float, bool], ...]
    verdict: str
    text: str


def free_design(seed: int) -> Design:
    """Poses that nobody chose: 8 to 40, laid by hand, at rest and at one to three speeds."""
    rng = np.random.default_rng([seed, 50])
    count = int(rng.integers(8, 41))
    speeds = [SLOW, -SLOW, FAST, 45 * np.pi / 30][: int(rng.integers(1, 4))]

    natural = np.vstack([wedge_directions(), corner_directions()])

    def directions(n: int) -> FloatArray:
        v = rng.permutation(np.vstack([natural, natural]))[:n]
        v = v + 0.15 * rng.standard_normal((n, 3))
        return np.asarray(v / np.linalg.norm(v, axis=1, keepdims=True))

    each = max(11, count // (1 + len(speeds)))
    still = Run("stopped", None, directions(each), seconds=8.0, in_accelerometer_section=True)
    turning = tuple(
        Run(f"speed {i + 1}", PlateMotion(rate), directions(each), seconds=20.0, lead_s=60.0)
        for i, rate in enumerate(speeds)
    )
    base = rich_design()
    return replace(base, title="free", runs=(still, *turning))


def hand_design() -> Design:
    """26 poses laid by hand, once, at one temperature."""
    soak = soak_design(mpu6050())
    return replace(soak, runs=soak.runs[:1], jitter_deg=10.0)


def design_of(name: str, seed: int) -> Design:
    """The design called ``name`` with an eighth of the samples: the slow noise rules as before."""
    made = {
        "paper": paper_design, "rich": rich_design, "soak": soak_design, "hand": hand_design,
        "free": lambda: free_design(seed),
    }[name]()
    return made.scaled(sample_rate=0.125)


def disturbed(design: Design, how: str) -> Design:
    """The design with four bits less, noise correlated over seconds, or poses of three seconds."""
    sensor = design.sensor
    if how == "short":
        runs = tuple(replace(run, seconds=SHORT_POSE_S) for run in design.runs)
        return replace(design, runs=runs)
    if how == "coarse":
        sensor = replace(
            sensor,
            accelerometer=replace(sensor.accelerometer, step_counts=64),
            gyroscope=replace(sensor.gyroscope, step_counts=16),
        )
    if how == "correlated":
        sensor = replace(
            sensor,
            accelerometer=replace(sensor.accelerometer, slow_tau_s=2.0),
            gyroscope=replace(sensor.gyroscope, slow_tau_s=2.0),
        )
    return replace(design, sensor=sensor)


def draw_set(
    design: Design, seed: int, triad: str, count: int, sizes: tuple[float, float],
    names: Sequence[str] = NAMES, nested: bool = False,
) -> list[Hidden]:
    """``count`` different effects that reach the pose equations, sizes log-uniform.

    Pairs of which one holds the other are among them where ``nested``.
    """
    rng = np.random.default_rng([seed, 31, count])
    possible = [
        n for n in names
        if calibrates(n, triad) and n.partition(":")[2] in ("", *design.columns)
    ]
    chosen: list[Hidden] = []
    for name in rng.permutation(possible):
        if len(chosen) == count:
            break
        size = float(np.exp(rng.uniform(*np.log(sizes))))
        if not nested and any({str(name), h.name} in TOGETHER for h in chosen):
            continue
        same = triad == "accelerometer" and any(
            {str(name), h.name} <= ONE_MAGNITUDE for h in chosen)
        if same and not nested:
            continue
        hidden = drawn(str(name), triad, size, design, seed)  # type: ignore[arg-type]
        if hidden is not None:
            chosen.append(hidden)
    return chosen


def sound_trial(design: Design, seed: int, triad: str) -> SetOutcome:
    """The same session with nothing hidden: half of all sessions are, by the diagnosis's prior."""
    return set_trial(design, seed, triad, [])


def set_trial(design: Design, seed: int, triad: str, hidden: Sequence[Hidden]) -> SetOutcome:
    """Hide, calibrate, diagnose once; raises CalibrationError where the session is refused."""
    base = fit(poses_of(design, seed, triad, hidden), Model.of(BASE))
    return scored(seed, find(base), [h.name for h in hidden])


def scored(seed: int, found: Finding, hidden: Sequence[str]) -> SetOutcome:
    """What one diagnosis says, against what was hidden."""
    said, inclusion = found.verdict, found.posterior.inclusion
    listed = {h.name for h in found.posterior.hypotheses if h.kind == "listed"} - {*found.blind}
    visible = [n for n in hidden if n in listed]
    right = {n: {n} | COMMON_PARTS.get(n, set()) for n in visible}
    allowed = set().union(*right.values(), *(ALIKE.get(n, set()) for n in hidden), hidden)
    if "temperature_squared" in hidden and "temperature_c" in said.straight:
        allowed |= {"temperature_bias"}  # it says that a curve looks the same
    classes = {i.name: set(i.members) for i in inclusion}
    named = [classes.get(name, {name}) | ({*said.group} if name == said.name else set())
             for name in said.names]
    open_names = {m for i in inclusion if i.probability >= OFFERED for m in i.members}
    open_names |= {*said.group} if said.code == "ambiguous" else set()
    told = set().union(*named) if named else set()
    silent = said.code in ("noise", "unknown", "nothing_missing", "bad_pose")
    return SetOutcome(
        seed=seed,
        hidden=tuple(hidden),
        visible=tuple(visible),
        named=tuple(n for n in visible if right[n] & told),
        single=tuple(n for n in visible if any(len(c) == 1 and right[n] & c for c in named)),
        offered=tuple(n for n in visible
                      if right[n] & (told | (set() if silent else open_names))),
        wrong=tuple(name for name, c in zip(said.names, named, strict=True) if not c & allowed),
        stated=tuple(
            (i.probability, bool({*i.members} & allowed))
            for i in inclusion if i.kind == "listed"
        ),
        told=tuple((i.probability, bool(c & allowed))
                   for name, c in zip(said.names, named, strict=True)
                   for i in inclusion if i.name == name),
        verdict=str(said.code),
        text=f"{said.code} {said.names} "
             + " ".join(f"{'/'.join(i.members)}:{i.probability:.2f}" for i in inclusion[:6]),
    )


def reliability(outcomes: Sequence[SetOutcome]) -> str:
    """Stated probability against frequency, by tenths, with the counting error."""
    stated = np.array([each for o in outcomes for each in o.stated], dtype=float).reshape(-1, 2)
    lines = ["stated   count  mean  came true  counting error"]
    for low, high in zip((0.02, 0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.99), (0.1, 0.3, 0.5, 0.7, 0.8, 0.9,
                                                               0.99, 1.01), strict=True):
        inside = stated[(stated[:, 0] >= low) & (stated[:, 0] < high)]
        if len(inside):
            mean, true = inside.mean(axis=0)
            error = np.sqrt(max(mean * (1 - mean), 1e-4) / len(inside))
            lines.append(f"{low:4.2f}-{min(high, 1.0):4.2f} {len(inside):5d} {mean:5.3f} "
                         f"{true:8.3f}   ±{error:.3f}")
    return "\n".join(lines)
