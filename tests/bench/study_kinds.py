"""Steps, wander and extra noise: how often the diagnosis names the right kind.

    python -m tests.bench.study_kinds [--seeds 10] [--first 0] [--sds 5] [--design rich]
        [--triad gyroscope]

A bias that steps once and one that wanders are those of the simulated bench, of ``--sds`` noise
units, rms over the pose equations. Extra noise is an error of ``--sds`` stated sds drawn anew for
every pose and axis. Right: the verdict's name is of the kind that was hidden; offered: it is in the
verdict's group. The last line has the same sessions with nothing hidden.
"""

import argparse
from collections import Counter
from dataclasses import replace

import numpy as np

from calib.diagnosis.diagnose import diagnose
from calib.effects.catalogue import BASE
from calib.errors import CalibrationError
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.poses.pose_set import PoseSet
from tests.set_trials import design_of
from tests.trials import poses_of
from tests.world.bench import Design
from tests.world.hidden import TriadName
from tests.world.sizes import draw_effect

KINDS = {"jump": {"bias_step"}, "wander": {"bias_wander"}, "noise": {"extra_noise"},
         "nothing": {None}}
"""What is hidden, and the names that are right."""


def spoilt(kind: str, design: Design, triad: TriadName, sds: float, seed: int) -> PoseSet:
    """The poses of one evening that hides ``kind``."""
    if kind in ("jump", "wander"):
        return poses_of(design, seed, triad, [draw_effect(kind, triad, sds, design, seed)])
    poses = poses_of(design, seed, triad, [])
    random = np.random.default_rng([seed, 60])
    size = sds if kind == "noise" else 0.0
    return replace(poses, reading=poses.reading + size * poses.sd * random.normal(
        size=poses.sd.shape))


def main() -> None:
    """Print the shares and every verdict."""
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--sds", type=float, default=5.0)
    parser.add_argument("--design", choices=["rich", "soak", "hand", "paper"], default="rich")
    parser.add_argument("--triad", choices=["gyroscope", "accelerometer"], default="gyroscope")
    args = parser.parse_args()
    for kind, names in KINDS.items():
        said: Counter[str] = Counter()
        right = offered = 0
        for seed in range(args.first, args.first + args.seeds):
            try:
                poses = spoilt(kind, design_of(args.design, seed), args.triad, args.sds, seed)
                verdict = diagnose(fit(poses, Model.of(BASE)))
            except CalibrationError:
                said["refused"] += 1
                continue
            right += verdict.name in names
            offered += bool({*verdict.group} & names)
            said[" ".join(filter(None, [verdict.verdict, *(verdict.names or [verdict.name])]))] += 1
        every = ", ".join(f"{count} {words}" for words, count in said.most_common())
        print(f"{kind}: right {right} of {args.seeds}, offered {offered}; {every}", flush=True)


if __name__ == "__main__":
    main()
