"""The rate of simulated phase tracks with none, one or two defects of the times and the angles.

    python -m tests.bench.mixed_tracks [--seed 0] [--tracks 200] [--show]

Counted are tracks whose rate is within two stated sds of the truth, within four, beyond with a
warning, beyond without one, and refused; a plate that changes its rate by more than one per cent
has no truth, and counts as sound if that is said.
"""

import argparse
from collections import Counter

from tests.vision.mixed_tracks import KINDS, mixed_track, verdict


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--tracks", type=int, default=200)
    parser.add_argument("--show", action="store_true")
    options = parser.parse_args()
    count: Counter[str] = Counter()
    for i in range(options.tracks):
        case = mixed_track((options.seed, i))
        kind, said = verdict(case)
        count[kind] += 1
        if options.show and kind not in ("within 2", "unsteady, said"):
            print(f"{i:4d} {kind:<14} {' + '.join(case.defects)}: {case.about}: {said}",
                  flush=True)
    print(", ".join(f"{count[kind]} {kind}" for kind in KINDS))


if __name__ == "__main__":
    main()
