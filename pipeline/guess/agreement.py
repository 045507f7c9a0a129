"""Consistency tests that a guess must pass, independent of how it was made.

Before a configuration is tried, the readings in SI units are compared with gravity, with the
turns of gravity and with the clock; afterwards with the fit and the data sheet. A guess that fails
a test is refused with the reason, and no other guess is made.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.numbers import RPM
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.guess.files import LIES_STILL, called_accelerometers, listed, why_no_log
from pipeline.guess.magnitudes import (
    CODES,
    COUNTS_PER_DEG_S,
    LOOSEST,
    NEAR_RANGE,
    typical_length,
)
from pipeline.guess.pool import FEWEST_MEANS, REST_S, reads_alike, usual_step
from pipeline.guess.session import SessionGuess
from pipeline.guess.speeds import speeds_of
from pipeline.guess.table_guess import TURNING_RAD_S, TableGuess
from pipeline.guess.units import FASTEST_RAD_S
from pipeline.stages.run import Outcome

LARGEST_MISFIT = 0.02
"""Largest root mean square residual over the reference, without the noise of the poses, of a model
that can be right. A judgement: the bias of a gyroscope that warms up moves by 2 °/s."""
LARGEST_NONLINEARITY = 0.005
"""The same of an accelerometer with the named effect that explains most. Fact: the nonlinearity in
the data sheet of the cheapest one (MPU-6050). In 37 imports of measured and simulated logs one
sensor leaves 0.0015 at most, and five together 0.01."""
LARGEST_WANDER = 100.0
"""Largest scatter of a gyroscope's bias from pose to pose over the noise of a mean. A judgement:
the bias of a cheap one that warms up moves by 20 times the noise."""


def disagreements(guess: SessionGuess) -> Iterator[str]:
    """Contradictions to the guess of the files, one sentence for the first table of each test."""
    for law in (_other_unit, _no_gravity, _one_axis_twice, _two_accelerometers, _no_unit,
                _several_rates, _other_turns, _too_short):
        yield from [fault for source in guess.sources for table in source.tables
                    if (fault := law(guess, table))][:1]


def unused_accelerometer(guess: SessionGuess) -> str:
    """Why columns named as an accelerometer cannot be one, if there is no other; else empty."""
    return next((f"{table.path}: {why_no_log(table.table)}." for table in guess.tables
                 if guess.accelerometer is None and called_accelerometers(table.table)), "")


def _other_unit(guess: SessionGuess, table: TableGuess) -> str:
    """Files whose readings are no gravity in the unit of the session, which is one for all."""
    unit = None if "accelerometer" in guess.dead else guess.accelerometer
    lengths = {} if unit is None else {each: typical_length(each.si(replace(
        each.accelerometer, si_per_unit=unit.si_per_unit))) for each in guess.tables
        if each.accelerometer}
    off = [each for each, length in lengths.items()
           if not 1 / LOOSEST < length / STANDARD_GRAVITY_M_S2 < LOOSEST]
    if unit is None or table not in off[:1] or len(off) == len(lengths):
        return ""
    return (f"{listed([each.path for each in off])}: a typical reading is {lengths[table]:.3g} "
            f"m/s² long in {unit.unit}, the unit of the other files, and gravity is "
            f"{STANDARD_GRAVITY_M_S2:.3g}. Its unit or its range is another: convert it, or import "
            f"the files of each unit by themselves.")


def _no_gravity(guess: SessionGuess, table: TableGuess) -> str:
    """An accelerometer that reads the same in every rest of all its logs."""
    source = next(source for source in guess.sources if table in source.tables)
    if (table.accelerometer is None or source.layout != "log"
            or _too_short(guess, table)):
        return ""
    force = np.concatenate([each.si(each.accelerometer) for each in source.tables
                            if each.accelerometer])
    alike = reads_alike(force, usual_step(table.clock.time_s))
    return f"{table.path}: {LIES_STILL}." if alike else ""


def _one_axis_twice(guess: SessionGuess, table: TableGuess) -> str:
    """Two axes, of one triad or of both, that hold the same numbers."""
    triads = [triad for triad in (table.accelerometer, table.gyroscope) if triad]
    logs = [each.table.columns for each in guess.tables]  # in one pose few levels may be equal
    for one, other in combinations([name for triad in triads for name in triad.columns], 2):
        both = [(log[one], log[other]) for log in logs if one in log and other in log]
        if all(np.array_equal(*pair) for pair in both) and np.any(both[0][0]):
            return (f"{table.path}: '{one}' and '{other}' hold the same numbers: one axis is "
                    f"written twice and another is missing. Correct what writes the log.")
    return ""


def _two_accelerometers(guess: SessionGuess, table: TableGuess) -> str:
    """Two triads of which one is an accelerometer and the other may be a magnetometer."""
    triad = table.accelerometer
    if triad is None or triad.rival is None:
        return ""
    one, other = (", ".join(columns) for columns in (triad.columns, triad.rival))
    return (f"{table.path}: {one} and {other} have one length in every attitude, as gravity has "
            f"and the magnetic field, and nothing shows which is gravity. Write the names of the "
            f"columns into the first line, as in time_s,acc_x,acc_y,acc_z, or leave the columns of "
            f"the magnetometer out.")


def _no_unit(guess: SessionGuess, table: TableGuess) -> str:
    """A gyroscope whose scale by the turns of gravity is that of no unit and no range."""
    triad = table.gyroscope
    if triad is None or not triad.is_unusual or guess.dead:
        return ""
    measured = CODES / 2 * math.degrees(triad.si_per_unit)
    right = f" If the clock is right, it is --gyroscope-range {measured:.3g}."
    if math.radians(measured) > FASTEST_RAD_S:
        hz = 1 / usual_step(table.clock.time_s)
        rates = ", ".join(f"{hz * able / measured:.3g} for ±{able:g} °/s" for able in (
            CODES / 2 / per_deg for per_deg in COUNTS_PER_DEG_S))
        right = (f" By this clock its range would be ±{measured:.3g} °/s, and no sensor's is as "
                 f"wide. In Hz the turns of gravity show {rates}.")
    return (f"{table.path}: {triad.doubt}: its clock or its unit is another. State it by "
            f"--rate-hz, --gyroscope-unit or --gyroscope-range.{right * bool(triad.encoding)}")


def _several_rates(guess: SessionGuess, table: TableGuess) -> str:
    """A table of means whose rows were taken at several rates of the plate."""
    if not table.are_means or table.gyroscope is None or guess.scales or guess.dead:
        return ""
    length = np.linalg.norm(table.rate(), axis=1)
    rpm = np.array(speeds_of([*np.where(length > TURNING_RAD_S, length, 0.0)])) / RPM
    shares = [f"{(rpm == each).sum()} of its rows " + (
        f"turn at {each:.3g} rpm" if each else "are at rest") for each in np.unique(rpm)]
    return (f"{table.path}: {' and '.join(shares)}. A table of means is of one rate: write the "
            f"rows of each into a file of their own, and import all of these.") if (
                len(shares) > 1) else ""


def _other_turns(guess: SessionGuess, table: TableGuess) -> str:
    """Turns of gravity that differ from those of the gyroscope."""
    turn = None if guess.scales or guess.dead else table.turn(guess.tables)
    if turn is None or not turn.is_exact or abs(math.log(turn.si_per_unit)) < NEAR_RANGE:
        return ""
    return (f"{table.path}: between its rests gravity turns {turn.si_per_unit:.3g} times as far in "
            f"the accelerometer as the gyroscope says (correlation {turn.agreement:.2f}). The unit "
            f"of the gyroscope or that of the clock is another; state it by --gyroscope-unit or "
            f"--rate-hz.")


def _too_short(guess: SessionGuess, table: TableGuess) -> str:
    """A clock by which a log of many poses is too short to place them."""
    source = next(source for source in guess.sources if table in source.tables)
    seconds = sum(float(np.ptp(other.clock.time_s)) for other in source.tables)
    if source.layout != "log" or seconds > FEWEST_MEANS * REST_S:
        return ""
    return (f"{table.path}: its {table.table.rows} rows last {seconds:.3g} s by its clock, in "
            f"which nobody lays {FEWEST_MEANS} poses. Where the log is longer, state its rate by "
            f"--rate-hz; else record it again with rests of a second or more.")


def implausible(outcome: Outcome) -> str | None:
    """Reason why an outcome cannot be right although it fits; None if it is plausible."""
    for result in outcome.triads:
        triad = result.triad
        reference = result.calibration.fit.poses.reference.magnitude
        size = float(np.sqrt(np.mean(reference**2)))
        misfit = result.calibration.fit.chi2 / max(result.calibration.fit.dof, 1)
        rms = result.comparison.residual_rms
        noise = rms / math.sqrt(misfit) if misfit else 0.0
        # What the named effect that explains most would leave.
        least = min((result.diagnosis.listed[name].rms_after for name in result.diagnosis.names
                     if name in result.diagnosis.listed), default=rms)
        whole, rest = (math.sqrt(max(each**2 - noise**2, 0.0)) / size if size else 0.0
                       for each in (rms, least))
        if whole > LARGEST_MISFIT or (triad == "accelerometer" and rest > LARGEST_NONLINEARITY):
            against = TRIAD_KINDS[triad].reference
            return (f"the {triad}'s poses differ from {against} by {whole:.1%} (root mean "
                    f"square), more than any sensor after its calibration. One of these is wrong: "
                    f"its columns, its unit, or files of two sensors or ranges together.")
        if not size and misfit > LARGEST_WANDER**2:
            return (f"the {triad}'s poses at rest scatter by {misfit**0.5:.0f} times their own "
                    f"noise, which no bias does. Its columns are another sensor's, or it moved.")
    return None
