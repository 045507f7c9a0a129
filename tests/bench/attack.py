"""Mistakes drawn at random from a grammar of what, where and how much: what comes of each.

    python -m tests.bench.attack --first 0 --count 500 [--what zeros] [--verbose]

Every attack is a fresh session with one mistake of a drawn dose. Printed are those that end in a
silent wrong number (a parameter more than 4 stated sds off where nothing is said), in a wrong
claim, in a bug, or after more than 20 s of processor time; a table of what came of each kind of
mistake (``open``: told, and no cause is claimed); and the confusion matrix of the mistake that was
made and the causes that were claimed, by sentences of their own (``tests.attack.claims``).
"""

import argparse
import tempfile
import time
import traceback
from collections import Counter, defaultdict
from collections.abc import Mapping
from pathlib import Path

from tests.attack.configured import CONFIGURATIONS
from tests.attack.grammar import MISTAKES, drawn

LONG_S = 20.0
KINDS = ("silent", "bug", "long", "harmless", "right", "open", "wrong")
Table = Mapping[str, Counter[str]]


def main() -> None:
    """Print what is wrong as it comes, and the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--what", choices=[*MISTAKES, *CONFIGURATIONS])
    parser.add_argument("--verbose", action="store_true")
    options = parser.parse_args()
    table: dict[str, Counter[str]] = defaultdict(Counter)
    matrix: dict[str, Counter[str]] = defaultdict(Counter)
    for seed in range(options.first, options.first + options.count):
        attack, begun = drawn(seed, options.what), time.process_time()
        with tempfile.TemporaryDirectory() as folder:
            try:
                judged = attack.judged(Path(folder))
            except Exception:  # a bug is a result here
                table[attack.what]["bug"] += 1
                print(f"{seed} {attack.words}: BUG {traceback.format_exc(limit=-3)}", flush=True)
                continue
        seconds = time.process_time() - begun
        kind, claims = attack.outcome(judged)
        table[attack.what][kind] += 1
        table[attack.what]["long"] += seconds > LONG_S
        if kind not in ("harmless", "silent"):
            matrix[attack.what].update(claims.causes or ("open",))
        if kind in ("silent", "wrong") or seconds > LONG_S or options.verbose:
            print(f"{seed} {attack.words}: {kind} {', '.join(claims.causes)}, {judged.worst:.1f} "
                  f"sds, {seconds:.1f} s, code {judged.code}: {judged.said.strip()[:300]}",
                  flush=True)
    _print_outcomes(table)
    _print_matrix(matrix)


def _print_outcomes(table: Table) -> None:
    print(f"\n{'mistake':16} {'n':>4} " + " ".join(f"{kind:>8}" for kind in KINDS))
    whole: Counter[str] = sum(table.values(), Counter())
    for what, counts in [*sorted(table.items()), ("all", whole)]:
        n = sum(counts.values()) - counts["long"]
        print(f"{what:16} {n:4d} " + " ".join(f"{counts[kind]:8d}" for kind in KINDS))
    claimed, said = whole["right"] + whole["wrong"], whole["right"] + whole["wrong"] + whole["open"]
    print(f"right: {100 * whole['right'] / max(claimed, 1):.1f} % of {claimed} with a claim, "
          f"{100 * whole['right'] / max(said, 1):.1f} % of {said} that were told")


def _print_matrix(matrix: Table) -> None:
    """Mistakes made down, causes claimed across, by numbers; some attacks have two claims."""
    causes = sorted({cause for counts in matrix.values() for cause in counts})
    print("\n" + "\n".join(f"{i:3d} {cause}" for i, cause in enumerate(causes, 1)))
    print(f"\n{'made / claimed':16} " + " ".join(f"{i:4d}" for i in range(1, len(causes) + 1)))
    for what, counts in sorted(matrix.items()):
        print(f"{what:16} " + " ".join(f"{counts[cause] or '.':>4}" for cause in causes))


if __name__ == "__main__":
    main()
