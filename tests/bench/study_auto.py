"""What `add --auto` ends with on measured sessions of other people, beside the best single effect.

    python -m tests.bench.study_auto [--sound 30] [SESSION...]

For each triad of each session:

- the exact leave-one-out error, mm/s² and °/s, with bias, scale and misalignment as configured,
  with the listed effect that lowers it most by itself, and with what `add --auto` leaves in the
  configuration;
- chance: in how many of ``--sound`` sessions with nothing hidden, of these poses and sds, the best
  single effect lowers that error by as much. The effect is chosen by the error that is shown, and
  of few poses that error rests on those that alone hold a parameter up;
- by parts: effect and verdict are chosen without a part of the poses and judged on it, in sds of
  the base's prediction; a dash where too few poses are left to choose. What is drawn (a wander)
  predicts no part, and counts as what it leaves in the parameters;
- other sessions of the same sensor: the same, chosen on all of this one and judged on all of the
  other. Effects of a session (a drift, a step) say nothing there, and the bias is fitted anew.

The last column is which of both errs less by parts (within 1 % the same), and the verdict at the
end. A refused triad is left out of the configuration.
"""

import argparse
import contextlib
import io
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from calib.diagnosis.verdict.decision import Code
from calib.errors import CalibrationError
from calib.fit.least_squares.result import Fit
from calib.fit.validation.leave_one_out import compare
from pipeline.cli import main as pipeline
from pipeline.config.load import load_config
from pipeline.stages.context import RunContext
from pipeline.stages.run import Outcome, run_stages
from pipeline.text.formatting import DISPLAY
from tests.bench.left_out_parts import (
    Judged,
    as_the_verdict_says,
    best_single,
    elsewhere,
    judge,
    sound_sessions,
)
from tests.studies.real_sets.logs import LOGS, Log

SAME = 0.01  #: relative; errors that differ by less are printed as the same
OTHER_SESSIONS = (("snu good2", "snu good3"), ("snu good3", "snu good2"),
                  ("sundevil long", "sundevil short"), ("sundevil short", "sundevil long"))


def ran(config: Path) -> Outcome:
    """The stages of ``config``; nothing is written."""
    return run_stages(load_config(config), RunContext())


def before_and_after(log: Log, folder: Path) -> tuple[Outcome, Outcome, str]:
    """The session as configured and after `add --auto`, and what was refused."""
    text, config, refused = log.configuration(), folder / "config.yaml", ""
    config.write_text(text, encoding="utf-8")
    try:
        before = ran(config)
    except CalibrationError as refusal:
        refused = str(refusal)
        alone = text[: text.index("accelerometer:\n")] + text[text.index("gyroscope:\n"):]
        config.write_text(alone, encoding="utf-8")
        before = ran(config)
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        pipeline(["add", str(config), "--auto", "--quiet"])
    return before, ran(config), refused


def chance(base: Fit, ratio: float, sound: int) -> str:
    """Share of sound sessions in which the best single effect lowers the error to ``ratio``."""
    ratios = []
    for one in sound_sessions(base, sound):
        _, best = best_single(one)
        ratios.append(compare(best).loo_rms / compare(one).loo_rms)
    if not ratios:
        return "-"
    return f"{100 * np.mean(np.array(ratios) <= ratio):.0f} % (median {np.median(ratios):.2f})"


def words_of(judged: Judged | None) -> tuple[str, str]:
    """The errors by parts with what was chosen most often, and which of both errs less."""
    if judged is None:
        return "-", "-"
    single, named = (Counter(each).most_common(1)[0][0] for each in (judged.singles, judged.named))
    ratio = judged.verdict / judged.single
    which = "same" if abs(ratio - 1) < SAME else "lower" if ratio < 1 else "higher"
    return (f"{judged.base:.3g}, {single} {judged.single:.3g}, {named} {judged.verdict:.3g}", which)


def lines_of(log: Log, folder: Path, sound: int) -> Iterator[str]:
    """The rows of one session."""
    before, after, refused = before_and_after(log, folder)
    if refused:
        yield f"{log.name} | accelerometer | refused: {refused[:60]}"
    for one, then in zip(before.triads, after.triads, strict=True):
        unit, factor = DISPLAY[one.triad]
        base = one.calibration.fit
        name, best = best_single(base)
        loo = [factor * each.loo_rms for each in (
            one.comparison, compare(best), then.comparison)]
        added = [n for n in then.calibration.fit.model.names if n not in base.model.names]
        end = then.diagnosis
        names = "" if end.verdict is Code.BAD_POSE else ", ".join(end.group or filter(
            None, [end.name]))
        parts, which = words_of(judge(base))
        by_chance = chance(base, loo[1] / loo[0], sound)
        yield (f"{log.name} | {one.triad}, {len(base.poses)} poses | {loo[0]:.3g} {unit}, {name} "
               f"{loo[1]:.3g}, {' + '.join(added) or 'nothing'} {loo[2]:.3g} | {by_chance} | "
               f"{parts} | {which} | {end.verdict} {names}")


def other_sessions() -> Iterator[str]:
    """What is chosen on one session, judged on another of the same sensor."""
    for one, other in OTHER_SESSIONS:
        with tempfile.TemporaryDirectory() as folder:
            config, outcomes = Path(folder) / "config.yaml", []
            for name in (one, other):
                config.write_text(LOGS[name].configuration(), encoding="utf-8")
                outcomes.append(ran(config))
        for here, there in zip(outcomes[0].triads, outcomes[1].triads, strict=True):
            fits = here.calibration.fit, there.calibration.fit
            chosen = {"base": fits[0]}
            for name, fitted in (best_single(fits[0]), as_the_verdict_says(fits[0])):
                chosen[name] = fitted
            errors = ", ".join(f"{name} {elsewhere(fitted, fits[1]):.3g}"
                               for name, fitted in chosen.items())
            yield f"{one} on {other} | {here.triad} | {errors}"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sessions", nargs="*", choices=[*LOGS, []], metavar="SESSION")
    parser.add_argument("--sound", type=int, default=30)
    args = parser.parse_args()
    print("session | triad | leave-one-out: base, best single, --auto | chance | by parts: base, "
          "single, verdict | verdict beside single | at the end")
    for name in args.sessions or list(LOGS):
        with tempfile.TemporaryDirectory() as folder:
            for line in lines_of(LOGS[name], Path(folder), args.sound):
                print(line, flush=True)
    if not args.sessions:
        for line in other_sessions():
            print(line, flush=True)


if __name__ == "__main__":
    main()
