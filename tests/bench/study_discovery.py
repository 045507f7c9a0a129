"""Formulas that nobody coded: how often they are recovered, and how often one is found in noise.

    python -m tests.bench.study_discovery [--seeds 2] [--first 0] [--design rich|hand] [--unseen]
        [--second] [--sound N]

`--second` takes the list of :mod:`tests.bench.formula_list` in the place of the first. Recovered:
the correction found is the hidden error, up to what the base holds, with a correlation over 0.95 in
the rows. Poses are made sample by sample of nothing that calib computes with.
"""

import argparse
from collections.abc import Iterator

import numpy as np

from calib.discovery.discover import discover
from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from tests.bench import formula_list
from tests.hidden_formulas import SEEN, UNSEEN, poses_of, recovered

SIZES = (10.0, 30.0, 100.0)  #: sds


def trials(args: argparse.Namespace) -> Iterator[tuple[str, bool]]:
    """Every formula at every size and seed, printed as they come."""
    seen, unseen = ((formula_list.SEEN, formula_list.UNSEEN) if args.second else (SEEN, UNSEEN))
    for name, formula in (unseen if args.unseen else seen).items():
        for sds in SIZES:
            for seed in range(args.first, args.first + args.seeds):
                right, words = recovered(formula, args.design, sds, seed)
                print(f"{'+' if right else '-'} {name} {sds:g} sd seed {seed}: {words}", flush=True)
                yield name, right


def main() -> None:
    """Print the shares."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--design", choices=["rich", "hand"], default="rich")
    parser.add_argument("--unseen", action="store_true")
    parser.add_argument("--second", action="store_true")
    parser.add_argument("--sound", type=int, default=0, help="sessions with nothing hidden instead")
    args = parser.parse_args()
    if args.sound:
        false = sum(discover(fit(poses_of(args.design, seed)[0], Model.of(BASE))) is not None
                    for seed in range(args.first, args.first + args.sound))
        print(f"false formulas: {false} of {args.sound}")
        return
    right = [each for _, each in trials(args)]
    print(f"recovered {sum(right)} of {len(right)} ({100 * np.mean(right):.0f} %)")


if __name__ == "__main__":
    main()
