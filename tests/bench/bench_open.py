"""How long the workbench takes for a tick and for a pose that is left out, asked by ten at once.

Run: python -m tests.bench.bench_open. The session of the tutorial has 90 poses; the other one is
simulated, a table of the means of 10,000 poses (seed 1). The clock runs from the first question of
ten threads to the answer of each, in the process of the answers, without HTTP.
"""

import shutil
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from calib.poses.imu_log import Triad
from pipeline.workbench.live_refits import OpenSession
from pipeline.workbench.state import Screen, TriadScreen
from tests.paths import ROOT

CLIENTS = 10
MANY = 10_000
CONFIG = """\
sensor: {accelerometer: {unit: m_s2}}
site: {gravity_m_s2: 9.81, sd_m_s2: 0.001}
accelerometer: {poses: {means: means.csv}}
"""


def many_poses(folder: Path) -> Path:
    """A configuration of many poses of an accelerometer with noise of 0.01 m/s²."""
    rng = np.random.default_rng(1)
    up = rng.normal(size=(MANY, 3))
    force = 9.81 * up / np.linalg.norm(up, axis=1, keepdims=True)
    reading = force * [1.01, 0.99, 1.02] + [0.1, -0.2, 0.05] + rng.normal(0, 0.01, force.shape)
    rows = (",".join(f"{value:.6f}" for value in row) + ",0.01,0.01,0.01" for row in reading)
    (folder / "means.csv").write_text("\n".join(
        ["acc_x,acc_y,acc_z,sd_acc_x,sd_acc_y,sd_acc_z", *rows]) + "\n", encoding="utf-8")
    config = folder / "config.yaml"
    config.write_text(CONFIG, encoding="utf-8")
    return config


Asked = tuple[tuple[str, ...], tuple[int, ...]]


def print_times(session: OpenSession, triad: Triad, name: str, states: Sequence[Asked]) -> None:
    """Ten clients ask for each state, effects and numbers of poses, at once: a line for each."""
    labels = [*session.sections[triad]]
    for ticked, out in states:
        base = {"accelerometer": TriadScreen(())}
        state = Screen({**base, triad: TriadScreen(ticked, tuple(labels[k] for k in out))}, {})
        begun, worked = time.perf_counter(), time.process_time()

        def seconds(_: int, state: Screen = state, begun: float = begun) -> float:
            session.answer(state, triad, ())
            return time.perf_counter() - begun

        with ThreadPoolExecutor(CLIENTS) as clients:
            took = [1e3 * each for each in clients.map(seconds, range(CLIENTS))]
        print(f"{name}, {' + '.join(ticked) or 'base'}, {len(out)} poses out: "
              f"{np.median(took):.0f} ms median, {max(took):.0f} ms worst, "
              f"{1e3 * (time.process_time() - worked):.0f} ms of processor for all")


def main() -> None:
    """Print the times of both sessions."""
    with tempfile.TemporaryDirectory() as folder:
        where = Path(folder)
        shutil.copytree(ROOT / "data/hidden_effect", where / "session")
        session = OpenSession(where / "session/config.yaml", where / "cache", False)
        print_times(session, "gyroscope", "90 poses", [
            ((), ()), (("g_sensitivity",), ()), (("quadratic",), ()), (("g_sensitivity",), (4,)),
            (("g_sensitivity",), (4, 30))])
        begun = time.perf_counter()
        session = OpenSession(many_poses(where), where / "cache", False)
        print(f"{MANY} poses are opened in {time.perf_counter() - begun:.1f} s")
        print_times(session, "accelerometer", f"{MANY} poses", [
            ((), ()), (("quadratic",), ()), (("cubic",), ()), (("quadratic",), (4,))])


if __name__ == "__main__":
    main()
