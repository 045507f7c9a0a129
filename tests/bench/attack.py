"""Mistakes drawn at random from a grammar of what, where and how much: what comes of each.

    python -m tests.bench.attack --first 0 --count 500 [--what zeros]

Every attack is a fresh session with one mistake of a drawn dose. Printed are those that end in a
silent wrong number (a parameter more than 4 stated sds off where nothing is said), in a bug, or
after more than 20 s of processor time; and per kind of mistake how many were harmless (no parameter
is off), told (refused, warned of or given a verdict) and told by words that name it.
"""

import argparse
import tempfile
import time
import traceback
from collections import Counter, defaultdict
from pathlib import Path

from tests.attack.configured import CONFIGURATIONS
from tests.attack.grammar import MISTAKES, drawn

LONG_S = 20.0


def main() -> None:
    """Print what is wrong as it comes, and the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--what", choices=[*MISTAKES, *CONFIGURATIONS])
    parser.add_argument("--verbose", action="store_true")
    options = parser.parse_args()
    table: dict[str, Counter[str]] = defaultdict(Counter)
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
        kind = attack.outcome(judged)
        table[attack.what][kind] += 1
        if seconds > LONG_S:
            table[attack.what]["long"] += 1
        if kind in ("silent", "told") or seconds > LONG_S or options.verbose:
            print(f"{seed} {attack.words}: {kind}, {judged.worst:.1f} sds, {seconds:.1f} s, code "
                  f"{judged.code}: {judged.said.strip()[:300]}", flush=True)
    kinds = ("silent", "bug", "long", "harmless", "named", "told")
    print(f"\n{'mistake':16} {'n':>4} " + " ".join(f"{kind:>8}" for kind in kinds))
    whole: Counter[str] = Counter()
    for what, counts in sorted(table.items()):
        whole += counts
        print(_row(what, counts, kinds))
    print(_row("all", whole, kinds))
    said = whole["named"] + whole["told"]
    print(f"named by its words: {100 * whole['named'] / max(said, 1):.1f} % of {said}")


def _row(what: str, counts: Counter[str], kinds: tuple[str, ...]) -> str:
    n = sum(count for kind, count in counts.items() if kind != "long")
    return f"{what:16} {n:4d} " + " ".join(f"{counts[kind]:8d}" for kind in kinds)


if __name__ == "__main__":
    main()
