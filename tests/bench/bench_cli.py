"""How long ``pipeline --help`` takes, beside a bare Python. Run: python tests/bench/bench_cli.py"""

import subprocess
import sys
import time

from tests.paths import ROOT

RUNS = 25


def best_ms(*arguments: str) -> float:
    """The fastest of ``RUNS`` runs of Python with these arguments, in milliseconds."""
    best = float("inf")
    for _ in range(RUNS):
        begun = time.perf_counter()
        subprocess.run([sys.executable, *arguments], cwd=ROOT, stdout=subprocess.DEVNULL,
                       check=True)
        best = min(best, time.perf_counter() - begun)
    return best * 1e3


def main() -> None:
    """Print the times and their ratio to a bare start."""
    bare = best_ms("-c", "pass")
    # The installed script of older pip versions imports re before it calls main().
    for name, arguments in {
        "python -c pass": ("-c", "pass"),
        "python -m pipeline --help": ("-m", "pipeline", "--help"),
        "installed script --help": (
            "-c", "import re, sys; from pipeline.cli import main; sys.exit(main(['--help']))"),
        "python -m pipeline check --help": ("-m", "pipeline", "check", "--help"),
    }.items():
        taken = best_ms(*arguments)
        print(f"{name:34s} {taken:6.1f} ms  {taken / bare:4.1f} x")


if __name__ == "__main__":
    main()
