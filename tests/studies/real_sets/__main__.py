"""Verdicts on measured sessions of other people, held against an independent fit.

    python -m tests.studies.real_sets [SESSION...]

The first table has a line for each triad of each session: what the program says, and what stops
that took no part in a fit say of it (own search for stops, own model, SciPy). ``base`` is the rms
error of left-out stops with bias, scale and misalignment, ``named`` with the first effect that the
program names, ``best`` with the single effect that lowers it most; mm/s² and °/s. The last column
is the judgement: a name must lower the error of left-out stops, and where nothing is named no
effect may lower it by more than a fifth. The second table predicts a session with the calibration
of another of the same sensor, the third the poses of each face by a calibration without them.
"""

import argparse
from collections.abc import Iterator, Mapping

import numpy as np

from pipeline.stages.triads import TriadResult
from tests.studies.real_sets.independent import (
    Judged,
    best_step,
    judge_accelerometer,
    judge_gyroscope,
    weighted,
)
from tests.studies.real_sets.logs import LOGS, Log, Stops, stops_of
from tests.studies.real_sets.pose_means import fit_means
from tests.studies.real_sets.program import (
    LostFace,
    Said,
    ask,
    ask_means,
    ask_turntable,
    corrected_magnitude,
    prediction_words,
    without_each_face,
)
from tests.studies.real_sets.turntable import fit_turntable

PAIRS = (("snu good3", "snu good2"), ("snu good3", "snu good1"), ("snu good2", "snu good3"),
         ("sundevil long", "sundevil short"), ("sundevil short", "sundevil long"))  # fmt: skip
SPARE = 0.8
"""Left-out error over that of the base from which an effect that nobody named counts as missed."""

IN_TIME = ("bias_step", "bias_drift", "temperature_bias")
"""Effects by which an independent fit follows a course of the bias in time."""


def judgement(result: TriadResult, judged: Mapping[str, Judged]) -> str:
    """Whether left-out stops support the verdict."""
    said, base = result.diagnosis, judged["base"].left_out
    named = [name for name in said.names if name in judged]
    if said.verdict == "effect":
        if not named:
            return f"not checked: no fit of '{said.name}' here"
        return "yes" if judged[named[0]].left_out < base else "NO: it errs more with it"
    best = min((n for n in judged if n != "base"), key=lambda n: judged[n].left_out)
    missed = judged[best].left_out < SPARE * base
    if not missed:
        return "yes" if said.verdict in ("nothing_missing", "noise", "ambiguous") else (
            "nothing here contradicts it")
    if best in IN_TIME and (said.name in ("bias_step", "time_s", "bias_wander", "temperature_c")
                            or {*said.group} & {"bias_step", "bias_wander", "~time_s", best}):
        return "yes"
    if best in said.group:
        return "yes: offered"
    weak = result.prediction is not None and not result.prediction.holds_everywhere
    return f"NO: {best} errs less" if not weak else f"open: {best} errs less, directions missing"


def verdict_lines(log: Log, said: Said, stops: Stops) -> Iterator[str]:
    """The lines of one session in the first table."""
    if said.accelerometer is None:
        yield f"{log.name:16s} acc  {len(stops):3d} stops  refused: {said.refusal[:90]}"
    for result, unit in ((said.accelerometer, 1e3), (said.gyroscope, 180 / np.pi)):
        if result is None:
            continue
        judged = best_step(judge_accelerometer(stops, log.gravity) if unit == 1e3
                           else judge_gyroscope(stops))
        yield f"{log.name:16s} {result.triad[:3]}  {_line(result, judged, len(stops), unit)}"


def _line(result: TriadResult, judged: Mapping[str, Judged], stops: int, unit: float) -> str:
    said = result.diagnosis
    name = " + ".join(said.names) or said.name or ""
    if said.verdict == "ambiguous":
        name = ", ".join(said.group)
    best = min((n for n in judged if n != "base"), key=lambda n: judged[n].left_out)
    first = judged.get(said.names[0]) if said.names else None
    stated = "" if result.prediction is None else prediction_words(result.prediction)
    named = f"{first.left_out * unit:.3g}" if first else "-"
    return (
        f"{len(said_poses(result)):3d} of {stops:3d} stops  {said.verdict} {name}".ljust(64)
        + f"  base {judged['base'].left_out * unit:.3g} named {named} best {best} "
        f"{judged[best].left_out * unit:.3g}".ljust(52)
        + f"  {judgement(result, judged)}  [{stated}]"
    )


def said_poses(result: TriadResult) -> tuple[str, ...]:
    """The poses that the program used."""
    return result.calibration.fit.poses.label


def pair_line(one: Said, stops: Stops, gravity: float) -> str:
    """How far the calibration of one session is off at the stops of another, and what it stated."""
    result = one.accelerometer
    assert result is not None
    assert result.prediction is not None
    sd = weighted(stops)
    off = corrected_magnitude(result, stops.force) - gravity
    rms = float(np.sqrt(np.average(off**2, weights=sd**-2)))
    alone = float(np.sqrt(len(off) / np.sum(sd**-2)))
    return (f"off by {1e3 * rms:.2f} mm/s² rms, {1e3 * np.abs(off).max():.2f} at most; stops know "
            f"{1e3 * alone:.2f}, stated {prediction_words(result.prediction)}")


def lost_words(lost: LostFace) -> str:
    """What the program says of a session without one face, and how far it is off there."""
    if np.isnan(lost.stated):
        return "refused"
    return (f"{'holds' if lost.said_good else 'said not to hold'}, states {1e3 * lost.stated:.3g} "
            f"mm/s² at worst, errs there by {1e3 * lost.error:.3g}")


def turntable_line() -> str:
    """The gyroscope on somebody's record player: the program beside the independent fit."""
    result, fitted = ask_turntable(), fit_turntable()
    gain = ", ".join(f"{g:.4f}" for g in fitted.gain)
    own = ", ".join(f"{g:.4f}" for g in result.calibration.parameters.scale_counts_per_unit)
    return (
        f"freeimucal gyr: {len(said_poses(result))} poses, {result.diagnosis.verdict} "
        f"{result.diagnosis.name or ''}: gain {own}\n  independent: {fitted.poses} turning poses, "
        f"gain {gain}; the plate's rate scatters by {fitted.scatter:.1e} of itself from pose to "
        f"pose, a bias at rest by {np.degrees(fitted.rest_sd):.3f} °/s"
    )


def means_line() -> str:
    """A table of pose means: the program beside the independent fit."""
    result, fitted = ask_means(), fit_means()
    own, compared = result.calibration.parameters.scale_counts_per_unit, result.comparison
    return (
        f"kerf acc: {len(said_poses(result))} pose means, {result.diagnosis.verdict} "
        f"{', '.join(result.diagnosis.group)}: scale {', '.join(f'{v:.2f}' for v in own)}, "
        f"left-out {1e3 * compared.loo_rms:.2f} mm/s²\n  independent: scale "
        f"{', '.join(f'{v:.2f}' for v in fitted.scale)}, left-out {1e3 * fitted.left_out:.2f} mm/s²"
    )


def main() -> None:
    """Print the three tables."""
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sessions", nargs="*", choices=[*LOGS, []], metavar="SESSION")
    chosen = parser.parse_args().sessions or list(LOGS)
    said = {name: ask(LOGS[name]) for name in chosen}
    stops = {name: stops_of(LOGS[name]) for name in chosen}
    for name in chosen:
        for line in verdict_lines(LOGS[name], said[name], stops[name]):
            print(line)
    print()
    for one, other in PAIRS:
        if one in said and other in stops and said[one].accelerometer is not None:
            print(f"{one} -> {other}: {pair_line(said[one], stops[other], LOGS[other].gravity)}")
    print()
    for name in chosen:
        result = said[name].accelerometer
        for lost in without_each_face(result) if result else ():
            print(f"{name} without {lost.face} ({lost.size} poses): {lost_words(lost)}")
    if chosen == list(LOGS):
        print()
        print(turntable_line())
        print(means_line())


if __name__ == "__main__":
    main()
