"""What halving and doubling each threshold of stillness changes for `pipeline noise`.

    python -m tests.bench.stillness_thresholds [--seeds 10]

Logs of a sensor at rest (white noise, with a random walk, delivered in bursts, sampled slowly, with
an offset) and logs of one that was not, or has a gap (pauses, a knock, a lean on the table, steps
near by, a plate). Printed per value: logs at rest that are refused, and others that pass.
"""

import argparse
from collections.abc import Callable, Sequence

import numpy as np

from calib.errors import CalibrationError
from calib.noise.stillness import require_still, sample_step_s
from calib.poses.imu_log import FloatArray, ImuLog
from tests.bench.threshold_records import with_factors
from tests.thresholds import thresholds

RATE_HZ, LENGTH_S = 100.0, 120.0
WHITE = 2e-3  #: rad/s of a sample, as of an MPU-6050
Case = Callable[[np.random.Generator, FloatArray, FloatArray], tuple[FloatArray, FloatArray]]


def _between(time_s: FloatArray, start: float, stop: float) -> FloatArray:
    return np.asarray(((time_s >= start) & (time_s < stop)).astype(float))[:, None]


def still(rng: np.random.Generator, t: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray]:
    """White noise alone."""
    return t, w


def walking(
    rng: np.random.Generator, t: FloatArray, w: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """With a random walk as large as the white noise over ten seconds."""
    return t, w + np.cumsum(WHITE / 1000 * rng.standard_normal(w.shape), axis=0)


def bursts(rng: np.random.Generator, t: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sixteen samples at a time, as a serial port delivers them."""
    return 0.16 * (np.arange(len(t)) // 16 + 1) + 1e-5 * np.arange(len(t)), w


def slow(rng: np.random.Generator, t: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Ten samples per second."""
    return t[::10], w[::10]


def offset(rng: np.random.Generator, t: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A zero-rate offset of 20 °/s, as the MPU-6050's data sheet allows."""
    return t, w + np.array([0.349, 0.0, 0.0])


def slow_pause(
    rng: np.random.Generator, t: FloatArray, w: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Ten samples per second, and 0.8 s without any."""
    kept = (t[::10] < 50) | (t[::10] >= 50.75)
    return t[::10][kept], w[::10][kept]


def pause(rng: np.random.Generator, t: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A second without samples."""
    kept = (t < 50) | (t >= 51)
    return t[kept], w[kept]


def knock(rng: np.random.Generator, t: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A tenth of a second of five degrees per second."""
    return t, w + 0.09 * _between(t, 50.0, 50.1) * np.sin(300 * t)[:, None]


def lean(rng: np.random.Generator, t: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A quarter of a degree in a second."""
    return t, w + np.radians(0.25) * _between(t, 50.0, 51.0)


def steps(rng: np.random.Generator, t: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Somebody walks by for five seconds: three and a half times the noise."""
    return t, w + 3.5 * WHITE * _between(t, 50.0, 55.0) * rng.standard_normal(w.shape)


def plate(rng: np.random.Generator, t: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A plate at 16 2/3 rpm."""
    return t, w + np.array([0.0, 0.0, 1.745])


AT_REST: Sequence[Case] = (still, walking, bursts, slow, offset)
NOT_FIT: Sequence[Case] = (pause, slow_pause, knock, lean, steps, plate)


def refused(case: Case, seed: int) -> bool:
    """Whether a log of this kind is refused."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(RATE_HZ * LENGTH_S)) / RATE_HZ
    time_s, rate = case(rng, t, WHITE * rng.standard_normal((len(t), 3)))
    log = ImuLog("log", time_s, np.full_like(rate, np.nan), rate)
    try:
        require_still(log, "gyroscope", rate, sample_step_s(log))
    except CalibrationError:
        return True
    return False


def counts(seeds: int) -> dict[str, int]:
    """Logs of each kind that are judged wrongly."""
    wrong = {each.__name__: sum(refused(each, seed) for seed in range(seeds)) for each in AT_REST}
    return wrong | {each.__name__: sum(not refused(each, seed) for seed in range(seeds))
                    for each in NOT_FIT}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=10)
    seeds = parser.parse_args().seeds
    usual = counts(seeds)
    print(f"{seeds} logs of each kind; judged wrongly as it is: "
          f"{', '.join(f'{name} {n}' for name, n in usual.items() if n) or 'none'}\n")
    print("| threshold | value | unit, origin | × 0.5 | × 2 |\n|---|---|---|---|---|")
    for one in thresholds("calib.noise"):
        if f"calib.{one.path}".rpartition(".")[0] != require_still.__module__:
            continue
        cells = []
        for now in with_factors("calib", one, lambda: counts(seeds)):
            assert now is not None
            differ = {kind: n for kind, n in now.items() if n != usual[kind]}
            cells.append(", ".join(f"{kind} {usual[kind]} → {n}" for kind, n in differ.items())
                         or "no effect")
        print(f"| {' | '.join((*one.cells, *cells))} |", flush=True)


if __name__ == "__main__":
    main()
