"""Regenerates the sessions that ship in ``data/``: ``python -m tests.world.make_data [FOLDER]``."""

import hashlib
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from tests.paths import DATA
from tests.world.designs import SLOW, paper_design, rich_design
from tests.world.hidden import Hidden
from tests.world.plate import PlateMotion
from tests.world.scene import Scene
from tests.world.session import Session, simulate
from tests.world.write import Camera, write_session

SESSIONS = ("example", "hidden_effect")

# A record player of the 1970s: once per turn from the hub, twice from the belt.
WOW = ((1.0, 8e-4, 0.7), (2.0, 3e-4, 2.1))
EXAMPLE_SEED, HIDDEN_EFFECT_SEED = 1_676, 3_333

G_SENSITIVITY_DEG_S_PER_G = np.array(  # of an MPU-6050's order, largest terms off the diagonal
    [[0.031, 0.118, -0.042], [-0.087, 0.054, 0.103], [0.066, -0.095, -0.072]]
)


def example_session() -> Session:
    """The published experiment, nothing hidden."""
    return simulate(paper_design(motion=PlateMotion(SLOW * 1.0021, wow=WOW)), EXAMPLE_SEED)


def hidden_effect_session() -> Session:
    """The tutorial: a gyroscope that feels gravity, and nothing else out of the ordinary."""
    design = rich_design()
    runs = tuple(
        run
        if run.motion is None
        else replace(
            run, motion=replace(run.motion, rate_rad_s=run.motion.rate_rad_s * 0.9987, wow=WOW)
        )
        for run in design.runs
    )
    design = replace(
        design,
        title="MPU-6050, two speeds, both directions and plate stopped",
        runs=runs,
        sample_rate_hz=50.0,
        columns={},
    )
    per_si = np.deg2rad(G_SENSITIVITY_DEG_S_PER_G) / 9.80665
    return simulate(design, HIDDEN_EFFECT_SEED, (Hidden("g_sensitivity", "gyroscope", per_si),))


def webcam(seed: int) -> Camera:
    """A webcam somewhat off the vertical, its clock 12 ppm fast."""
    from tests.world.film import Recorder

    return Camera(scene=Scene(tilt_rad=0.12), recorder=Recorder(crf=30, clock_ppm=12.0), seed=seed,
                  model=("constant_rate", "once_per_rev", "twice_per_rev"))


def make(folder: Path) -> None:
    """Write both sessions into ``folder`` and bring the list of files in its README up to date."""
    write_session(folder / "example", example_session(), film=webcam(EXAMPLE_SEED))
    write_session(
        folder / "hidden_effect",
        hidden_effect_session(),
        film=webcam(HIDDEN_EFFECT_SEED),
        compressed=True,
    )
    readme = folder / "README.md"
    if readme.exists():
        head, _, rest = readme.read_text(encoding="utf-8").partition(LIST_BEGINS)
        tail = rest.partition(LIST_ENDS)[2]
        listed = f"{LIST_BEGINS}\n{file_list(folder)}{LIST_ENDS}"
        readme.write_text(head + listed + tail, encoding="utf-8")


LIST_BEGINS, LIST_ENDS = "<!-- files: made by the generator -->", "<!-- files: end -->"


def _ships(path: Path) -> bool:
    """Files of the session, not the results that somebody made from it."""
    return path.is_file() and not any(part.endswith(".run") for part in path.parts)


def file_list(folder: Path) -> str:
    """Every file of both sessions with its size and sha256, one line each."""
    files = sorted(p for name in SESSIONS for p in (folder / name).rglob("*") if _ships(p))
    lines = ["| file | bytes | sha256 |", "|---|---|---|"]
    for path in files:
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        lines += [
            f"| `{path.relative_to(folder).as_posix()}` | {path.stat().st_size} | `{digest}` |"
        ]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    make(Path(sys.argv[1]) if len(sys.argv) > 1 else DATA)
