"""Formulas that nobody coded: how often they are recovered, and how often one is found in noise.

    python -m tests.bench.study_discovery [--seeds 2] [--first 0] [--design rich|hand] [--unseen]
        [--list first|second|third] [--sound N]

The lists are those of :mod:`tests.hidden_formulas`, :mod:`tests.second_formulas` and
:mod:`tests.third_formulas`; the third has three more logged columns. Recovered:
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
from tests import hidden_formulas, second_formulas, third_formulas
from tests.hidden_formulas import poses_of, recovered

SIZES = (10.0, 30.0, 100.0)  #: sds
LISTS = {"first": (hidden_formulas, None), "second": (second_formulas, None),
         "third": (third_formulas, third_formulas.with_bench_columns)}


def trials(args: argparse.Namespace) -> Iterator[tuple[str, bool]]:
    """Every formula at every size and seed, printed as they come."""
    formulas, more = LISTS[args.list]
    for name, formula in (formulas.UNSEEN if args.unseen else formulas.SEEN).items():
        for sds in SIZES:
            for seed in range(args.first, args.first + args.seeds):
                right, words = recovered(formula, args.design, sds, seed, more=more)
                print(f"{'+' if right else '-'} {name} {sds:g} sd seed {seed}: {words}", flush=True)
                yield name, right


def main() -> None:
    """Print the shares."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--design", choices=["rich", "hand"], default="rich")
    parser.add_argument("--unseen", action="store_true")
    parser.add_argument("--list", choices=list(LISTS), default="first")
    parser.add_argument("--sound", type=int, default=0, help="sessions with nothing hidden instead")
    args = parser.parse_args()
    if args.sound:
        more = LISTS[args.list][1]
        false = sum(discover(fit(poses_of(args.design, seed, more=more)[0], Model.of(BASE)))
                    is not None for seed in range(args.first, args.first + args.sound))
        print(f"false formulas: {false} of {args.sound}")
        return
    right = [each for _, each in trials(args)]
    print(f"recovered {sum(right)} of {len(right)} ({100 * np.mean(right):.0f} %)")


if __name__ == "__main__":
    main()
