"""What `add --auto` ends with on measured sessions of other people, beside the best single effect.

    python -m tests.bench.study_auto [SESSION...]

For each triad of each session: the exact leave-one-out error with bias, scale and misalignment as
configured, with the listed effect that lowers it most by itself, and with what `add --auto` leaves
in the configuration; mm/s² and °/s. Where that is larger than with the single effect, the verdict
at the end says why that one was not taken. A refused triad is left out of the configuration.
"""

import argparse
import contextlib
import io
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from calib.diagnosis.hypotheses.listed import listed_hypotheses
from calib.diagnosis.search.refit import refit
from calib.diagnosis.verdict.decision import Code
from calib.effects.catalogue import STEP
from calib.effects.effect import EFFECTS
from calib.errors import CalibrationError
from calib.fit.least_squares.result import Fit
from calib.fit.validation.leave_one_out import compare
from pipeline.cli import main as pipeline
from pipeline.config.load import load_config
from pipeline.stages.context import RunContext
from pipeline.stages.run import Outcome, run_stages
from pipeline.text.formatting import DISPLAY
from tests.studies.real_sets.logs import LOGS, Log

SAME = 0.01  #: relative; errors that differ by less are printed as the same


def best_single(fit: Fit) -> tuple[str, float]:
    """The listed effect that alone lowers the leave-one-out error most, and that error, SI."""
    at = fit.equations.at_reading
    effects = {h.name: h.effect for h in listed_hypotheses(fit)[0] if h.effect is not None}
    if np.isfinite(fit.poses.time_s).all():
        effects[STEP] = EFFECTS[STEP].within(at)
    best, least = "none", compare(fit).loo_rms
    for name, effect in effects.items():
        joint = refit(fit, [effect])
        if joint is not None and compare(joint.fit).loo_rms < least:
            best, least = name, compare(joint.fit).loo_rms
    return best, least


def ran(config: Path) -> Outcome:
    """The stages of ``config``; nothing is written."""
    return run_stages(load_config(config), RunContext())


def lines_of(log: Log, folder: Path) -> Iterator[str]:
    """The rows of one session."""
    text, config = log.configuration(), folder / "config.yaml"
    config.write_text(text, encoding="utf-8")
    try:
        before = ran(config)
    except CalibrationError as refusal:
        yield f"{log.name} | accelerometer | refused: {str(refusal)[:60]}"
        if not log.gyroscope:
            return
        alone = text[: text.index("accelerometer:\n")] + text[text.index("gyroscope:\n"):]
        config.write_text(alone, encoding="utf-8")
        before = ran(config)
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        code = pipeline(["add", str(config), "--auto", "--quiet"])
    after = ran(config)
    for one, then in zip(before.triads, after.triads, strict=True):
        unit, factor = DISPLAY[one.triad]
        name, least = best_single(one.calibration.fit)
        loo = [factor * each.comparison.loo_rms for each in (one, then)]
        added = [n for n in then.calibration.fit.model.names
                 if n not in one.calibration.fit.model.names]
        end = then.diagnosis
        names = "" if end.verdict is Code.BAD_POSE else ", ".join(end.group or filter(
            None, [end.name]))
        ratio = loo[1] / (factor * least)
        which = "same" if abs(ratio - 1) < SAME else "lower" if ratio < 1 else "higher"
        yield (f"{log.name} | {one.triad} | {loo[0]:.3g} {unit} | {name} {factor * least:.3g} | "
               f"{' + '.join(added) or 'nothing'} {loo[1]:.3g} | {which} | {end.verdict} "
               f"{names}{f' (exit {code})' if code else ''}")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sessions", nargs="*", choices=[*LOGS, []], metavar="SESSION")
    print("session | triad | base | best single | --auto | beside it | verdict at the end")
    for name in parser.parse_args().sessions or list(LOGS):
        with tempfile.TemporaryDirectory() as folder:
            for line in lines_of(LOGS[name], Path(folder)):
                print(line, flush=True)


if __name__ == "__main__":
    main()
