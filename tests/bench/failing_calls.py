"""Faults of the machine at calls drawn at random, over the commands: what is wrong afterwards.

    python -m tests.bench.failing_calls --draws 30 [--fault read] [--seed 0]
    python -m tests.bench.failing_calls --any-order 100

A call of a function of the program finds no memory, or the reading of a file of the session fails.
Printed are, for each command, how many calls there are, how many were tried, and each that ends in
a bug, in a message without its reason, in files that have changed although the command failed, or
in a session that the next command does not mend. With ``--any-order`` so many sequences of 20
commands, some of which are killed or find the disk full, end at the first files that do not agree.
"""

import argparse
import contextlib
import io
import tempfile
from pathlib import Path

from tests.attack.any_order import run_in_any_order
from tests.attack.failing import COMMANDS, Fault, calls_of, complaints, draws
from tests.sessions import accelerometer_alone, pipeline

FAULTS: tuple[Fault, ...] = ("memory", "read")


def main() -> None:
    """Print a line for each command and fault."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=30)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--any-order", type=int, default=0, dest="examples")
    parser.add_argument("--fault", choices=FAULTS)
    options = parser.parse_args()
    tried = wrong = 0
    with tempfile.TemporaryDirectory() as name:
        folder, printed = Path(name), io.StringIO()
        prepared = accelerometer_alone(folder / "prepared")

        def said() -> list[str]:
            text = printed.getvalue()
            printed.seek(0)
            printed.truncate()
            return [text]

        with contextlib.redirect_stderr(printed), contextlib.redirect_stdout(printed):
            pipeline("run", prepared)
        if options.examples:
            with contextlib.redirect_stderr(printed), contextlib.redirect_stdout(printed):
                run_in_any_order(prepared, options.examples, 20)
            print(f"{options.examples} times 20 commands in any order: nothing wrong", flush=True)
            return
        for command in COMMANDS:
            for fault in FAULTS if options.fault is None else (options.fault,):
                with contextlib.redirect_stderr(printed), contextlib.redirect_stdout(printed):
                    calls, whole = calls_of(command, fault, prepared, folder / f"{tried}")
                    said()
                    found = [complaint for at in draws(calls, options.draws, options.seed)
                             for complaint in complaints(command, fault, at, prepared,
                                                         folder / f"{tried}-{fault}-{at}",
                                                         whole, said)]
                tried += min(options.draws, calls)
                wrong += len(found)
                print(f"{command}, {fault}: {calls} calls, {len(found)} wrong", flush=True)
                for complaint in found:
                    print(f"    {complaint}", flush=True)
    print(f"{wrong} of {tried} wrong")


if __name__ == "__main__":
    main()
