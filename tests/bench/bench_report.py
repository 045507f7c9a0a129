"""How long the report takes beside the run that it reports, in the same process; its size.

Run: python tests/bench/bench_report.py [CONFIG...]; by default the shipped sessions and, where
they are, those of the bench beside the project. Results go to a temporary folder.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from pipeline.config.load import load_config
from pipeline.stages.context import RunContext
from pipeline.stages.run import run_stages
from tests.paths import ROOT

CONFIGS = (
    ROOT / "data/example/config.yaml",
    ROOT / "data/hidden_effect/config.yaml",
    *(ROOT.parent / f"shared/bench/{name}/config.yaml" for name in "abc"),
)


def import_s() -> float:
    """Seconds that the report's own imports add to those of a run."""
    code = ("import time, pipeline.stages.run, pipeline.results.history; t = time.perf_counter(); "
            "import pipeline.report.page; print(time.perf_counter() - t)")
    said = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True,
                          check=True)
    return float(said.stdout)


def main() -> None:
    """Print seconds and kilobytes of each report."""
    print(f"import {import_s():.2f} s")
    from pipeline.report.page import report_html

    for path in [Path(each) for each in sys.argv[1:]] or CONFIGS:
        if not path.exists():
            continue
        config = load_config(path)
        with tempfile.TemporaryDirectory() as folder:
            begun = time.perf_counter()
            outcome = run_stages(config, RunContext(Path(folder)))
            ran = time.perf_counter()
            page = report_html(outcome, ())
            took = time.perf_counter() - ran
        print(f"{path.parent.name:14s} run {ran - begun:5.1f} s  report {took:4.2f} s, "
              f"{100 * took / (ran - begun):3.0f} % of it  {len(page.encode()) / 1e3:4.0f} kB")


if __name__ == "__main__":
    main()
